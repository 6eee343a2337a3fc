"""Small cases that the tests share."""

import pathlib

import pytest

SOURCE = pathlib.Path(__file__).resolve().parents[2]

# Two boxes fall onto a plane and come to rest.
TWO_BOXES = """
[case]
name = "two boxes"
duration = "0.3 s"
seed = 1
[materials.ice]
density = "916.7 kg/m^3"
young_modulus = "1 MPa"
[interactions.ice-ice]
static_friction = 0.2
restitution = 0.3
[shapes.box]
kind = "box"
size = "20 20 20 mm"
material = "ice"
[[fills]]
shape = "box"
count = 2
region_min = "-50 -50 30 mm"
region_max = "50 50 120 mm"
[[boundaries]]
name = "floor"
kind = "plane"
material = "ice"
point = "0 0 0 m"
normal = [0, 0, 1]
[output]
frame_interval = "10 ms"
"""


@pytest.fixture
def case_file(tmp_path):
    file = tmp_path / "case.toml"
    file.write_text(TWO_BOXES)
    return file


@pytest.fixture
def case(case_file):
    import firn

    return firn.Case.load(case_file)
