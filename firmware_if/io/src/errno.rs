//! What Linux's error numbers mean for a link (errno(3); values of `asm-generic/errno.h`).

use drover_contract::LinkError;
use std::io;

pub(crate) const EPERM: i32 = 1;
pub(crate) const ENXIO: i32 = 6;
pub(crate) const EACCES: i32 = 13;
pub(crate) const EBUSY: i32 = 16;
pub(crate) const ENODEV: i32 = 19;
pub(crate) const EINVAL: i32 = 22;
pub(crate) const EOPNOTSUPP: i32 = 95;
pub(crate) const EAFNOSUPPORT: i32 = 97;
pub(crate) const EADDRINUSE: i32 = 98;
pub(crate) const EADDRNOTAVAIL: i32 = 99;
pub(crate) const ENETDOWN: i32 = 100;
pub(crate) const ENETUNREACH: i32 = 101;
pub(crate) const ENOBUFS: i32 = 105;
pub(crate) const ECONNREFUSED: i32 = 111;
pub(crate) const EHOSTDOWN: i32 = 112;
pub(crate) const EHOSTUNREACH: i32 = 113;

/// Nothing to read now, or a signal came between: not a fault.
pub(crate) fn is_nothing_now(error: &io::Error) -> bool {
    matches!(error.kind(), io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted)
}

/// What `error` means for a link.
pub(crate) fn link_error(error: &io::Error) -> LinkError {
    if is_nothing_now(error) {
        return LinkError::Full;
    }
    match error.raw_os_error() {
        Some(ENOBUFS) => LinkError::Full,
        Some(ECONNREFUSED) => LinkError::Down("nobody listens at the other end".into()),
        Some(ENETDOWN | ENETUNREACH | EHOSTUNREACH | EHOSTDOWN | EADDRNOTAVAIL) => LinkError::Down(error.to_string()),
        Some(ENODEV | ENXIO) => LinkError::Gone(error.to_string()),
        _ => LinkError::Os(error.to_string()),
    }
}
