//! Virtual CAN interfaces made for a run.

use crate::OpenError;
use crate::errno::{EACCES, EBUSY, EINVAL, EOPNOTSUPP, EPERM};
use crate::socketcan::{no_can, raw_socket};
use socketcan::CanInterface;
use std::path::Path;

/// Longest name of an interface (IFNAMSIZ less its end).
const NAME_MAX: usize = 15;

/// Whether this kernel speaks CAN. A virtual interface may still be refused: see [`VcanInterface::create`].
#[must_use]
pub fn kernel_has_can() -> bool {
    raw_socket().is_ok()
}

/// A virtual CAN interface that is up. One that was made here is deleted when this is dropped.
#[derive(Debug)]
pub struct VcanInterface {
    name: String,
    made: Option<CanInterface>,
}

impl VcanInterface {
    /// Make the interface `name`, or use the virtual one that is there already, and bring it up.
    ///
    /// # Errors
    /// [`OpenError`] with what to do: no CAN in this kernel, no permission, or a real interface of that name, which a
    /// simulated firmware must never speak on.
    pub fn create(name: &str) -> Result<Self, OpenError> {
        if name.is_empty() || name.len() > NAME_MAX || name.contains(['/', ' ']) || name.starts_with('.') {
            return Err(OpenError::new(name, "not an interface's name", "use at most 15 letters and digits"));
        }
        if !kernel_has_can() {
            return Err(no_can(name));
        }
        let (interface, made) = match CanInterface::open(name) {
            Ok(interface) => {
                refuse_real(name)?;
                (interface, false)
            }
            Err(_no_such_interface) => {
                (CanInterface::create_vcan(name, None).map_err(|error| explain(name, &error))?, true)
            }
        };
        let up = interface.bring_up().map_err(|error| explain(name, &error));
        let this = Self { name: name.to_owned(), made: made.then_some(interface) };
        // A virtual interface that is up already needs no permission.
        match up {
            Err(error) if made || !is_up(name) => Err(error),
            Ok(()) | Err(_) => Ok(this),
        }
    }

    /// The interface's name.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }
}

impl Drop for VcanInterface {
    fn drop(&mut self) {
        if let Some(interface) = self.made.take()
            && let Err((_, error)) = interface.delete()
        {
            tracing::warn!(interface = self.name, %error, "the virtual CAN interface could not be deleted");
        }
    }
}

fn refuse_real(name: &str) -> Result<(), OpenError> {
    if Path::new("/sys/devices/virtual/net").join(name).exists() {
        return Ok(());
    }
    Err(OpenError::new(
        name,
        "a real interface has this name, and a simulated firmware would speak to whatever hangs on it",
        "give the robot of the simulation another interface name",
    ))
}

fn is_up(name: &str) -> bool {
    let flags = std::fs::read_to_string(Path::new("/sys/class/net").join(name).join("flags")).unwrap_or_default();
    let flags = u32::from_str_radix(flags.trim().trim_start_matches("0x"), 16).unwrap_or_default();
    flags & 1 == 1
}

fn explain(name: &str, error: &socketcan::Error) -> OpenError {
    let errno = match error {
        socketcan::Error::Io(error) => error.raw_os_error(),
        socketcan::Error::Nl(error) => error.errno(),
        // Which further kinds there are depends on the crate's features; none of them comes from netlink.
        _ => None,
    };
    match errno.map(i32::abs) {
        Some(EPERM | EACCES) => OpenError::new(
            name,
            "only an administrator may make a virtual CAN interface",
            format!(
                "make it once with `sudo ip link add dev {name} type vcan && sudo ip link set {name} up`, or run as \
                 root"
            ),
        ),
        Some(EOPNOTSUPP | EINVAL) => OpenError::new(
            name,
            "this kernel has CAN but no virtual CAN interfaces",
            "load them with `sudo modprobe vcan`, or run the command as `tests/with-vcan COMMAND`",
        ),
        Some(EBUSY) => OpenError::new(name, "the interface is busy", "try again"),
        _ => OpenError::new(name, error.to_string(), "see `ip -details link show`"),
    }
}

#[cfg(test)]
mod tests;
