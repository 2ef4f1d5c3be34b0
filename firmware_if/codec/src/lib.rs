//! Bytes <-> contract: MAVLink, AgileX, DroneCAN, beacon. No sockets, no clock.
