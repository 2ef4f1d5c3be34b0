//! Real CAN sockets on real (virtual) interfaces. These tests fail where the kernel has no CAN; `tests/run-vcan` builds
//! them and runs them where it has (`tests/with-vcan`), one after another: interface names derive from robots' ids.

#[path = "../common/mod.rs"]
mod common;
#[path = "../conformance/support.rs"]
mod support;

mod babble;
mod faults;
mod peers;
mod scout;
mod up;
