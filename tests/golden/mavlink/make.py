#!/usr/bin/env python3
"""Make the MAVLink golden vectors with somebody else's implementation: pymavlink.

    python3 -m venv venv && venv/bin/pip install pymavlink==2.4.50
    venv/bin/python tests/golden/mavlink/make.py

writes `host.txt` (what an onboard computer sends), `device.txt` (what an autopilot and a lidar bridge send) and
`beacon.txt`, `links.txt` and `map.txt` (our own dialect, whose Python form pymavlink's mavgen makes from
firmware_if/codec/dialect/drover.xml).
A line is `LABEL FRAME-IN-HEX FIELD=VALUE ...`; texts stand in hex, arrays are joined by commas. With --check nothing is
written: the exit code says whether the files are what this script would write.
"""
import contextlib
import io
import math
import os
import sys
import tempfile

os.environ["MAVLINK20"] = "1"
import pymavlink  # noqa: E402
from pymavlink.dialects.v10 import common as v1  # noqa: E402
from pymavlink.dialects.v20 import common as v2  # noqa: E402
from pymavlink.generator import mavgen  # noqa: E402

HERE = os.path.dirname(os.path.abspath(__file__))
DIALECT = os.path.join(HERE, "../../../firmware_if/codec/dialect/drover.xml")


def show(value):
    if isinstance(value, (bytes, bytearray)):
        return value.hex()
    if isinstance(value, str):
        return value.encode().hex()
    if isinstance(value, (list, tuple)):
        return ",".join(str(item) for item in value)
    if isinstance(value, float):
        return repr(value)
    return str(value)


def line(label, message, dialect=v2, system=7, component=1, seq=0, signed=False):
    sender = dialect.MAVLink(io.BytesIO(), srcSystem=system, srcComponent=component)
    sender.seq = seq
    if signed:
        sender.signing.secret_key = bytes(range(32))
        sender.signing.timestamp = 1
        sender.signing.sign_outgoing = True
    frame = message.pack(sender)
    # The fields as pymavlink itself reads them back, so that floats have the precision of the wire.
    names = {"from_system": system, "from_component": component, "frame_seq": seq}
    fields = {name: getattr(message, name) for name in message.fieldnames}
    reader = dialect.MAVLink(io.BytesIO())
    if signed:
        reader.signing.secret_key = bytes(range(32))
    back = reader.parse_buffer(bytes(frame))
    if back:
        fields = {name: getattr(back[0], name) for name in back[0].fieldnames}
    pairs = " ".join(f"{name}={show(value)}" for name, value in {**names, **fields}.items())
    return f"{label} {frame.hex()} {pairs}"


def host():
    def long(label, command, p1, p2, confirmation=0):
        m = v2.MAVLink_command_long_message(7, 1, command, confirmation, p1, p2, 0, 0, 0, 0, 0)
        return line(label, m, component=191)

    def setpoint(label, vx, yaw_rate, boot_ms):
        m = v2.MAVLink_set_position_target_local_ned_message(
            boot_ms, 7, 1, 8, 1479, 0, 0, 0, vx, 0, 0, 0, 0, 0, 0, yaw_rate)
        return line(label, m, component=191)

    yield line("heartbeat", v2.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), component=191)
    yield long("hold", 176, 1, 4)
    yield long("guided_again", 176, 1, 15, 1)
    yield long("arm", 400, 1, 0)
    yield long("disarm", 400, 0, 0)
    yield long("position_40_hz", 511, 32, 25000)
    yield setpoint("forward_left", 0.75, -0.5, 12345)
    yield setpoint("backward_right", -0.25, 1.25, 12345)
    yield setpoint("stop", 0.0, 0.0, 0)
    yield line("time_question", v2.MAVLink_timesync_message(0, 123456789001), component=191)
    # What only others send; the device side has to take it.
    yield line("unknown_command", v2.MAVLink_command_long_message(7, 1, 60980, 0, 1, 2, 3, 4, 5, 6, 7), system=255,
               component=190)
    yield line("command_int_mode", v2.MAVLink_command_int_message(7, 0, 0, 176, 0, 0, 1, 15, 0, 0, 0, 0, 0),
               system=255, component=190)
    yield line("for_another_system", v2.MAVLink_command_long_message(8, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0), system=255,
               component=190)
    yield line("set_mode", v2.MAVLink_set_mode_message(7, 1, 4), system=255, component=190)
    yield line("force_arm", v2.MAVLink_command_long_message(7, 0, 400, 0, 1, 21196, 0, 0, 0, 0, 0), system=255,
               component=190)
    yield line("data_stream", v2.MAVLink_request_data_stream_message(7, 1, 0, 4, 1), system=255, component=190)
    yield line("not_a_number", v2.MAVLink_set_position_target_local_ned_message(
        0, 7, 1, 8, 1479, 0, 0, 0, math.nan, 0, 0, 0, 0, 0, 0, 0.0), system=255, component=190)
    yield line("signed_arm", v2.MAVLink_command_long_message(7, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0), system=255,
               component=190, signed=True)
    yield line("v1_arm", v1.MAVLink_command_long_message(7, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0), dialect=v1, system=255,
               component=190)


