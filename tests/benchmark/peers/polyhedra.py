"""Yade: convex hulls of the crescent, started from a bed of hulls settled by Firn and timed for a few steps.

Run by `compare` as  yade -n -x -j1 polyhedra.py  with its input in the environment:
FIRN_BED (CSV: x,y,z m; w,qx,qy,qz body axes -> world), FIRN_CRESCENT (JSON), STEPS, REPETITIONS.
Prints one line of JSON a repetition.
"""

import csv
import json
import math
import os
import time

from yade import log, polyhedra_utils, utils

log.setDefaultLogLevel(1)  # thousands of warnings a step from the overlap test otherwise

crescent = json.load(open(os.environ["FIRN_CRESCENT"]))
bed = list(csv.DictReader(open(os.environ["FIRN_BED"])))
steps = int(os.environ["STEPS"])

# Force = stiffness * overlap volume; the two bodies act in series, so a full flat contact of
# 9e-4 m^2 has about 3e5 N/m. The friction of a pair is the smaller one of the two materials.
# 916.7 kg/m^3 of the hull weighs a little more than the crescent does.
ice = PolyhedraMat(young=6.7e8, poisson=0.33, density=916.7, frictionAngle=math.atan(0.1))
wall = PolyhedraMat(young=6.7e8, poisson=0.33, density=2000, frictionAngle=math.atan(0.3))
O.materials.append([ice, wall])

# polyhedra() moves the corners to its own center and axes, so they are given in the world.
for row in bed:
    at = Vector3(*(float(row[k]) for k in "xyz"))
    turn = Quaternion(*(float(row[k]) for k in ("w", "qx", "qy", "qz")))
    corners = [at + turn * Vector3(*point) for point in crescent["hull"]]
    O.bodies.append(polyhedra_utils.polyhedra(ice, v=corners))

half_x, half_y = crescent["box"][0] / 2, crescent["box"][1] / 2
for position, axis, sense in [
    (-half_x, 0, 1), (half_x, 0, -1), (-half_y, 1, 1), (half_y, 1, -1), (0.0, 2, 1),
]:
    O.bodies.append(utils.wall(position, axis=axis, sense=sense, material=wall))

O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Polyhedra_Aabb(), Bo1_Wall_Aabb()], verletDist=3e-4),
    InteractionLoop(
        [Ig2_Polyhedra_Polyhedra_PolyhedraGeom(), Ig2_Wall_Polyhedra_PolyhedraGeom()],
        [Ip2_PolyhedraMat_PolyhedraMat_PolyhedraPhys()],
        [Law2_PolyhedraGeom_PolyhedraPhys_Volumetric()],
    ),
    NewtonIntegrator(damping=0.1, gravity=(0, 0, -9.81)),
]
O.dt = 2e-5

O.run(2, True)  # the first steps find all neighbors
for _ in range(int(os.environ["REPETITIONS"])):
    start = time.process_time()
    O.run(steps, True)
    seconds = (time.process_time() - start) / steps
    touching = sum(1 for i in O.interactions if i.isReal and i.phys.normalForce.norm() > 0)
    print(
        json.dumps(
            {
                "seconds_per_step": seconds,
                "kept": O.interactions.countReal(),
                "touching": touching,
                "kinetic_energy": utils.kineticEnergy(),
            }
        ),
        flush=True,
    )
