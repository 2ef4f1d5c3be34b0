//! World <-> UDP MAVLink and CAN buses, paced to the wall clock.
