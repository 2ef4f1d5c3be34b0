//! Virtual time: whole swarms over memory links, every byte through the codecs, many times faster than real time.

mod deploy;
mod determinism;
mod drives;
mod explore;
mod faults;
mod fidelity;
mod flock;
mod hostile;
mod journey;
mod mirror;
mod movers;
mod replay;
mod shadow;
mod support;
mod swarms;
