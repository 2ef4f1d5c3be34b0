#!/usr/bin/env python3
"""A ground station made with pymavlink that arms and drives a (virtual) rover and reads its scan.

    mavlink_gcs.py HOST:PORT [--system N] [--patience S]
    mavlink_gcs.py HOST:PORT --watch S     only look on, for so long, while somebody else drives

Prints one line of JSON on stdout and ends with 0 if everything was as it must be, else 1; `problems` says what was not.
Needs pymavlink 2.4.50.
"""
import argparse
import json
import math
import os
import sys
import time

os.environ["MAVLINK20"] = "1"
from pymavlink import mavutil  # noqa: E402

PREARM = 1 << 28
HOLD, GUIDED = 4, 15
DO_SET_MODE, ARM_DISARM, SET_INTERVAL, NOBODYS_COMMAND = 176, 400, 511, 60980
TWIST_MASK, BODY_NED = 1479, 8
LIDAR_COMPONENT = 196
SPEED = 0.5


class Station:
    """One link, and the newest of every message that came over it."""

    def __init__(self, address, system):
        self.link = mavutil.mavlink_connection(f"udpout:{address}", source_system=255, source_component=190)
        self.system = system
        self.newest = {}
        self.sectors = {}
        self.texts = []
        self.acks = {}
        self.next_heartbeat = 0.0
        self.counts = {}
        self.path = 0.0

    def pump(self, seconds):
        end = time.monotonic() + seconds
        while True:
            now = time.monotonic()
            if now >= self.next_heartbeat:
                self.link.mav.heartbeat_send(6, 8, 0, 0, 4)
                self.next_heartbeat = now + 1.0
            try:
                message = self.link.recv_match(blocking=False)
            except ConnectionError:
                message = None
            if message is not None:
                self.take(message)
            elif now >= end:
                return
            else:
                time.sleep(0.002)

    def take(self, message):
        kind, component = message.get_type(), message.get_srcComponent()
        if message.get_srcSystem() != self.system:
            return
        if component == 1 and kind == "LOCAL_POSITION_NED":
            before = self.position()
            self.path += 0.0 if before is None else math.dist(before, (message.x, message.y))
        self.newest[(component, kind)] = message
        name = f"{component}/{kind}"
        self.counts[name] = self.counts.get(name, 0) + 1
        if component == 1 and kind == "DISTANCE_SENSOR":
            self.sectors[message.orientation] = message.current_distance
        elif kind == "STATUSTEXT":
            self.texts.append(message.text)
        elif kind == "COMMAND_ACK":
            self.acks[message.command] = message

    def get(self, kind, component=1):
        return self.newest.get((component, kind))

    def until(self, condition, patience):
        end = time.monotonic() + patience
        while time.monotonic() < end:
            self.pump(0.02)
            if condition():
                return True
        return False

    def command(self, command, p1, p2=0.0):
        """The acknowledgement's result, or None."""
        for confirmation in range(4):
            self.acks.pop(command, None)
            self.link.mav.command_long_send(self.system, 1, command, confirmation, p1, p2, 0, 0, 0, 0, 0)
            if self.until(lambda: command in self.acks, 0.7):
                ack = self.acks[command]
                if (ack.target_system, ack.target_component) == (255, 190):
                    return ack.result
        return None

    def drive(self, speed, yaw_rate_right, seconds):
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.link.mav.set_position_target_local_ned_send(
                0, self.system, 1, BODY_NED, TWIST_MASK, 0, 0, 0, speed, 0, 0, 0, 0, 0, 0, yaw_rate_right)
            self.pump(0.1)

    def position(self):
        message = self.get("LOCAL_POSITION_NED")
        return None if message is None else (message.x, message.y)

    def speed(self):
        message = self.get("LOCAL_POSITION_NED")
        return None if message is None else (message.vx ** 2 + message.vy ** 2) ** 0.5


class Report:
    def __init__(self):
        self.facts, self.problems = {}, []

    def check(self, name, value, good):
        self.facts[name] = value
        if not good:
            self.problems.append(f"{name}: {value}")
        return good


