#!/usr/bin/env python3
"""A host of an AgileX chassis made with python-can: enables it, drives it, falls silent and sees it stop.

    can_agilex_host.py INTERFACE [--speed MPS] [--brake MPS2] [--patience S]

What is checked: in standby a motion command moves nothing; 0x421 = 1 brings CAN mode; driven at 50 Hz the speed fed
back (0x221) rises to what was asked and the odometer (0x311) goes on accordingly; after the last command the speed is
held for at least 450 ms and is 0 within 500 ms, braking and a tolerance; the chassis stays in CAN mode meanwhile.

Prints one line of JSON on stdout and ends with 0 if everything was as it must be, else 1; `problems` says what was not.
Needs python-can 4.6.1 and SocketCAN.
"""
import argparse
import json
import struct
import sys
import time

import can

COMMAND, MODE, STATE, MOTION, ODOMETER = 0x111, 0x421, 0x211, 0x221, 0x311
WATCHDOG_S, EARLIEST_S, TOLERANCE_S = 0.5, 0.45, 0.25
STANDING_MPS = 0.006


class Host:
    """One bus, and what the chassis said last."""

    def __init__(self, interface):
        self.bus = can.Bus(interface="socketcan", channel=interface)
        self.mode = None
        self.speeds = []  # (when, m/s)
        self.odometer = None

    def send(self, identifier, data):
        self.bus.send(can.Message(arbitration_id=identifier, data=data, is_extended_id=False))

    def command(self, speed):
        self.send(COMMAND, struct.pack(">hhhh", round(speed * 1000), 0, 0, 0))

    def pump(self, until):
        """Listen until this moment."""
        while (left := until - time.monotonic()) > 0:
            message = self.bus.recv(left)
            if message is not None and not message.is_extended_id and not message.is_error_frame:
                self.take(message)

    def take(self, message):
        if message.arbitration_id == STATE and message.dlc == 8:
            self.mode = message.data[1]
        elif message.arbitration_id == MOTION and message.dlc == 8:
            self.speeds.append((time.monotonic(), struct.unpack(">h", message.data[:2])[0] / 1000))
        elif message.arbitration_id == ODOMETER and message.dlc == 8:
            self.odometer = struct.unpack(">ii", message.data)

    def wait(self, condition, seconds):
        end = time.monotonic() + seconds
        while not condition() and time.monotonic() < end:
            self.pump(time.monotonic() + 0.01)
        return condition()

    def drive(self, speed, seconds):
        """Command at 50 Hz; the moment of the last command."""
        end, due = time.monotonic() + seconds, time.monotonic()
        last = due
        while due < end:
            last = time.monotonic()
            self.command(speed)
            due += 0.02
            self.pump(due)
        return last


def stop_times(speeds, last, speed):
    """Seconds from the last command until the speed left what was asked, and until the chassis stood."""
    after = [(when - last, abs(value)) for when, value in speeds if when >= last]
    fell = next((when for when, value in after if value < 0.9 * speed), None)
    stood = next((when for when, value in after if value <= STANDING_MPS), None)
    return fell, stood


def check_stop(speed, brake, fell, stood, problems):
    latest = WATCHDOG_S + speed / brake + TOLERANCE_S
    if fell is None or stood is None:
        problems.append("the chassis did not stop after silence")
    elif fell < EARLIEST_S:
        problems.append(f"the speed fell {fell:.3f} s after the last command, before {EARLIEST_S} s")
    elif stood > latest:
        problems.append(f"the chassis stood {stood:.3f} s after the last command, later than {latest:.3f} s")


def run(options):
    host, problems = Host(options.interface), []
    if not host.wait(lambda: host.mode is not None and host.odometer is not None, options.patience):
        return {"problems": [f"no 0x211 and 0x311 within {options.patience} s"]}
    first_mode = host.mode
    host.drive(options.speed, 0.2)
    host.pump(time.monotonic() + 0.1)
    if first_mode == 0 and any(abs(value) > STANDING_MPS for _, value in host.speeds):
        problems.append("it moved in standby")
    host.send(MODE, [1])
    if not host.wait(lambda: host.mode == 1, options.patience):
        problems.append("it did not go into CAN mode")
    before = host.odometer
    last = host.drive(options.speed, 1.5)
    reached = max(value for _, value in host.speeds)
    if abs(reached - options.speed) > 0.1 * options.speed:
        problems.append(f"it reached {reached} m/s and not {options.speed} m/s")
    host.pump(last + WATCHDOG_S + options.speed / options.brake + 2 * TOLERANCE_S)
    travel = [(now - then) / 1000 for now, then in zip(host.odometer, before)]
    if not all(0.5 * options.speed < side < 4.0 * options.speed for side in travel):
        problems.append(f"the odometer went on by {travel} m")
    fell, stood = stop_times(host.speeds, last, options.speed)
    check_stop(options.speed, options.brake, fell, stood, problems)
    if host.mode != 1:
        problems.append(f"after silence it is in mode {host.mode} and not in CAN mode")
    host.send(MODE, [0])
    host.bus.shutdown()
    return {"mode_at_first": first_mode, "speed_mps": reached, "travel_m": travel, "fell_after_s": fell,
            "stood_after_s": stood, "feedback_frames": len(host.speeds), "problems": problems}


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("interface")
    parser.add_argument("--speed", type=float, default=0.25, help="m/s (default 0.25)")
    parser.add_argument("--brake", type=float, default=0.5, help="braking that the body is sure to reach, m/s^2")
    parser.add_argument("--patience", type=float, default=5.0, help="how long to wait for each answer, s")
    result = run(parser.parse_args())
    print(json.dumps(result))
    return 1 if result["problems"] else 0


if __name__ == "__main__":
    sys.exit(main())
