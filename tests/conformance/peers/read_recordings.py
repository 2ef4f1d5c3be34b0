#!/usr/bin/env python3
"""Reads our recordings with other people's readers: tlogs with pymavlink's mavutil, candump logs with python-can.

    read_recordings.py FILE...

A file whose name ends in .tlog is a MAVLink log, one that ends in .log is a candump log. Prints one line of JSON on
stdout, an object with what was found in each file, and ends with 0 if every reader got to the end of every file.
Needs pymavlink 2.4.50 and python-can 4.6.1.
"""
import json
import os
import sys

os.environ["MAVLINK20"] = "1"
import can  # noqa: E402
from pymavlink import mavutil  # noqa: E402


def count(table, key):
    table[key] = table.get(key, 0) + 1


def tlog(path):
    log = mavutil.mavlink_connection(path)
    found = {"messages": 0, "kinds": {}, "sources": {}, "bad": 0, "backwards": 0}
    first = last = None
    while (message := log.recv_msg()) is not None:
        if message.get_type() == "BAD_DATA":
            found["bad"] += 1
            continue
        stamp = message._timestamp  # the one name under which mavutil gives a log's time
        first = stamp if first is None else first
        found["backwards"] += last is not None and stamp < last
        last = stamp
        found["messages"] += 1
        count(found["kinds"], message.get_type())
        count(found["sources"], f"{message.get_srcSystem()}/{message.get_srcComponent()}")
    return {**found, "first_s": first, "last_s": last}


def candump(path):
    found = {"messages": 0, "standard": {}, "extended": {}, "received": 0, "sent": 0, "errors": 0, "backwards": 0,
             "channels": []}
    first = last = None
    with can.LogReader(path) as log:
        for message in log:
            first = message.timestamp if first is None else first
            found["backwards"] += last is not None and message.timestamp < last
            last = message.timestamp
            found["messages"] += 1
            found["received" if message.is_rx else "sent"] += 1
            found["errors"] += message.is_error_frame
            count(found["extended" if message.is_extended_id else "standard"], f"{message.arbitration_id:X}")
            if message.channel not in found["channels"]:
                found["channels"].append(message.channel)
    return {**found, "first_s": first, "last_s": last}


def main():
    readers = {".tlog": tlog, ".log": candump}
    found = {os.path.basename(path): readers[os.path.splitext(path)[1]](path) for path in sys.argv[1:]}
    print(json.dumps(found))
    return 0 if all(entry["messages"] for entry in found.values()) else 1


if __name__ == "__main__":
    sys.exit(main())
