//! The live view's server, over real sockets on loopback.

use drover_live::{Feed, Live, LiveOptions};
use drover_record::{Control, Controls, Moment, RobotMoment, ScanMoment, Setting};
use futures_util::{SinkExt, StreamExt};
use serde_json::Value;
use std::net::SocketAddr;
use std::time::Duration;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::mpsc::Receiver;
use tokio::time::timeout;
use tokio_tungstenite::tungstenite::client::IntoClientRequest;
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

const SOON: Duration = Duration::from_secs(20);
const STOP_ALONE: Controls = Controls { stop: true, pace: false, restart: false, seek: false };

type Socket = WebSocketStream<MaybeTlsStream<TcpStream>>;

fn setting(swarm: &str) -> Setting {
    Setting { swarm: swarm.to_owned(), ..Setting::default() }
}

fn moment(time_s: f64) -> Moment {
    Moment { time_s, ..Moment::default() }
}

async fn start(token: Option<&str>) -> (Live, Feed, Receiver<Control>) {
    let (feed, controls) = Feed::new(setting("first"), STOP_ALONE);
    let address = SocketAddr::from(([127, 0, 0, 1], 0));
    let options = LiveOptions { address, token: token.map(str::to_owned) };
    (Live::start(options, feed.clone()).await.unwrap(), feed, controls)
}

/// The head and the body of the answer to a request with these lines.
async fn ask(live: &Live, lines: &[&str]) -> (String, String) {
    let mut stream = TcpStream::connect(live.address()).await.unwrap();
    let request = format!("{}\r\nConnection: close\r\n\r\n", lines.join("\r\n"));
    stream.write_all(request.as_bytes()).await.unwrap();
    let mut answer = String::new();
    timeout(SOON, stream.read_to_string(&mut answer)).await.unwrap().unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    (head.to_lowercase(), body.to_owned())
}

fn host(live: &Live) -> String {
    format!("Host: {}", live.address())
}

async fn open(live: &Live) -> Socket {
    connect_async(format!("ws://{}/live", live.address())).await.unwrap().0
}

async fn hear(socket: &mut Socket) -> Value {
    loop {
        match timeout(SOON, socket.next()).await.unwrap().unwrap().unwrap() {
            Message::Text(text) => return serde_json::from_str(&text).unwrap(),
            Message::Ping(_) => {}
            other => panic!("not text: {other:?}"),
        }
    }
}

#[tokio::test]
async fn the_page_and_its_parts_come_with_headers_that_keep_others_out() {
    let (live, _feed, _controls) = start(None).await;
    for (path, kind) in [("/", "text/html"), ("/style.css", "text/css"), ("/app/main.js", "text/javascript")] {
        let (head, body) = ask(&live, &[&format!("GET {path} HTTP/1.1"), &host(&live)]).await;
        assert!(head.starts_with("http/1.1 200"), "{head}");
        assert!(head.contains(&format!("content-type: {kind}")), "{head}");
        for header in [
            "content-security-policy: default-src 'none'",
            "x-content-type-options: nosniff",
            "x-frame-options: deny",
            "referrer-policy: no-referrer",
            "cache-control: no-store",
        ] {
            assert!(head.contains(header), "{path} lacks {header}");
        }
        assert!(!body.is_empty());
    }
    assert!(ask(&live, &["GET /healthz HTTP/1.1", &host(&live)]).await.0.starts_with("http/1.1 200"));
    assert!(ask(&live, &["GET /nothing HTTP/1.1", &host(&live)]).await.0.starts_with("http/1.1 404"));
}

#[tokio::test]
async fn another_host_name_is_turned_away_everywhere() {
    let (live, _feed, _controls) = start(None).await;
    for path in ["/", "/live", "/style.css", "/healthz", "/nothing"] {
        let (head, body) = ask(&live, &[&format!("GET {path} HTTP/1.1"), "Host: evil.example"]).await;
        assert!(head.starts_with("http/1.1 403"), "{path}: {head}");
        assert!(body.contains("address that drover printed"));
        assert!(head.contains("x-frame-options"));
    }
}

#[tokio::test]
async fn a_page_of_another_site_gets_no_socket() {
    let (live, feed, _controls) = start(None).await;
    for (origin, status) in [("http://evil.example", 403), ("null", 403), (&format!("http://{}", live.address()), 101)]
    {
        let mut request = format!("ws://{}/live", live.address()).into_client_request().unwrap();
        request.headers_mut().insert("Origin", origin.parse().unwrap());
        let got = match connect_async(request).await {
            Ok((_, response)) => response.status(),
            Err(Error::Http(response)) => response.status(),
            Err(error) => panic!("{error}"),
        };
        assert_eq!(got.as_u16(), status, "{origin}");
    }
    drop(feed);
}

#[tokio::test]
async fn where_a_token_is_set_the_page_and_the_socket_need_it() {
    let (live, _feed, _controls) = start(Some("0123456789abcdef")).await;
    let (head, body) = ask(&live, &["GET / HTTP/1.1", &host(&live)]).await;
    assert!(head.starts_with("http/1.1 401"));
    assert!(body.contains("?token="));
    assert!(!body.contains("0123456789abcdef"));
    let (head, _) = ask(&live, &["GET /?token=0123456789abcdef HTTP/1.1", &host(&live)]).await;
    assert!(head.starts_with("http/1.1 200"));
    assert!(connect_async(format!("ws://{}/live", live.address())).await.is_err());
    assert!(connect_async(format!("ws://{}/live?token=wrong", live.address())).await.is_err());
    let with_token = live.url().replace("http", "ws").replace("/?", "/live?");
    let (mut socket, _) = connect_async(with_token).await.unwrap();
    assert_eq!(hear(&mut socket).await["type"], "setting");
}