def device():
    present = 0x1 | 0x2 | 0x4 | 0x8000 | 0x2000000 | 0x10000000 | 0x20 | 0x200000 | 0x100
    yield line("heartbeat_guided_armed", v2.MAVLink_heartbeat_message(10, 3, 129, 15, 4, 3))
    yield line("heartbeat_hold_disarmed", v2.MAVLink_heartbeat_message(10, 3, 1, 4, 3, 3), seq=255)
    yield line("heartbeat_bridge", v2.MAVLink_heartbeat_message(18, 8, 0, 0, 4, 3), component=196)
    yield line("heartbeat_unknown_enums", v2.MAVLink_heartbeat_message(250, 251, 129, 15, 252, 3))
    yield line("heartbeat_v1", v1.MAVLink_heartbeat_message(10, 3, 129, 15, 4, 3), dialect=v1)
    yield line("sys_status_ready", v2.MAVLink_sys_status_message(
        present, present, present, 0, 12600, 150, 90, 0, 0, 0, 0, 0, 0))
    yield line("sys_status_not_ready", v2.MAVLink_sys_status_message(
        present, present, present & ~(0x10000000 | 0x20 | 0x200000 | 0x100), 0, 65535, -1, -1, 0, 0, 0, 0, 0, 0))
    yield line("battery", v2.MAVLink_battery_status_message(
        0, 1, 1, 32767, [12600] + [65535] * 9, 150, -1, -1, 90))
    yield line("ack_accepted", v2.MAVLink_command_ack_message(400, 0, 0, 0, 7, 191))
    yield line("ack_failed", v2.MAVLink_command_ack_message(400, 4, 0, 0, 7, 191))
    yield line("ack_unknown_command", v2.MAVLink_command_ack_message(60980, 3, 0, 0, 255, 190))
    yield line("ack_without_target", v2.MAVLink_command_ack_message(176, 0))
    yield line("position", v2.MAVLink_local_position_ned_message(5000, 3.5, -2.25, 0, 0.5, 0.25, 0))
    yield line("attitude", v2.MAVLink_attitude_message(5000, 0, 0, 0.5, 0, 0, -0.125))
    yield line("attitude_nan", v2.MAVLink_attitude_message(5000, 0, 0, math.nan, 0, 0, 0))
    distances = [100 + 10 * index for index in range(70)] + [65535, 0]
    distances[3] = 1201
    yield line("obstacles", v2.MAVLink_obstacle_distance_message(
        1000000, 0, distances, 5, 20, 1200, 5.0, -20.0, 12), component=196)
    yield line("obstacles_coarse", v2.MAVLink_obstacle_distance_message(
        1000000, 0, [250] * 36 + [65535] * 36, 10, 20, 1200, 0, 0, 12), component=196)
    yield line("obstacles_counter_clockwise", v2.MAVLink_obstacle_distance_message(
        1000000, 0, [250] * 72, 5, 20, 1200, -5.0, 90.0, 12), component=196)
    yield line("obstacles_north_aligned", v2.MAVLink_obstacle_distance_message(
        1000000, 0, [250] * 72, 5, 20, 1200), component=196)
    yield line("sector_ahead", v2.MAVLink_distance_sensor_message(5000, 20, 800, 250, 0, 10, 0, 0))
    yield line("sector_left_empty", v2.MAVLink_distance_sensor_message(5000, 20, 800, 800, 0, 16, 6, 0))
    yield line("text", v2.MAVLink_statustext_message(2, b"Arm: Need Position Estimate"))
    long = b"Requested rate for message ID 32 too fast. Increase SCHED_LOOP_RATE"
    yield line("text_piece_0", v2.MAVLink_statustext_message(6, long[:50], 9, 0))
    yield line("text_piece_1", v2.MAVLink_statustext_message(6, long[50:], 9, 1))
    yield line("time_answer", v2.MAVLink_timesync_message(42000000000, 123456789001))
    yield line("version", v2.MAVLink_autopilot_version_message(
        0x8 | 0x80 | 0x2000, 0x04070000, 0, 0, 0, [0] * 8, [0] * 8, [0] * 8, 0, 0, 0))


