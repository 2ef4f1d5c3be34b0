//! Movers in recordings: at every moment each is where it truly was.

use drover_config::load_swarm;
use drover_record::RecordingFile;
use drover_swarm::{Batch, Fidelity, trial_of};
use std::path::Path;
use std::sync::atomic::AtomicBool;

/// What is written is rounded to a ten-thousandth.
const ROUNDED_M: f64 = 1e-4;

#[test]
fn a_recording_has_every_mover_where_it_truly_was_all_the_time() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("config/swarms/flock_mover.toml");
    let swarm = load_swarm(&path, &[]).unwrap_or_else(|problems| panic!("{problems}"));
    let folder = tempfile::tempdir().expect("a folder");
    let batch = Batch {
        swarm: swarm.name.clone(),
        seeds: vec![swarm.seed],
        fidelity: Fidelity::Direct,
        record_to: Some(folder.path().to_owned()),
        load: |_| Ok(swarm.clone()),
        on_progress: |_| {},
    };
    batch.run(&AtomicBool::new(false)).expect("it runs");
    let recording = folder.path().join(format!("seed-{}/run.mcap", swarm.seed));
    let file = RecordingFile::open(&recording).unwrap_or_else(|error| panic!("{error}"));
    let moments = file.moments(false);
    assert!(moments.len() > 800, "ten a second for 90 s: {}", moments.len());

    // The same seed again is the same run.
    let mut again = trial_of(&swarm, Fidelity::Direct, None).expect("opens");
    let (mut moved, mut waited) = (0, 0);
    for pair in moments.windows(2) {
        while again.now().as_secs_f64() < pair[1].time_s - 1e-6 {
            again.step();
        }
        let truth_m: Vec<[f64; 2]> = again.arena().movers().map(|(at_w, _)| [at_w.x, at_w.y]).collect();
        let (before_m, now_m) = (&pair[0].movers_m, &pair[1].movers_m);
        assert_eq!((before_m.len(), now_m.len(), truth_m.len()), (2, 2, 2), "{:?}", pair[1]);
        for mover in 0..2 {
            let off_m = apart_m(now_m[mover], truth_m[mover]);
            assert!(off_m <= ROUNDED_M, "mover {mover} at {} s: {off_m} m off", pair[1].time_s);
            let went = apart_m(now_m[mover], before_m[mover]) > 10.0 * ROUNDED_M;
            *if went { &mut moved } else { &mut waited } += 1;
        }
    }
    assert!(moved > 0 && waited > 0, "they go, and wait for robots: {moved} {waited}");
}

fn apart_m(one_m: [f64; 2], other_m: [f64; 2]) -> f64 {
    (one_m[0] - other_m[0]).hypot(one_m[1] - other_m[1])
}
