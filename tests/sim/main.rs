//! Virtual time: whole swarms over memory links, every byte through the codecs, many times faster than real time.

mod drives;
mod faults;
mod hostile;
mod journey;
mod support;
