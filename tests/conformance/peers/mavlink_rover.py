#!/usr/bin/env python3
"""A rover made with pymavlink: the far side of a MAVLink robot, served on a UDP port, with a lidar bridge beside it.

    mavlink_rover.py --port PORT [--system N] [--x EAST --y NORTH --yaw RAD] [--prearm-after S] [--stop-scan-after S]
                     [--stop-all-after S] [--duration S] [--obstacle-m RANGE]

Prints `{"listening": PORT}` when it can be reached, and one line of JSON about what it received when it is told to end
(SIGTERM, SIGINT) or its duration is over. It obeys as an ArduPilot Rover does: armed, in GUIDED, mask 1479, frames 1,
7, 8 and 9, for 3 s after the last setpoint. Needs pymavlink 2.4.50.
"""
import argparse
import io
import json
import math
import os
import signal
import socket
import sys
import time

os.environ["MAVLINK20"] = "1"
from pymavlink.dialects.v20 import common as mav  # noqa: E402

MANUAL, HOLD, GUIDED = 0, 4, 15
PREARM = 1 << 28
SETPOINT_TIMEOUT = 3.0
ACCEL, TURN_ACCEL = 1.0, 2.0


class Rover:
    def __init__(self, arguments):
        self.arguments = arguments
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.bind((arguments.host, arguments.port))
        self.socket.settimeout(0.005)
        self.parser = mav.MAVLink(io.BytesIO())
        self.parser.robust_parsing = True
        self.autopilot = mav.MAVLink(io.BytesIO(), srcSystem=arguments.system, srcComponent=1)
        self.bridge = mav.MAVLink(io.BytesIO(), srcSystem=arguments.system, srcComponent=196)
        self.peer = None
        self.start = time.monotonic()
        self.mode, self.armed = MANUAL, False
        self.north, self.east = arguments.y, arguments.x
        self.yaw = math.pi / 2 - arguments.yaw
        self.speed = self.turn = 0.0
        self.target, self.target_at = (0.0, 0.0), -math.inf
        self.spacing = {0: 1.0, 1: 1.0, 30: 1.0, 32: 1.0, 147: 1.0, 330: 0.1}
        self.due = dict.fromkeys(self.spacing, 0.0)
        self.report = {
            "heartbeats": 0, "setpoints": 0, "setpoints_driven": 0, "bad_setpoints": 0, "commands": [], "frames": 0,
            "bad_frames": 0, "first_armed_s": None, "first_setpoint_s": None, "last_setpoint_s": None,
            "setpoint_gap_s_max": 0.0, "speed_mps_max": 0.0, "path_m": 0.0, "sources": [], "sequence_gaps": 0,
            "setpoint_kinds": [], "asked_mps_max": 0.0, "last_moving_setpoint_s": None, "standing_setpoints": 0,
            "last_scan_s": None, "disarmed_s": None, "speed_mps_at_disarm": None,
        }
        self.sequence = {}

    def time(self):
        return time.monotonic() - self.start

    def send(self, speaker, message):
        if self.peer is not None:
            try:
                self.socket.sendto(message.pack(speaker), self.peer)
            except ConnectionError:
                pass

    def receive(self):
        try:
            data, peer = self.socket.recvfrom(2048)
        except (TimeoutError, socket.timeout, ConnectionError):
            return
        self.peer = peer
        try:
            messages = self.parser.parse_buffer(data) or []
        except mav.MAVError:
            messages = []
        for message in messages:
            if message.get_type() == "BAD_DATA":
                self.report["bad_frames"] += 1
            else:
                self.take(message)

    def take(self, message):
        self.report["frames"] += 1
        source = [message.get_srcSystem(), message.get_srcComponent()]
        if source not in self.report["sources"]:
            self.report["sources"].append(source)
        expected = (self.sequence.get(tuple(source), message.get_seq() - 1) + 1) & 255
        self.report["sequence_gaps"] += message.get_seq() != expected
        self.sequence[tuple(source)] = message.get_seq()
        kind = message.get_type()
        if kind == "HEARTBEAT":
            self.report["heartbeats"] += 1
        elif kind == "COMMAND_LONG":
            self.obey(message)
        elif kind == "SET_POSITION_TARGET_LOCAL_NED":
            self.store(message)
        elif kind == "TIMESYNC" and message.tc1 == 0:
            self.send(self.autopilot, mav.MAVLink_timesync_message(int(self.time() * 1e9) + 1, message.ts1))

    def obey(self, message):
        p1, p2 = message.param1, message.param2
        self.report["commands"].append([message.command, p1, p2])
        del self.report["commands"][:-200]
        result = 0
        if message.command == 176:
            if p2 in (MANUAL, HOLD, GUIDED):
                if self.mode != int(p2):
                    self.target_at = -math.inf
                self.mode = int(p2)
            else:
                result = 4
        elif message.command == 400:
            if p1 == 1 and self.time() < self.arguments.prearm_after:
                result = 4
                self.text(2, "Arm: waiting for a position")
            else:
                self.note_disarm(p1 == 1)
                self.armed = p1 == 1
                if self.armed and self.report["first_armed_s"] is None:
                    self.report["first_armed_s"] = round(self.time(), 3)
        elif message.command == 511:
            result = self.set_interval(int(p1), p2)
        else:
            result = 3
        self.send(self.autopilot, mav.MAVLink_command_ack_message(
            message.command, result, 0, 0, message.get_srcSystem(), message.get_srcComponent()))

    def note_disarm(self, armed):
        if self.armed and not armed:
            self.report["disarmed_s"] = round(self.time(), 3)
            self.report["speed_mps_at_disarm"] = round(self.speed, 3)

    def set_interval(self, message, interval_us):
        if message not in self.spacing or message == 330 or 0 < interval_us < 25000:
            return 2
        self.spacing[message] = math.inf if interval_us < 0 else 1.0 if interval_us == 0 else interval_us * 1e-6
        self.due[message] = 0.0
        return 0

    def store(self, message):
        now, report = self.time(), self.report
        report["setpoints"] += 1
        if report["first_setpoint_s"] is None:
            report["first_setpoint_s"] = round(now, 3)
        else:
            report["setpoint_gap_s_max"] = round(max(report["setpoint_gap_s_max"], now - report["last_setpoint_s"]), 3)
        report["last_setpoint_s"] = round(now, 3)
        self.note_kind(message, now)
        numbers = (message.vx, message.vy, message.yaw_rate)
        if message.type_mask != 1479 or message.coordinate_frame not in (1, 7, 8, 9) or \
                not all(map(math.isfinite, numbers)) or message.target_system != self.arguments.system:
            report["bad_setpoints"] += 1
            return
        if self.mode == GUIDED:
            report["setpoints_driven"] += self.armed
            speed = math.copysign(math.hypot(message.vx, message.vy), message.vx)
            self.target, self.target_at = (speed, message.yaw_rate), now

    def note_kind(self, message, now):
        """What was asked for, how, and since when nothing but to stand."""
        report = self.report
        kind = [message.coordinate_frame, message.type_mask]
        if kind not in report["setpoint_kinds"]:
            report["setpoint_kinds"].append(kind)
        if message.vx != 0.0 or message.vy != 0.0 or message.yaw_rate != 0.0:
            report["last_moving_setpoint_s"], report["standing_setpoints"] = round(now, 3), 0
            report["asked_mps_max"] = round(max(report["asked_mps_max"], message.vx), 3)
        else:
            report["standing_setpoints"] += 1

    def move(self, dt):
        fresh = self.time() - self.target_at < SETPOINT_TIMEOUT
        speed, turn = self.target if self.armed and self.mode == GUIDED and fresh else (0.0, 0.0)
        self.speed += max(-ACCEL * dt, min(ACCEL * dt, speed - self.speed))
        self.turn += max(-TURN_ACCEL * dt, min(TURN_ACCEL * dt, turn - self.turn))
        self.yaw += self.turn * dt
        self.north += self.speed * math.cos(self.yaw) * dt
        self.east += self.speed * math.sin(self.yaw) * dt
        self.report["path_m"] += abs(self.speed) * dt
        self.report["speed_mps_max"] = max(self.report["speed_mps_max"], abs(self.speed))

    def text(self, severity, words):
        self.send(self.autopilot, mav.MAVLink_statustext_message(severity, words.encode()))

    def tell(self):
        now = self.time()
        for message, due in self.due.items():
            if now >= due and self.spacing[message] != math.inf:
                self.due[message] = max(due + self.spacing[message], now)
                self.say(message, now)

    def say(self, message, now):
        boot_ms, ready = int(now * 1000), now >= self.arguments.prearm_after
        if message == 0:
            armed = 128 if self.armed else 0
            self.send(self.autopilot, mav.MAVLink_heartbeat_message(10, 3, 1 | armed, self.mode, 4, 3))
            self.send(self.bridge, mav.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3))
        elif message == 1:
            bits = 0x7 | (PREARM if ready else 0)
            self.send(self.autopilot, mav.MAVLink_sys_status_message(
                bits | PREARM, bits | PREARM, bits, 0, 12600, 150, 90, 0, 0, 0, 0, 0, 0))
        elif message == 30:
            self.send(self.autopilot, mav.MAVLink_attitude_message(
                boot_ms, 0, 0, math.remainder(self.yaw, math.tau), 0, 0, self.turn))
        elif message == 32 and ready:
            self.send(self.autopilot, mav.MAVLink_local_position_ned_message(
                boot_ms, self.north, self.east, 0, self.speed * math.cos(self.yaw), self.speed * math.sin(self.yaw), 0))
        elif message == 147:
            self.send(self.autopilot, mav.MAVLink_battery_status_message(
                0, 1, 1, 32767, [12600] + [65535] * 9, 150, -1, -1, 90))
        elif message == 330 and now < self.arguments.stop_scan_after:
            self.report["last_scan_s"] = round(now, 3)
            distances = [801] * 72
            if self.arguments.obstacle_m is not None:
                distances[4] = round(self.arguments.obstacle_m * 100)
            self.send(self.bridge, mav.MAVLink_obstacle_distance_message(
                int(now * 1e6), 0, distances, 5, 20, 800, 5.0, -20.0, 12))

    def run(self):
        last = self.time()
        while self.time() < self.arguments.duration:
            self.receive()
            now = self.time()
            self.move(now - last)
            last = now
            if now < self.arguments.stop_all_after:
                self.tell()

    def final(self):
        self.report.update({
            "path_m": round(self.report["path_m"], 3), "speed_mps_max": round(self.report["speed_mps_max"], 3),
            "armed": self.armed, "mode": self.mode, "speed_mps": round(self.speed, 3), "ended_s": round(self.time(), 3),
            "x_m": round(self.east, 3), "y_m": round(self.north, 3),
        })
        return self.report


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--host", default="127.0.0.1")
    parser.add_argument("--port", type=int, required=True)
    parser.add_argument("--system", type=int, default=1)
    for name in ("--x", "--y", "--yaw", "--prearm-after"):
        parser.add_argument(name, type=float, default=0.0)
    for name in ("--stop-scan-after", "--stop-all-after", "--duration"):
        parser.add_argument(name, type=float, default=math.inf)
    parser.add_argument("--obstacle-m", type=float)

    def end(*_):
        raise KeyboardInterrupt

    signal.signal(signal.SIGTERM, end)
    signal.signal(signal.SIGINT, end)
    rover = Rover(parser.parse_args())
    print(json.dumps({"listening": rover.socket.getsockname()[1]}), flush=True)
    try:
        rover.run()
    except KeyboardInterrupt:
        pass
    print(json.dumps(rover.final()), flush=True)
    sys.exit(0)


if __name__ == "__main__":
    main()
