#!/usr/bin/env python3
"""Robot-steps/s of IR-SIM on the 360-beam diffusion scene of `drover bench sim`.

A walled square with 0.25 robots per m2. Each robot has a lidar of 360 beams and 10 m, drives straight on, and turns
away from what is near ahead. One robot-step is one robot through one tick of 0.1 s: sense, decide, move. Prints one
line of JSON. `bench/peers/setup` makes the two venvs: target/peers-irsim (ir-sim) for `--lidar python`, and
target/peers-irsimx (irsim-x) for `--lidar cpp`.
"""

import argparse
import contextlib
import importlib.metadata
import io
import json
import math
import os
import random
import sys
import tempfile
import time

# No window, and one thread, as the other side has. Both must be set before numpy and matplotlib are loaded.
os.environ["MPLBACKEND"] = "Agg"
for variable in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

# This file has the package's name and would be imported in its place.
HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:] = [entry for entry in sys.path if os.path.abspath(entry) != HERE]

# The same as KHEPERA in bench/src/sim/scenes.rs.
RADIUS_M = 0.0704
BEAMS = 360
RANGE_M = 10.0
ROBOTS_PER_M2 = 0.25
TICK_S = 0.1
SPEED_MPS = 0.1
TURN_RADPS = 1.0
CLEARANCE_M = RADIUS_M + 0.08
AHEAD_RAD = 1.6

WARM_UP_TICKS = 3

# What differs from the scene on our side, and from one peer to the other.
SEES = {
    "python": "lidar sees walls and robots, discs as 64-gons",
    "cpp": "C++ lidar sees walls, NOT other robots, which so drive through each other",
}
CONTACTS = {
    "unobstructed": "overlaps are found but stop nobody",
    "stop": "who touches something stops for good",
    "contact": "contacts push",
}
# IR-SIM 2.9 casts rays many times slower than 2.12.
OLD = "OLD version, Python 3.9 takes no newer: do not quote; " if sys.version_info < (3, 10) else ""


def scattered(count, side_m, rng):
    """Poses on a jittered grid, none overlapping, any headings."""
    per_side = math.ceil(math.sqrt(count))
    pitch_m = side_m / per_side
    slack_m = max(pitch_m / 2 - RADIUS_M - 0.01, 0.0)
    for index in range(count):
        row, column = divmod(index, per_side)
        x_m, y_m = ((cell + 0.5) * pitch_m + rng.uniform(-slack_m, slack_m) for cell in (column, row))
        yield [x_m, y_m, rng.uniform(-math.pi, math.pi)]


def world(count, seed, collisions):
    """The world file, as a value."""
    side_m = math.sqrt(count / ROBOTS_PER_M2)
    lidar = {
        "name": "lidar2d",
        "range_min": 0.0,
        "range_max": RANGE_M,
        # From the first beam to the last: 360 different beams, and irsim-x takes a full turn for none at all.
        "angle_range": 2 * math.pi * (BEAMS - 1) / BEAMS,
        "number": BEAMS,
        "noise": False,
    }
    robots = [
        {
            "kinematics": {"name": "diff"},
            "shape": {"name": "circle", "radius": RADIUS_M},
            "state": pose,
            "vel_min": [-SPEED_MPS, -1.5],
            "vel_max": [SPEED_MPS, 1.5],
            "sensors": [lidar],
        }
        for pose in scattered(count, side_m, random.Random(seed))
    ]
    corners = [[0.0, 0.0], [side_m, 0.0], [side_m, side_m], [0.0, side_m], [0.0, 0.0]]
    walls = {"shape": {"name": "linestring", "vertices": corners}, "state": [0.0, 0.0, 0.0]}
    frame = {"height": side_m, "width": side_m, "step_time": TICK_S, "sample_time": TICK_S}
    return {"world": {**frame, "collision_mode": collisions}, "robot": robots, "obstacle": [walls]}


def make(irsim, value):
    """The environment of a world file."""
    handle, path = tempfile.mkstemp(suffix=".yaml")
    try:
        with os.fdopen(handle, "w") as file:
            json.dump(value, file)  # JSON is YAML
        return irsim.make(path, display=False, disable_all_plot=True, log_level="ERROR")
    finally:
        os.unlink(path)


def diffusion(np, angles):
    """The law, for all robots at once: ranges (robots x beams) to one [speed, turn] for each."""
    ahead = np.cos(angles) >= math.cos(AHEAD_RAD)
    sines = np.sin(angles[ahead])

    def decide(ranges):
        near = ranges[:, ahead] < CLEARANCE_M
        blocked = near.any(axis=1)
        turn = np.where(near @ sines > 0.0, -TURN_RADPS, TURN_RADPS)
        return np.column_stack((np.where(blocked, 0.0, SPEED_MPS), np.where(blocked, turn, 0.0)))

    return decide


def measure(env, np, ticks, seconds_max):
    """Ticks done and seconds taken; the world is built and warm by then."""
    robots = env.robot_list
    lidars = [robot.lidar for robot in robots]
    decide = diffusion(np, lidars[0].angle_list)

    def tick():
        actions = decide(np.array([lidar.range_data for lidar in lidars]))
        env.step([action.reshape(2, 1) for action in actions], 0)

    for _ in range(WARM_UP_TICKS):
        tick()
    done = 0
    begun = time.perf_counter()
    while done < ticks:
        tick()
        done += 1
        if time.perf_counter() - begun > seconds_max:
            break
    return done, time.perf_counter() - begun


def main():
    """Read the options, measure, print."""
    parser = argparse.ArgumentParser(description="Robot-steps/s of IR-SIM, headless, one process, one thread.")
    parser.add_argument("--robots", type=int, default=10)
    parser.add_argument("--ticks", type=int, default=100)
    parser.add_argument("--seconds-max", type=float, default=30.0, help="stop after this and use what was done")
    parser.add_argument("--lidar", choices=("python", "cpp"), default="python", help="ir-sim's, or irsim-x's")
    parser.add_argument("--collisions", choices=tuple(CONTACTS), default="unobstructed", help="collision_mode")
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args()
    if options.robots < 1 or options.ticks < 1:
        parser.error("at least one robot and one tick")
    if options.lidar == "cpp" and options.collisions == "contact":
        parser.error("irsim-x has no contacts that push")

    peer = {"python": "ir-sim", "cpp": "irsim-x"}[options.lidar]
    try:
        version = importlib.metadata.version(peer)
    except importlib.metadata.PackageNotFoundError:
        sys.exit(f"{sys.executable} has no {peer}: run bench/peers/setup, then use the python of its venv")
    chatter = io.StringIO()  # IR-SIM prints which window systems it could not use
    with contextlib.redirect_stdout(chatter):
        import irsim
        import numpy as np

        env = make(irsim, world(options.robots, options.seed, options.collisions))
        done, seconds = measure(env, np, options.ticks, options.seconds_max)
    result = {
        "peer": peer,
        "version": version,
        "robots": options.robots,
        "beams": BEAMS,
        "ticks": done,
        "robot_steps_per_s": round(options.robots * done / seconds, 1),
        "notes": f"{OLD}{SEES[options.lidar]}; {CONTACTS[options.collisions]}; no noise",
    }
    print(json.dumps(result))


if __name__ == "__main__":
    main()
