"""The examples for Python run as they are, and print what they promise."""

import os
import pathlib
import re
import subprocess
import sys

import pytest

EXAMPLES = pathlib.Path(__file__).resolve().parents[2] / "examples" / "python"

# A line of the output that only a working example prints.
PROMISED = {
    "calibrate_simulator.py": r"calibrated: ramp = 0\.1\d+, flat = 0\.\d+",
    "floor_load.py": r"finished: \d+ steps, largest overlap 0\.\d+ mm",
    "own_response.py": r"speed at the slot: 0\.\d+ \+- 0\.\d+ m/s",
    "read_results.py": r"finished: 24 particles, \d+ frames",
}


def test_every_example_is_tested():
    assert {file.name for file in EXAMPLES.glob("*.py")} == set(PROMISED)


@pytest.mark.parametrize("name", sorted(PROMISED))
def test_example(name, tmp_path):
    done = subprocess.run([sys.executable, EXAMPLES / name], cwd=tmp_path, env=os.environ, text=True,
                          capture_output=True)
    assert done.returncode == 0, done.stderr
    assert re.search(PROMISED[name], done.stdout), done.stdout
    assert not list(tmp_path.iterdir())  # results go to temporary folders