#[tokio::test]
async fn a_page_hears_the_setting_then_moments_and_the_new_setting_after_a_restart() {
    let (live, feed, _controls) = start(None).await;
    feed.show(moment(1.0));
    assert!(!feed.is_watched());
    let mut socket = open(&live).await;
    let first = hear(&mut socket).await;
    assert_eq!(first["type"], "setting");
    assert_eq!(first["setting"]["swarm"], "first");
    assert_eq!(first["controls"]["stop"], true);
    assert!(feed.is_watched());
    assert_eq!(hear(&mut socket).await["moment"]["time_s"], 1.0);
    feed.show(moment(2.0));
    assert_eq!(hear(&mut socket).await["moment"]["time_s"], 2.0);
    feed.begin(setting("second"), STOP_ALONE);
    assert_eq!(hear(&mut socket).await["setting"]["swarm"], "second");
    feed.show(moment(0.1));
    assert_eq!(hear(&mut socket).await["moment"]["time_s"], 0.1);
}

#[tokio::test]
async fn a_control_arrives_and_what_is_not_allowed_or_no_control_is_refused() {
    let (live, _feed, mut controls) = start(None).await;
    let mut socket = open(&live).await;
    hear(&mut socket).await;
    socket.send(Message::text(r#"{"do":"stop"}"#)).await.unwrap();
    assert_eq!(timeout(SOON, controls.recv()).await.unwrap(), Some(Control::Stop));
    let garbage = ["", "{", "null", "stop", r#"{"do":"fly"}"#, r#"{"do":"speed"}"#, r#"{"do":"speed","rate":1e999}"#];
    for text in garbage.into_iter().chain([r#"{"do":"pause"}"#, r#"{"do":"restart"}"#, r#"{"do":"seek","time_s":1}"#]) {
        socket.send(Message::text(text)).await.unwrap();
        let told = hear(&mut socket).await;
        assert_eq!(told["type"], "refused", "{text}");
        assert!(!told["why"].as_str().unwrap().is_empty());
    }
    socket.send(Message::binary(vec![0xff; 100])).await.unwrap();
    assert_eq!(hear(&mut socket).await["type"], "refused");
    assert!(controls.try_recv().is_err());
}

#[tokio::test]
async fn a_message_that_is_too_long_ends_that_client_alone() {
    let (live, feed, mut controls) = start(None).await;
    let mut socket = open(&live).await;
    let mut other = open(&live).await;
    hear(&mut socket).await;
    hear(&mut other).await;
    socket.send(Message::text("x".repeat(5000))).await.unwrap();
    let ended = async { while let Some(Ok(_)) = socket.next().await {} };
    timeout(SOON, ended).await.unwrap();
    assert!(feed.is_watched());
    other.send(Message::text(r#"{"do":"stop"}"#)).await.unwrap();
    assert_eq!(timeout(SOON, controls.recv()).await.unwrap(), Some(Control::Stop));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_does_not_read_holds_up_neither_the_producer_nor_others_nor_its_own_stop() {
    let (live, feed, mut controls) = start(None).await;
    let mut slow = open(&live).await;
    let mut quick = open(&live).await;
    hear(&mut quick).await;
    let ranges_m = vec![Some(1.2345); 20_000];
    for number in 1..=300_u32 {
        let scan = ScanMoment { time_s: f64::from(number), ranges_m: ranges_m.clone(), ..ScanMoment::default() };
        let robot = RobotMoment { id: 1, scan: Some(scan), ..RobotMoment::default() };
        feed.show(Moment { time_s: f64::from(number), robots: vec![robot], ..Moment::default() });
    }
    while hear(&mut quick).await["moment"]["time_s"] != 300.0 {}
    slow.send(Message::text(r#"{"do":"stop"}"#)).await.unwrap();
    assert_eq!(timeout(SOON, controls.recv()).await.unwrap(), Some(Control::Stop));
}

#[tokio::test]
async fn no_more_clients_than_agreed_and_a_seat_is_free_again_when_one_goes() {
    let (live, feed, _controls) = start(None).await;
    let mut sockets = Vec::new();
    for _ in 0..32 {
        sockets.push(open(&live).await);
    }
    assert!(connect_async(format!("ws://{}/live", live.address())).await.is_err());
    sockets.clear();
    let unwatched = async {
        while feed.is_watched() {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(SOON, unwatched).await.unwrap();
    hear(&mut open(&live).await).await;
}

#[tokio::test]
async fn a_page_is_told_when_the_server_goes_and_the_port_is_free_again() {
    let (live, feed, _controls) = start(None).await;
    let address = live.address();
    let options = LiveOptions { address, token: None };
    let taken = Live::start(options.clone(), feed.clone()).await.unwrap_err();
    assert!(taken.to_string().contains("the port is taken"));
    let mut socket = open(&live).await;
    hear(&mut socket).await;
    drop(live);
    let goodbye = timeout(SOON, socket.next()).await.unwrap().unwrap().unwrap();
    assert!(matches!(goodbye, Message::Close(Some(frame)) if u16::from(frame.code) == 1001));
    let again = async {
        while Live::start(options.clone(), feed.clone()).await.is_err() {
            tokio::time::sleep(Duration::from_millis(5)).await;
        }
    };
    timeout(SOON, again).await.unwrap();
}
