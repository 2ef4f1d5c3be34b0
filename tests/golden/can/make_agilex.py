#!/usr/bin/env python3
"""Writes agilex_pyagxrobots.json: AgileX v2 frames as the maker's own Python package reads and writes them.

    python3 -m venv venv && venv/bin/pip install pyagxrobots==0.8.4 python-can==4.6.1
    venv/bin/python tests/golden/can/make_agilex.py tests/golden/can/agilex_pyagxrobots.json

"write" rows: a twist, and the frame that UGV.SetMotionCommand sends for it. "read" rows: random bytes, and what
CanMsgsGet.CanMsgsProcessV2 finds in them. Left out, because the package does not follow the manuals' tables there: the
error bits (it keeps one of the two bytes), the remote control (it swaps the sticks' axes), and the signs of motor speed
and current (it reads them unsigned: the rows are drawn from the positive half). It loses the temperature of driver 3:
slow rows are of motors 1 and 2. It does not know the battery frame.
With --check before the file's name nothing is written: the exit code says whether the file is what would be written.
"""
import json
import random
import sys

import can
import wrapt.wrappers

# The package imports this name, which newer versions of wrapt do not have, and never uses it.
wrapt.wrappers.transient_function_wrapper = None

from pyagxrobots import UGVConfigMsg as values  # noqa: E402
from pyagxrobots.agxrobots import UGV, CanMsgsGet  # noqa: E402

ROWS = 20


def text(message):
    return f"{message.arbitration_id:03X}#{bytes(message.data).hex().upper()}"


def written(chance):
    robot = UGV.__new__(UGV)  # its constructor opens a bus
    robot.base_version = 2
    sent = []
    robot.SendMsg = sent.append
    rows = []
    for _ in range(2 * ROWS):
        # Halves and quarters of a unit: exact in binary, so that cutting and rounding agree.
        speed, yaw_rate = chance.randrange(-12, 13) / 4, chance.randrange(-10, 11) / 4
        robot.SetMotionCommand(speed, yaw_rate)
        rows.append({"kind": "command", "frame": text(sent[-1]), "speed_mps": speed, "yaw_rate_radps": yaw_rate})
    robot.EnableCANCtrl()
    rows.append({"kind": "enable", "frame": text(sent[-1])})
    return rows


def state(data):
    data[0], data[1], data[2] = data[0] % 3, data[1] % 4, data[2] % 4
    return 0x211, lambda: {
        "vehicle": values.GetVehicleState(), "mode": values.GetControlMode(), "battery_v": values.GetBatteryVoltage()
    }


def motion(_data):
    return 0x221, lambda: {
        "speed_mps": values.GetLinearVelocity(), "yaw_rate_radps": values.GetAngularVelocity(),
        "lateral_mps": values.GetLateralVelocity(), "steering_rad": values.GetSteeringAngle()
    }


def motor_fast(data):
    motor = data[7] % 4 + 1
    data[0], data[2], data[4] = data[0] % 128, data[2] % 128, data[4] % 128
    get = lambda name: getattr(values, name.format(motor))()
    return 0x250 + motor, lambda: {
        "motor": motor, "rpm": get("GetRpm{}"), "current_a": get("GetCurrent{}"), "pulses": get("GetPulseCount{}")
    }


def motor_slow(data):
    motor = data[7] % 2 + 1
    data[0], data[2], data[4] = data[0] % 4, data[2] % 128, data[4] % 128
    get = lambda name: getattr(values, name.format(motor))()
    return 0x260 + motor, lambda: {
        "motor": motor, "voltage_v": get("GetDriver{}Voltage"), "driver_c": get("GetDriver{}Temp"),
        "motor_c": get("GetMotor{}Temp"), "state": get("GetDriver{}State")
    }


def odometer(_data):
    return 0x311, lambda: {"left_mm": values.GetLeftWheel(), "right_mm": values.GetRightWheel()}


def read(chance):
    rows = []
    for kind in (state, motion, motor_fast, motor_slow, odometer):
        for _ in range(ROWS):
            data = bytearray(chance.randbytes(8))
            identifier, look = kind(data)
            message = can.Message(arbitration_id=identifier, data=data, is_extended_id=False)
            CanMsgsGet().CanMsgsProcessV2(message)
            rows.append({"kind": kind.__name__, "frame": text(message), **look()})
    return rows


def main():
    check, path = sys.argv[1:-1] == ["--check"], sys.argv[-1]
    chance = random.Random(20261123)
    values._init()
    document = {"made_by": "pyagxrobots 0.8.4, make_agilex.py", "write": written(chance), "read": read(chance)}
    made = "{\n" + f'  "made_by": {json.dumps(document["made_by"])},\n'
    lists = [f'  "{key}": [\n    ' + ",\n    ".join(map(json.dumps, document[key])) + "\n  ]" for key in ("write", "read")]
    made += ",\n".join(lists) + "\n}\n"
    if check:
        sys.exit(0 if open(path).read() == made else f"{path} is not what {sys.argv[0]} makes")
    open(path, "w").write(made)


if __name__ == "__main__":
    main()
