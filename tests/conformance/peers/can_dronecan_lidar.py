#!/usr/bin/env python3
"""A lidar node made with pydronecan, for our decoder to read.

    can_dronecan_lidar.py INTERFACE [--node N] [--seconds S]

Sends NodeStatus once a second and 36 sectors of Proximity ten times a second. Sector i lies 10 i degrees
counter-clockwise from ahead (so at yaw -10 i on the wire) and reads 1 + i / 10 metres; sector 9, to the left, has no
data; sector 18, behind, reads the greatest range. At the end it prints one line of JSON on stdout: what it sent, and
the nodes that it saw on the bus. Ends with 0, or with 1 if it saw nobody. Needs pydronecan 1.0.27 and SocketCAN.
"""
import argparse
import json
import sys
import time

import dronecan
from dronecan.driver import SocketCAN
from dronecan.node import Node

SECTORS, RATE_HZ, NO_DATA, GOOD = 36, 10, 0, 2


def readings(range_max):
    """(yaw in degrees clockwise, reading, metres) of every sector."""
    for sector in range(SECTORS):
        bearing = 360.0 / SECTORS * sector
        yaw = 0.0 - bearing if bearing <= 180 else 360.0 - bearing
        if sector == 9:
            yield yaw, NO_DATA, 0.0
        elif sector == 18:
            yield yaw, GOOD, range_max
        else:
            yield yaw, GOOD, 1.0 + sector / 10


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("interface")
    parser.add_argument("--node", type=int, default=42, help="its node id (default 42)")
    parser.add_argument("--range-max", type=float, default=12.0, help="its greatest range, metres (default 12)")
    parser.add_argument("--seconds", type=float, default=5.0, help="how long to send (default 5)")
    options = parser.parse_args()
    mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
    node = Node(SocketCAN(options.interface), node_id=options.node, mode=mode)
    others = set()
    node.add_handler(dronecan.uavcan.protocol.NodeStatus, lambda event: others.add(event.transfer.source_node_id))
    proximity = dronecan.ardupilot.equipment.proximity_sensor.Proximity
    sectors, rounds, due = list(readings(options.range_max)), 0, time.monotonic()
    end = due + options.seconds
    while due < end:
        for yaw, reading, distance in sectors:
            node.broadcast(proximity(sensor_id=1, reading_type=reading, flags=0, yaw=yaw, pitch=0.0, distance=distance))
        rounds += 1
        # A late round is not made up for: on a slow machine that would only fill the driver's queue.
        due = max(due + 1 / RATE_HZ, time.monotonic() + 0.5 / RATE_HZ)
        node.spin(due - time.monotonic())
    node.spin(0.2)
    others.discard(options.node)
    print(json.dumps({"rounds": rounds, "sectors": sectors, "other_nodes": sorted(others)}))
    return 0 if others else 1


if __name__ == "__main__":
    sys.exit(main())
