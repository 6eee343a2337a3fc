"""An ice cube is thrown onto a plate, bounces, and slides until it rests.

Usage: python3 simulate.py input.json
Reads friction, restitution, time_step (s) and seed. Writes responses.json.
"""

import json
import random
import sys

GRAVITY = 9.81  # m/s^2
SLOWEST_BOUNCE = 0.02  # m/s; slower impacts do not rebound


def simulate(friction, restitution, time_step, seed):
    scatter = random.Random(seed)
    height = 0.2 * (1 + 0.02 * scatter.gauss(0, 1))  # m
    forward = 1.0 + 0.03 * scatter.gauss(0, 1)  # m/s
    upward = 0.0
    distance = time = bounce_time = 0.0
    resting = False
    while forward > 0 or not resting:
        if resting:
            forward = max(0.0, forward - friction * GRAVITY * time_step)
        else:
            upward -= GRAVITY * time_step
            height += upward * time_step
            if height <= 0 and upward < 0:
                rebound = restitution * -upward
                forward = max(0.0, forward - friction * (rebound - upward))
                bounce_time = time
                height, upward = 0.0, rebound
                resting = rebound < SLOWEST_BOUNCE
        distance += forward * time_step
        time += time_step
    return distance, bounce_time


def main():
    with open(sys.argv[1]) as file:
        parameters = json.load(file)
    distance, bounce_time = simulate(**parameters)
    with open("responses.json", "w") as file:
        json.dump(
            {
                "slide_distance": {"value": distance, "unit": "m"},
                "bounce_time": {"value": bounce_time, "unit": "s"},
            },
            file,
        )


main()
