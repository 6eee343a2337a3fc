# Yade's side of `agree`, run as: yade -n -x -j1 spheres.py. Reads the case as JSON from $AGREE_CASE
# and writes the states to $AGREE_OUT: one JSON line a frame with positions, velocities and spins.
import json
import os

from yade import *  # noqa: F401,F403  (Yade's own way)

case = json.load(open(os.environ["AGREE_CASE"]))
# FrictPhys: kn = 2 E1 R1 E2 R2 / (E1 R1 + E2 R2), ks = poisson * kn; a wall counts with the radius
# of the sphere.
young = case["stiffness"] / case["radius"]
O.materials.append(FrictMat(young=young, poisson=case["tangential_ratio"], density=case["density"],
                            frictionAngle=atan(case["friction"]), label="m"))
for i, (x, v) in enumerate(zip(case["positions"], case["velocities"])):
    O.bodies.append(sphere(x, case["radius"], material="m"))
    O.bodies[i].state.vel = v
O.bodies.append(wall(0, axis=2, sense=1, material="m"))
if case["walls"]:
    for axis, length in enumerate(case["box"]):
        O.bodies.append(wall(0, axis=axis, sense=1, material="m"))
        O.bodies.append(wall(length, axis=axis, sense=-1, material="m"))
count = len(case["positions"])
out = open(os.environ["AGREE_OUT"], "w")


def frame():
    states = [O.bodies[i].state for i in range(count)]
    json.dump({"time": O.time, "x": [list(s.pos) for s in states], "v": [list(s.vel) for s in states],
               "w": [list(s.angVel) for s in states]}, out)
    out.write("\n")


O.engines = [
    ForceResetter(),
    InsertionSortCollider([Bo1_Sphere_Aabb(), Bo1_Wall_Aabb()], verletDist=case["skin"]),
    InteractionLoop([Ig2_Sphere_Sphere_ScGeom(), Ig2_Wall_Sphere_ScGeom()],
                    [Ip2_FrictMat_FrictMat_FrictPhys()], [Law2_ScGeom_FrictPhys_CundallStrack()]),
    NewtonIntegrator(damping=0, gravity=(0, 0, -case["gravity"])),
]
O.dt = case["timestep"]
frame()
for k in range(case["steps"] // case["every"]):
    O.run(case["every"], True)
    frame()
out.close()
