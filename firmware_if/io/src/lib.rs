//! The only crate that opens a socket: UDP, SocketCAN, memory, recorder.