def swarm_hash(name):
    swarm = 0x811C9DC5
    for byte in name:
        swarm = ((swarm ^ byte) * 0x01000193) & 0xFFFFFFFF
    return swarm


def beacon(drover):
    swarm = swarm_hash(b"first")
    full = (9_000_000_123, swarm, 70_003, 5, 1234, 12.5, -3.25, 1.5, 0.75, -0.5, 0.25, 0.125, 0.3, 32768, 1)
    for label, leader in (("beacon", 4_000_000_007), ("beacon_without_leader", 0)):
        message = drover.MAVLink_drover_beacon_message(*full, leader)
        yield line(label, message, drover, system=70_003 & 255, component=191, seq=17)
    zero = drover.MAVLink_drover_beacon_message(0, swarm, 256, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.5, 0, 0)
    yield line("beacon_mostly_zero", zero, drover, system=255, component=191)
    signed = drover.MAVLink_drover_beacon_message(
        1, swarm, 3, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0.5, 65535, 3, 2, [index + 1 for index in range(64)])
    yield line("beacon_with_signature", signed, drover, system=3, component=191)
    for label, at, value in (("nan", 5, math.nan), ("infinite", 8, math.inf), ("turned_too_far", 7, 4.0)):
        fields = [1, swarm, 3, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0.5, 0, 1]
        fields[at] = value
        yield line(f"bad_beacon_{label}", drover.MAVLink_drover_beacon_message(*fields), drover, system=3)
    unknown_state = drover.MAVLink_drover_beacon_message(1, swarm, 3, 1, 1, 1, 1, 1, 0, 0, 0, 0, 0.5, 0, 99)
    yield line("bad_beacon_state", unknown_state, drover, system=3)
    yield line("stop_all", drover.MAVLink_drover_stop_message(swarm, 0, 4, 0), drover, system=255, component=191, seq=4)
    yield line("stop_one", drover.MAVLink_drover_stop_message(swarm, 70_003, 4, 0), drover, system=255,
               component=191, seq=4)


