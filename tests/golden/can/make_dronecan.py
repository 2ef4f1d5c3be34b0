#!/usr/bin/env python3
"""Writes dronecan.json: DroneCAN frames made by pydronecan.

    python3 -m venv venv && venv/bin/pip install dronecan==1.0.27
    venv/bin/python tests/golden/can/make_dronecan.py tests/golden/can/dronecan.json

Each row holds the fields of one transfer and its frames as candump writes them. Half floats are listed twice: the
number given, and the sixteen bits that pydronecan makes of it. The seed is fixed: the same file comes out every time.
With --check before the file's name nothing is written: the exit code says whether the file is what would be written.
"""
import json
import random
import sys

import dronecan
from dronecan.transport import Transfer, f16_from_f32, f32_from_f16

PROXIMITY = dronecan.ardupilot.equipment.proximity_sensor.Proximity
MEASUREMENT = dronecan.uavcan.equipment.range_sensor.Measurement
NODE_STATUS = dronecan.uavcan.protocol.NodeStatus
NODE_INFO = dronecan.uavcan.protocol.GetNodeInfo


def half(value):
    """A half float as it comes back from the wire."""
    return f32_from_f16(f16_from_f32(value))


def frames_of(payload, **header):
    transfer = Transfer(payload=payload, **header)
    return ["%08X#%s" % (frame.message_id, bytes(frame.bytes).hex().upper()) for frame in transfer.to_frames()]


def row(kind, payload, fields, chance, node=42):
    header = {"transfer_id": chance.randrange(32), "transfer_priority": chance.randrange(32)}
    frames = frames_of(payload, source_node_id=node, **header)
    return {"kind": kind, "node": node, **header, **fields, "frames": frames}


def proximity(chance):
    given = {
        "sensor_id": chance.randrange(256),
        "reading": chance.randrange(3),
        "flags": chance.randrange(32),
        "yaw_deg": chance.choice([-180.0, 45.0, chance.uniform(-180, 180)]),
        "pitch_deg": chance.choice([0.0, chance.uniform(-90, 90)]),
        "distance_m": chance.choice([3.5, chance.uniform(0, 60), chance.uniform(0, 1e-4)]),
    }
    payload = PROXIMITY(sensor_id=given["sensor_id"], reading_type=given["reading"], flags=given["flags"],
                        yaw=given["yaw_deg"], pitch=given["pitch_deg"], distance=given["distance_m"])
    wire = {key + "_wire": half(given[key]) for key in ("yaw_deg", "pitch_deg", "distance_m")}
    return row("proximity", payload, {**given, **wire}, chance)


def measurement(chance):
    given = {
        "timestamp_us": chance.choice([0, chance.randrange(1 << 56)]),
        "sensor_id": chance.randrange(256),
        "roll_pitch_yaw": [chance.randrange(-16, 16) for _ in range(3)],
        "orientation_defined": chance.random() < 0.8,
        "field_of_view_rad": chance.uniform(0, 3),
        "sensor_type": chance.randrange(4),
        "reading": chance.randrange(4),
        "range_m": chance.uniform(0, 100),
    }
    payload = MEASUREMENT(sensor_id=given["sensor_id"], field_of_view=given["field_of_view_rad"],
                          sensor_type=given["sensor_type"], reading_type=given["reading"], range=given["range_m"])
    payload.timestamp.usec = given["timestamp_us"]
    payload.beam_orientation_in_body_frame.fixed_axis_roll_pitch_yaw = given["roll_pitch_yaw"]
    payload.beam_orientation_in_body_frame.orientation_defined = given["orientation_defined"]
    wire = {key + "_wire": half(given[key]) for key in ("field_of_view_rad", "range_m")}
    return row("measurement", payload, {**given, **wire}, chance)


