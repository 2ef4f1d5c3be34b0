#!/usr/bin/env python3
"""Reads and makes our beacons with somebody else's MAVLink: pymavlink, and the dialect file turned into Python by it.

    mavlink_beacon.py                     check that tests/golden/mavlink is what pymavlink makes of the dialect
    mavlink_beacon.py --listen GROUP:PORT [--interface ADDRESS] [--seconds S] [--robots N]
                                          hear a running swarm; good when N robots were heard, none of them badly

Prints one line of JSON on stdout and ends with 0 if all was good. Needs pymavlink 2.4.50.
"""
import argparse
import contextlib
import io
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time

os.environ["MAVLINK20"] = "1"
from pymavlink.generator import mavgen  # noqa: E402

ROOT = os.path.abspath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../.."))
DIALECT = os.path.join(ROOT, "firmware_if/codec/dialect/drover.xml")
MAKE = os.path.join(ROOT, "tests/golden/mavlink/make.py")


def own_dialect(folder):
    with contextlib.redirect_stdout(io.StringIO()):
        mavgen.mavgen(mavgen.Opts(os.path.join(folder, "drover"), "2.0", "Python3"), [DIALECT])
    sys.path.insert(0, folder)
    import drover
    return drover


def check_golden():
    same = subprocess.run([sys.executable, MAKE, "--check"], check=False).returncode == 0
    return same, {"golden_is_what_pymavlink_makes": same}


def join(group, port, interface):
    link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
    link.bind((group, port))
    membership = struct.pack("4s4s", socket.inet_aton(group), socket.inet_aton(interface))
    link.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, membership)
    link.settimeout(0.2)
    return link


def listen(drover, arguments):
    group, port = arguments.listen.rsplit(":", 1)
    link = join(group, int(port), arguments.interface)
    parser = drover.MAVLink(io.BytesIO())
    parser.robust_parsing = True
    robots, bad, stops = {}, 0, 0
    end = time.monotonic() + arguments.seconds
    while time.monotonic() < end:
        try:
            data, _ = link.recvfrom(2048)
        except (TimeoutError, socket.timeout):
            continue
        for message in parser.parse_buffer(data) or []:
            if message.get_type() == "DROVER_BEACON":
                seen = robots.setdefault(message.robot, {"beacons": 0})
                seen["beacons"] += 1
                seen.update(x=round(message.x, 3), y=round(message.y, 3), state=message.state,
                            leader=message.leader, bytes=len(data))
            elif message.get_type() == "DROVER_STOP":
                stops += 1
            else:
                bad += 1
    good = len(robots) >= arguments.robots and bad == 0
    return good, {"robots": robots, "stops": stops, "bad": bad}


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--listen")
    parser.add_argument("--interface", default="127.0.0.1")
    parser.add_argument("--seconds", type=float, default=3.0)
    parser.add_argument("--robots", type=int, default=1)
    arguments = parser.parse_args()
    if arguments.listen is None:
        good, facts = check_golden()
    else:
        with tempfile.TemporaryDirectory() as folder:
            good, facts = listen(own_dialect(folder), arguments)
    print(json.dumps({"ok": good, **facts}), flush=True)
    sys.exit(0 if good else 1)


if __name__ == "__main__":
    main()
