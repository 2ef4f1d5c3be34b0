//! Real time, real UDP, real processes: the binary as a user runs it.

#[path = "../common/mod.rs"]
mod common;

mod command_line;
mod guard;
mod kills;
mod recordings;
mod simulate;
mod up;
