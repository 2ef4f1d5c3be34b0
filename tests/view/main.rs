//! The live page in a real Chromium, against the real binary.
//!
//! The browser is driven by `page.py`, run by the Python that `DROVER_PEERS_PYTHON` names (`tests/run` makes it). What
//! the page shows is compared with what the simulator knows and with how the process ends. Pictures of what was seen go
//! into `target/view-artefacts`.

#[path = "../common/mod.rs"]
mod common;

mod live;
mod recording;
mod server;
mod support;