def node_status(chance):
    given = {
        "uptime_s": chance.randrange(1 << 32),
        "health": chance.randrange(4),
        "mode": chance.choice([0, 1, 2, 3, 7]),
        "sub_mode": chance.randrange(8),
        "vendor": chance.randrange(1 << 16),
    }
    payload = NODE_STATUS(uptime_sec=given["uptime_s"], health=given["health"], mode=given["mode"],
                          sub_mode=given["sub_mode"], vendor_specific_status_code=given["vendor"])
    return row("node_status", payload, given, chance)


def node_info(chance):
    """A service's answer, the longest transfer here."""
    unique_id = [chance.randrange(256) for _ in range(16)]
    name = "org.example.node" + "x" * chance.randrange(60)
    payload = NODE_INFO.Response(name=name)
    payload.status.uptime_sec = chance.randrange(1000)
    payload.software_version.major, payload.software_version.minor = 3, 1
    payload.hardware_version.major, payload.hardware_version.minor = 2, 7
    payload.hardware_version.unique_id = unique_id
    header = {"transfer_id": chance.randrange(32), "transfer_priority": chance.randrange(32)}
    frames = frames_of(payload, source_node_id=42, dest_node_id=10, service_not_message=True,
                       request_not_response=False, **header)
    return {"kind": "node_info", "node": 42, "destination": 10, **header, "uptime_s": payload.status.uptime_sec,
            "software": [3, 1], "hardware": [2, 7], "unique_id": unique_id, "name": name, "frames": frames}


def lidar(chance):
    """What a whole lidar node sends: its first NodeStatus, then one round of 36 sectors counter-clockwise from ahead.

    Distances are given counter-clockwise; yaw on the wire is clockwise. None: no reading.
    """
    distances = [chance.choice([None, round(chance.uniform(0.2, 12.0), 3)]) for _ in range(36)]
    frames = frames_of(NODE_STATUS(uptime_sec=0), source_node_id=42, transfer_id=0, transfer_priority=20)
    for sector, distance in enumerate(distances):
        bearing = 10.0 * sector
        payload = PROXIMITY(sensor_id=7, reading_type=0 if distance is None else 2, flags=0,
                            yaw=0.0 - bearing if bearing <= 180 else 360 - bearing, pitch=0.0, distance=distance or 0.0)
        frames += frames_of(payload, source_node_id=42, transfer_id=sector % 32, transfer_priority=16)
    return {"sensor_id": 7, "node": 42, "distances_m": distances, "frames": frames}


def halves(chance):
    values = [0.0, -0.0, 1.0, -1.0, 0.1, 65504.0, 6e-5, 6.2e-5, 1e-7, 3e-8, 2e-8, 1.0 + 1 / 2048, 1.0 + 3 / 2048]
    values += [chance.uniform(-1, 1) * 10 ** chance.uniform(-8, 4.8) for _ in range(300)]
    return [{"value": value, "bits": f16_from_f32(value)} for value in values]


def main():
    chance = random.Random(20261123)
    makers = [proximity] * 60 + [measurement] * 60 + [node_status] * 40 + [node_info] * 8
    document = {
        "made_by": "pydronecan 1.0.27, make_dronecan.py",
        "signatures": {
            "proximity": "%016X" % dronecan.get_dronecan_data_type(PROXIMITY()).get_data_type_signature(),
            "measurement": "%016X" % dronecan.get_dronecan_data_type(MEASUREMENT()).get_data_type_signature(),
            "node_status": "%016X" % dronecan.get_dronecan_data_type(NODE_STATUS()).get_data_type_signature(),
            "node_info": "%016X" % dronecan.get_dronecan_data_type(NODE_INFO.Request()).get_data_type_signature(),
        },
        "rows": [maker(chance) for maker in makers],
        "halves": halves(chance),
        "lidar": lidar(chance),
    }
    text = json.dumps(document, indent=0) + "\n"
    path = sys.argv[-1]
    if "--check" in sys.argv:
        with open(path, encoding="utf-8") as present:
            sys.exit(0 if present.read() == text else 1)
    with open(path, "w", encoding="utf-8") as out:
        out.write(text)


if __name__ == "__main__":
    main()
