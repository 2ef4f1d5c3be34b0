//! What needs a kernel with CAN is in `tests/vcan.rs`.

use super::*;

#[test]
fn names_that_cannot_be_an_interface_are_refused_before_anything_is_made() {
    for name in ["", "a/b", "..", "has space", "sixteen-letters-"] {
        let error = VcanInterface::create(name).unwrap_err();
        assert_eq!(error.why, "not an interface's name", "{name:?}");
    }
}

#[test]
fn a_real_interface_is_never_used_for_a_simulation() {
    assert!(refuse_real("lo").is_ok(), "lo is virtual");
    assert!(refuse_real("no-such-one").unwrap_err().why.contains("real interface"));
}

#[test]
fn what_the_kernel_answers_becomes_advice() {
    let explained = |errno| explain("vcan7", &socketcan::Error::Io(std::io::Error::from_raw_os_error(errno))).advice;
    assert!(explained(EPERM).contains("sudo ip link add dev vcan7 type vcan"));
    assert!(explained(EOPNOTSUPP).contains("modprobe vcan"));
}

#[test]
fn loopback_is_seen_to_be_up_and_an_absent_interface_is_not() {
    assert!(is_up("lo"));
    assert!(!is_up("no-such-one"));
}
