//! What needs a kernel with CAN is in `tests/vcan.rs`.

use super::*;
use socketcan::nl::{CanState, Mtu};

#[test]
fn names_that_cannot_be_an_interface_are_refused_before_anything_is_made() {
    for name in ["", "a/b", "..", "has space", "sixteen-letters-"] {
        let error = VcanInterface::create(name).unwrap_err();
        assert_eq!(error.why, "not an interface's name", "{name:?}");
    }
}

#[test]
fn a_real_interface_is_never_used_for_a_simulation() {
    let mut details = InterfaceDetails::new(7);
    assert!(refuse_real("eth0", &details).unwrap_err().why.contains("not CAN"));
    details.mtu = Some(Mtu::Fd);
    assert_eq!(refuse_real("vcan0", &details), Ok(()));
    details.can.state = Some(CanState::Stopped);
    assert!(refuse_real("can0", &details).unwrap_err().why.contains("a real interface"));
}

#[test]
fn what_the_kernel_answers_becomes_advice() {
    let explained = |errno| explain("vcan7", &socketcan::Error::Io(std::io::Error::from_raw_os_error(errno))).advice;
    assert!(explained(EPERM).contains("sudo ip link add dev vcan7 type vcan"));
    assert!(explained(EOPNOTSUPP).contains("modprobe vcan"));
}
