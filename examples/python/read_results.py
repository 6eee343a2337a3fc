"""Runs a small hopper and reads its results file as arrays and tables."""

import pathlib
import tempfile

import numpy

import firn

HOPPER = pathlib.Path(__file__).resolve().parents[1] / "hopper.toml"

with tempfile.TemporaryDirectory() as folder:
    file = pathlib.Path(folder) / "hopper.h5"
    firn.run(firn.Case.load(HOPPER), file)

    results = firn.Results(file)
    print(f"{results.status}: {results.particle_count} particles, {len(results)} frames")
    print(results.stages())                                       # a DataFrame
    print(results.particles()[["shape", "mass", "insert_time", "exit_time"]].head())
    print(results.response_table()[["value", "unit"]])

    kinetic = results.series("/energy/kinetic")                   # [T] J
    print(f"largest kinetic energy {kinetic.max():.4f} J at {results.times[kinetic.argmax()]:.2f} s")
    height = results.frame(-1).position[:, 2]                     # [N] m, NaN once it has left
    print(f"{numpy.isfinite(height).sum()} particles are left")
    del results                                                   # closes the file
