//! The swarm live in a browser: one page, served by this process, fed with moments.
//!
//! Whoever runs a swarm holds a [`Feed`], shows it moments and receives what the page asks for. [`Live`] serves the
//! page and a WebSocket. The producer is never held up: a moment is put down and left, the newest replaces all older
//! ones, and text is made of it when a client takes it, once for all of them.
//!
//! | path | what |
//! |---|---|
//! | `/` | the page |
//! | `/style.css`, `/app/*.js` | its parts; they hold nothing of the swarm |
//! | `/live` | the WebSocket: `setting`, `moment` and `refused` to the page, `Control` from it |
//! | `/healthz` | "ok" |
//!
//! Other websites reach nothing here: see `access`.

mod access;
mod client;
mod feed;
mod page;
mod server;

pub use feed::Feed;
pub use server::{Live, LiveOptions};
