//! Virtual CAN interfaces made for a run.

use crate::OpenError;
use crate::errno::{EACCES, EBUSY, EINVAL, EOPNOTSUPP, EPERM};
use crate::socketcan::{no_can, raw_socket};
use socketcan::CanInterface;
use socketcan::nl::InterfaceDetails;

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
        match CanInterface::open(name) {
            Ok(interface) => Self::use_present(name, &interface),
            Err(_no_such_interface) => Self::make(name),
        }
    }

    fn use_present(name: &str, interface: &CanInterface) -> Result<Self, OpenError> {
        let details = interface.details().map_err(|error| explain(name, &error))?;
        refuse_real(name, &details)?;
        if !details.is_up {
            interface.bring_up().map_err(|error| explain(name, &error))?;
        }
        Ok(Self { name: name.to_owned(), made: None })
    }

    fn make(name: &str) -> Result<Self, OpenError> {
        let interface = CanInterface::create_vcan(name, None).map_err(|error| explain(name, &error))?;
        let up = interface.bring_up().map_err(|error| explain(name, &error));
        // Whatever came of it: what was made goes with this.
        let made = Self { name: name.to_owned(), made: Some(interface) };
        up.map(|()| made)
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

/// A controller has a clock and a state; a virtual interface has neither.
fn refuse_real(name: &str, details: &InterfaceDetails) -> Result<(), OpenError> {
    let advice = "give the robot of the simulation another interface name";
    if details.mtu.is_none() {
        return Err(OpenError::new(name, "an interface that is not CAN has this name", advice));
    }
    if details.can.state.is_some() || details.can.clock.is_some() {
        let why = "a real interface has this name, and a simulated firmware would speak to whatever hangs on it";
        return Err(OpenError::new(name, why, advice));
    }
    Ok(())
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
