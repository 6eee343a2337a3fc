"""Runs LIGGGHTS on in.collapse in the working folder and writes responses.json.

Usage: python3 simulate.py SEED
Reads the positions in the last frame of final.dump. The status is that of LIGGGHTS.
"""

import json
import os
import subprocess
import sys


def next_prime(number):
    while any(number % divisor == 0 for divisor in range(2, int(number**0.5) + 1)):
        number += 1
    return number


def last_positions(dump):
    with open(dump) as file:
        frame = file.read().rsplit("ITEM: ATOMS", 1)[1]
    return [[float(word) for word in line.split()[1:4]] for line in frame.splitlines()[1:]]


def main():
    prime = next_prime(20000 + 10 * int(sys.argv[1]))
    with open("in.collapse") as file:
        script = file.read().replace("SEED", str(prime))
    with open("in.run", "w") as file:
        file.write(script)
    # MPI programs that start at the same time must not share a folder for temporary files.
    environment = dict(os.environ, TMPDIR=os.getcwd())
    done = subprocess.run(["liggghts", "-in", "in.run"], env=environment)
    if done.returncode != 0:
        sys.exit(done.returncode)
    places = last_positions("final.dump")
    if len(places) != 90:
        sys.exit(f"{len(places)} spheres are left; expected 90")
    count = len(places)
    responses = {
        "mean_distance": {"value": sum(x for x, y, z in places) / count, "unit": "m"},
        "mean_height": {"value": sum(z for x, y, z in places) / count, "unit": "m"},
    }
    with open("responses.json", "w") as file:
        json.dump(responses, file)


main()
