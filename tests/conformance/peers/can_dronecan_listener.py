#!/usr/bin/env python3
"""A tool made with pydronecan that reads a lidar node: its NodeStatus, its Proximity, and who it says it is.

    can_dronecan_listener.py INTERFACE [--node N] [--sectors N] [--seconds S]

Prints one line of JSON on stdout (`proximity` lists the newest reading of each direction as [yaw in degrees clockwise,
distance in metres, reading]) and ends with 0 if everything was as it must be, else 1; `problems` says what was not.
Needs pydronecan 1.0.27 and SocketCAN. The driver is named and not left to `make_node`, which blocks on a quiet bus.
"""
import argparse
import json
import sys
import time

import dronecan
from dronecan.driver import SocketCAN
from dronecan.node import Node
from dronecan.transport import TransferError

OWN_NODE = 20


class Listener:
    """A node of our own, and what the lidar said."""

    def __init__(self, options):
        self.options = options
        mode = dronecan.uavcan.protocol.NodeStatus().MODE_OPERATIONAL
        self.node = Node(SocketCAN(options.interface), node_id=OWN_NODE, mode=mode)
        self.statuses = []
        self.readings = {}
        self.count = 0
        self.name = None
        self.others = set()
        self.broken = 0
        self.node.add_handler(dronecan.uavcan.protocol.NodeStatus, self.on_status)
        self.node.add_handler(dronecan.ardupilot.equipment.proximity_sensor.Proximity, self.on_proximity)

    def on_status(self, event):
        source = event.transfer.source_node_id
        if source == self.options.node:
            self.statuses.append((event.message.health, event.message.mode))
        else:
            self.others.add(source)

    def on_proximity(self, event):
        if event.transfer.source_node_id == self.options.node:
            message = event.message
            self.count += 1
            self.readings[round(message.yaw, 3)] = (round(message.distance, 3), message.reading_type)

    def on_info(self, event):
        if event is not None:
            self.name = bytes(event.response.name).decode("ascii", "replace")

    def spin(self, seconds):
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            try:
                self.node.spin(min(left, 0.1))
            except TransferError:
                # Where Python is too slow for the bus, the kernel drops frames, and what remains of a transfer is bad.
                self.broken += 1

    def problems(self):
        options, found = self.options, []
        if len(self.statuses) < int(options.seconds) - 1:
            found.append(f"{len(self.statuses)} NodeStatus in {options.seconds} s: there must be one a second")
        if any(status != (0, 0) for status in self.statuses):
            found.append("a NodeStatus was not healthy and operational")
        if len(self.readings) != options.sectors:
            found.append(f"{len(self.readings)} directions were read and not {options.sectors}")
        if self.count < 0.5 * options.sectors * options.rate * options.seconds:
            found.append(f"{self.count} readings in {options.seconds} s are too few for {options.rate} scans a second")
        if self.broken > 0.02 * self.count:
            found.append(f"{self.broken} transfers were broken beside {self.count} good ones")
        if not self.name:
            found.append("GetNodeInfo was not answered")
        return found


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("interface")
    parser.add_argument("--node", type=int, default=42, help="the lidar's node id (default 42)")
    parser.add_argument("--sectors", type=int, default=36, help="how many directions it reads (default 36)")
    parser.add_argument("--rate", type=float, default=10.0, help="scans a second (default 10)")
    parser.add_argument("--seconds", type=float, default=3.0, help="how long to listen (default 3)")
    options = parser.parse_args()
    listener = Listener(options)
    listener.spin(0.3)
    listener.count = 0
    listener.node.request(dronecan.uavcan.protocol.GetNodeInfo.Request(), options.node, listener.on_info)
    listener.spin(options.seconds)
    problems = listener.problems()
    proximity = [[yaw, *reading] for yaw, reading in sorted(listener.readings.items())]
    print(json.dumps({"node_status": len(listener.statuses), "proximity_count": listener.count,
                      "broken": listener.broken, "name": listener.name,
                      "other_nodes": sorted(listener.others), "proximity": proximity, "problems": problems}))
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main())
