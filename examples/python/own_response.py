"""Measures a response of one's own for several seeds: the speed at which lumps pass a hopper's slot."""

import pathlib
import tempfile

import numpy

import firn

HOPPER = pathlib.Path(__file__).resolve().parents[1] / "hopper.toml"
SLOT = -0.020  # m, height of the sensor plane


def slot_speed(results):
    """m/s, mean over the frames of all lumps within 20 mm of the slot."""
    speeds = []
    for frame in map(results.frame, range(len(results))):
        near = numpy.abs(frame.position[:, 2] - SLOT) < 0.020  # False where a lump is not present
        speeds.extend(numpy.linalg.norm(frame.velocity[near], axis=1))
    return numpy.mean(speeds)


case = firn.Case.load(HOPPER, {"output.frame_interval": "10 ms"})
values = []
with tempfile.TemporaryDirectory() as folder:
    for seed in (1, 2, 3):
        run = firn.run(case.edit({"case.seed": seed}), pathlib.Path(folder) / f"{seed}.h5")
        values.append(slot_speed(run.results()))
        print(f"seed {seed}: {values[-1]:.3f} m/s, {run['slot_count'].value:.0f} lumps passed")
error = numpy.std(values, ddof=1) / len(values) ** 0.5
print(f"speed at the slot: {numpy.mean(values):.3f} +- {error:.3f} m/s")