def links(drover):
    fields = {
        "swarm": swarm_hash(b"first"), "robot": 70_003, "epoch": 5, "seq": 1234, "term": 300, "root": 2,
        "root_metric": 12.5, "anchor_x": 125_025, "anchor_y": -325_050, "peer": [2, 70_004, 70_005, 70_006, 0, 0, 0],
        "edge_low": [2, 4, 0], "edge_high": [4, 9, 0], "gone": 11, "root_seq": 65_535,
        "peer_epoch": [7, 65_535, 1, 2, 0, 0, 0], "version": [3, 65_535, 9, 1, 0, 0, 0],
        "weight": [250, 65_535, 120, 333, 0, 0, 0], "edge_weight": [101, 202, 0],
        "centre_x": [0, 0, 0, -32_768, 0, 0, 0], "centre_y": [0, 0, 0, 32_767, 0, 0, 0], "hops": 4,
        "flags": [1 | 2 | 8, 4, 1, 1 | 4, 0, 0, 0], "age": [0, 1, 254, 255, 0, 0, 0], "edge_age": [0, 3, 0],
        "gone_age": 12}

    def entry(label, **changes):
        message = drover.MAVLink_drover_links_message(**{**fields, **changes})
        return line(label, message, drover, system=70_003 & 255, component=191, seq=17)

    yield entry("links")
    yield entry("links_with_signature", signature=[index + 1 for index in range(64)])
    yield entry("links_full", peer=[1, 2, 3, 4, 5, 6, 7], edge_low=[1, 2, 3], edge_high=[4, 5, 6], gone_age=255,
                age=[255] * 7, edge_age=[255] * 3)
    lone = {name: [0] * len(value) if isinstance(value, list) else 0 for name, value in fields.items()}
    yield entry("links_of_a_lone_robot", **{**lone, "swarm": fields["swarm"], "robot": 70_003, "root": 70_003})
    yield entry("bad_links_robot", robot=0)
    yield entry("bad_links_sender", robot=70_004)
    yield entry("bad_links_nan", root_metric=math.nan)
    yield entry("bad_links_root", root=0)
    yield entry("bad_links_anchor", anchor_y=2_000_000_000)
    yield entry("bad_links_peer", peer=[70_003, 0, 0, 0, 0, 0, 0])
    yield entry("bad_links_twice", peer=[9, 8, 9, 0, 0, 0, 0])
    yield entry("bad_links_edge", edge_high=[2, 9, 0])


def map_reports(drover):
    fields = {
        "swarm": swarm_hash(b"first"), "robot": 70_003, "epoch": 5, "seq": 1234, "lattice": 0xDEADBEEF, "goal": 4_712,
        "head_robot": [70_003, 9, 0, 0, 0], "head_epoch": [5, 2, 0, 0, 0], "head": [77, 4_000_000_000, 0, 0, 0],
        "writer": 9, "writer_epoch": 2, "after": 300, "upto": 309, "flags": 1, "length": 5,
        "changes": [172, 2, 8, 79, 1] + [0] * 83}

    def entry(label, **changes):
        message = drover.MAVLink_drover_map_message(**{**fields, **changes})
        return line(label, message, drover, system=70_003 & 255, component=191, seq=17)

    yield entry("map")
    yield entry("map_with_signature", signature=[index + 1 for index in range(64)])
    nothing = {"writer": 0, "writer_epoch": 0, "after": 0, "upto": 0, "flags": 0, "length": 0, "changes": [0] * 88}
    yield entry("map_without_a_piece", **nothing, goal=0)
    yield entry("map_full", head_robot=[1, 2, 3, 4, 5], length=88, changes=[1] * 88)
    yield entry("bad_map_robot", robot=0)
    yield entry("bad_map_sender", robot=70_004)
    yield entry("bad_map_upto", upto=300)
    yield entry("bad_map_length", length=89)


def own_dialect(folder):
    with contextlib.redirect_stdout(io.StringIO()):
        mavgen.mavgen(mavgen.Opts(os.path.join(folder, "drover"), "2.0", "Python3"), [DIALECT])
    sys.path.insert(0, folder)
    import drover
    return drover


def main():
    with tempfile.TemporaryDirectory() as folder:
        drover = own_dialect(folder)
        files = {"host.txt": host(), "device.txt": device(), "beacon.txt": beacon(drover),
                 "links.txt": links(drover), "map.txt": map_reports(drover)}
        same = True
        for name, lines in files.items():
            head = f"# Made by tests/golden/mavlink/make.py with pymavlink {pymavlink.__version__}; do not edit.\n"
            text = head + "".join(f"{entry}\n" for entry in lines)
            path = os.path.join(HERE, name)
            if "--check" in sys.argv:
                same = same and os.path.exists(path) and open(path, encoding="ascii").read() == text
            else:
                with open(path, "w", encoding="ascii") as out:
                    out.write(text)
    sys.exit(0 if same else 1)


if __name__ == "__main__":
    main()
