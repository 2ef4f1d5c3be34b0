//! Peers, estimate, laws, limit, supervisor: pure functions and small state machines.