def bring_up(station, report, patience):
    start = time.monotonic()
    seen = station.until(lambda: station.get("HEARTBEAT") is not None, patience)
    if not report.check("heartbeat", seen, seen):
        return False
    report.check("vehicle_type", station.get("HEARTBEAT").type, station.get("HEARTBEAT").type == 10)

    def ready():
        status = station.get("SYS_STATUS")
        return status is not None and status.onboard_control_sensors_health & PREARM

    if not report.check("prearm", station.until(ready, patience), bool(ready())):
        return False
    steps = [("hold", DO_SET_MODE, 1, HOLD), ("arm", ARM_DISARM, 1, 0), ("guided", DO_SET_MODE, 1, GUIDED),
             ("position_rate", SET_INTERVAL, 32, 50000)]
    for name, command, p1, p2 in steps:
        result = station.command(command, p1, p2)
        if not report.check(name, result, result == 0):
            return False

    def driving():
        beat = station.get("HEARTBEAT")
        return beat.base_mode & 128 and beat.custom_mode == GUIDED

    ok = station.until(driving, 3.0)
    report.facts["bring_up_s"] = round(time.monotonic() - start, 2)
    return report.check("heartbeat_shows_guided", ok, ok)


def drive_and_watch(station, report):
    before = station.position()
    station.drive(SPEED, 0.0, 2.0)
    after, speed = station.position(), station.speed()
    moved = 0.0 if None in (before, after) else ((after[0] - before[0]) ** 2 + (after[1] - before[1]) ** 2) ** 0.5
    report.check("moved_m", round(moved, 3), 0.4 < moved < 1.2)
    report.check("speed_mps", speed and round(speed, 3), speed is not None and abs(speed - SPEED) < 0.1)
    silent_since = time.monotonic()
    stopped = station.until(lambda: station.speed() < 0.02, 6.0)
    report.check("stopped_after_silence_s", round(time.monotonic() - silent_since, 2) if stopped else None,
                 stopped and 2.5 < time.monotonic() - silent_since < 5.0)
    station.pump(0.3)
    told = [text for text in station.texts if "target not received" in text]
    report.check("timeout_text", told[:1], bool(told))
    result = station.command(NOBODYS_COMMAND, 1)
    report.check("unknown_command", result, result == 3)
    result = station.command(SET_INTERVAL, 32, 20000)
    report.check("50_hz_denied", result, result == 2)


def look_around(station, report):
    scan = station.get("OBSTACLE_DISTANCE", LIDAR_COMPONENT)
    if report.check("scan", scan is not None, scan is not None):
        hits = [cm for cm in scan.distances if 0 < cm <= scan.max_distance]
        report.check("scan_frame", scan.frame, scan.frame == 12)
        report.check("scan_hits", len(hits), True)
        report.check("scan_nearest_m", min(hits) / 100 if hits else None, True)
    none_from_autopilot = station.get("OBSTACLE_DISTANCE") is None
    report.check("no_scan_from_autopilot", none_from_autopilot, none_from_autopilot)
    # Sectors that never saw anything are not told, as on the real autopilot.
    report.check("sectors", dict(sorted(station.sectors.items())), scan is None or not hits or bool(station.sectors))
    bridge = station.get("HEARTBEAT", LIDAR_COMPONENT)
    report.check("bridge_heartbeat", bridge is not None, bridge is not None)


def look_on(station, report, seconds):
    station.pump(seconds)
    beat, scan = station.get("HEARTBEAT"), station.get("OBSTACLE_DISTANCE", LIDAR_COMPONENT)
    report.check("counts", dict(sorted(station.counts.items())), beat is not None and scan is not None)
    report.check("path_m", round(station.path, 3), station.path > 0)
    driven = beat is not None and bool(beat.base_mode & 128) and beat.custom_mode == GUIDED
    report.check("armed_in_guided", driven, driven)
    hits = [] if scan is None else [cm for cm in scan.distances if 0 < cm <= scan.max_distance]
    report.check("scan_hits", len(hits), bool(hits))


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("address")
    parser.add_argument("--system", type=int, default=1)
    parser.add_argument("--patience", type=float, default=30.0)
    parser.add_argument("--watch", type=float, help="only look on, so many seconds")
    arguments = parser.parse_args()
    station, report = Station(arguments.address, arguments.system), Report()
    if arguments.watch is not None:
        look_on(station, report, arguments.watch)
    elif bring_up(station, report, arguments.patience):
        drive_and_watch(station, report)
        look_around(station, report)
        result = station.command(ARM_DISARM, 0)
        report.check("disarm", result, result == 0)
    print(json.dumps({"ok": not report.problems, **report.facts, "problems": report.problems}), flush=True)
    sys.exit(1 if report.problems else 0)


if __name__ == "__main__":
    main()
