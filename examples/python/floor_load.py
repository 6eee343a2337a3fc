"""Follows a run in this process: prints what a plate carries while ice cubes bounce on it."""

import pathlib
import tempfile

import firn

CASES = pathlib.Path(__file__).resolve().parents[2] / "cases"


def show(frame):
    """Called for each recorded state. Returning False would stop the run."""
    contacts = frame.contacts()
    load = contacts["force"][:, 2].sum()  # N; every contact here is one of a cube and the plate
    print(f"t = {frame.time:.3f} s  lowest center {1e3 * frame.position[:, 2].min():6.2f} mm  "
          f"{len(contacts['a']):2d} contacts  load {load:6.3f} N")


case = firn.Case.load(CASES / "bounce" / "case.toml", {"output.frame_interval": "25 ms"})
with tempfile.TemporaryDirectory() as folder:
    run = firn.run(case, pathlib.Path(folder) / "run.h5", on_frame=show)
print(f"{run.status}: {run.steps} steps, largest overlap {1e3 * run.largest_overlap:.3f} mm")
print(f"restitution of the bounces: {run['restitution'].value:.3f}")
