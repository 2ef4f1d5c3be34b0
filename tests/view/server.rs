//! The server goes, or asks who is there.

use crate::common::first_toml;
use crate::support::{Browser, Shown, alone, assert_clean, fleet_file};
use serde_json::json;

/// What a browser says by itself of a connection that cannot be made; the page can do nothing about it.
const FAILED_ATTEMPT: &str = "WebSocket connection to";

#[test]
fn a_page_finds_the_next_run_by_itself_after_the_server_was_killed() {
    let _alone = alone();
    let first = Shown::up(&first_toml(), "127.0.0.1:0", &[]);
    let address = first.address().to_owned();
    let mut browser = Browser::open("reconnect", &first);
    assert_eq!(browser.line()["event"], "connected");
    first.kill();
    let gone = browser.line();
    assert_eq!(gone["event"], "gone", "{gone:#}");
    assert_eq!(gone["words"], "server gone, trying again");
    // Whoever presses STOP now must learn that nothing was sent, and what else there is.
    let result = gone["result"].as_str().expect("text");
    assert!(result.contains("nothing was sent") && result.contains("drover stop"), "{result}");
    assert_eq!(gone["before_phase"], "\"was \"", "an old state is shown as if it were today's");
    assert!(gone["hint"].as_str().is_some_and(|hint| hint.contains("not connected")), "{gone:#}");

    let second = Shown::up(&first_toml(), &address, &[]);
    let found = browser.found();
    assert_eq!(found["words"], "connected");
    assert_eq!(found["result"], "", "an old answer stands beside the new run");
    assert_eq!(found["hooks"]["robots"], "5");
    assert_eq!(found["hosts"], json!([address]));
    let complaints = found["complaints"].as_array().expect("a list");
    let strange = complaints.iter().find(|text| !text.as_str().is_some_and(|text| text.contains(FAILED_ATTEMPT)));
    assert_eq!(strange, None);
    assert_eq!(second.interrupt().0, Some(130));
}

#[test]
fn beyond_loopback_the_page_asks_for_the_token_that_was_printed() {
    let _alone = alone();
    let folder = tempfile::tempdir().expect("a folder");
    let shown = Shown::up(&fleet_file(folder.path(), 6, "room.toml"), "0.0.0.0:0", &["--no-record"]);
    let found = Browser::open("token", &shown).found();
    assert_clean(&found, &shown);
    for refused in found["refused"].as_array().expect("a list") {
        assert_eq!(refused["status"], 401, "{refused:#}");
        let words = refused["words"].as_str().expect("text");
        assert!(words.contains("Use the whole address that drover printed"), "{words}");
    }
    assert_eq!(found["status"], 200);
    assert_eq!(found["hooks"]["robots"], "6");
}
