"""Cases: reading, editing, and how Python values become TOML."""

import random
import tomllib

import numpy
import pytest

import firn
from firn.cases import toml_value
from conftest import SOURCE, TWO_BOXES


def random_value(dice, depth=0):
    kinds = ["bool", "int", "float", "text"] + (["list", "dict"] if depth < 3 else [])
    kind = dice.choice(kinds)
    if kind == "bool":
        return dice.random() < 0.5
    if kind == "int":
        return dice.randint(-10**12, 10**12)
    if kind == "float":
        return dice.choice([-1, 1]) * dice.random() * 10.0 ** dice.randint(-300, 300)
    if kind == "text":
        return "".join(chr(dice.choice([*range(1, 300), 0x2603, 0x1F9CA]))
                       for _ in range(dice.randint(0, 12)))
    if kind == "list":
        return [random_value(dice, depth + 1) for _ in range(dice.randint(0, 3))]
    return {random_value_name(dice): random_value(dice, depth + 1) for _ in range(dice.randint(0, 3))}


def random_value_name(dice):
    return "".join(dice.choice("abc-_9 .\"\\é") for _ in range(dice.randint(1, 6)))


def test_values_survive_toml():
    dice = random.Random(1)
    for _ in range(500):
        value = random_value(dice)
        assert tomllib.loads("x = " + toml_value(value))["x"] == value


def test_numpy_values_are_taken():
    assert toml_value(numpy.float64(0.25)) == "0.25"
    assert tomllib.loads("x = " + toml_value(numpy.array([1, 2])))["x"] == [1, 2]
    with pytest.raises(TypeError, match="no TOML form"):
        toml_value(object())


def test_loads_and_edits(case_file, case):
    assert (case.name, case.duration, case.seed, case.particle_count) == ("two boxes", 0.3, 1, 2)
    assert case.frame_interval == pytest.approx(0.01)
    assert case.boundaries == ["floor"]
    other = case.edit({"fills.0.count": 5, "case.seed": 7}).edit({"case.duration": "1 s"})
    assert (other.particle_count, other.seed, other.duration) == (5, 7, 1)
    assert (case.particle_count, case.seed) == (2, 1)
    # Of two values for one key the later one counts; friction follows as in a file.
    assert case.edit({"case.seed": 3}).edit({"case.seed": 4}).seed == 4
    assert firn.Case.load(case_file, {"interactions.ice-ice.static_friction": 0.05}).text == \
        case.edit({"interactions.ice-ice.static_friction": 0.05}).text


def test_text_is_complete(case):
    assert firn.Case.parse(case.text).text == case.text
    assert tomllib.loads(case.text)["case"]["name"] == "two boxes"
    assert firn.Case.parse(TWO_BOXES).text == case.text


def test_shapes_and_meshes():
    case = firn.Case.load(SOURCE / "examples" / "hopper.toml")
    shape = case.shapes[0]
    assert shape["name"] == "lump"
    assert shape["volume"] == pytest.approx(0.5 * 0.03 * 0.02 * 0.018)
    assert shape["mass"] == pytest.approx(916.7 * shape["volume"])
    vertices, triangles = case.shape_mesh(0)
    assert vertices.shape[1] == triangles.shape[1] == 3
    corners = vertices[triangles]
    volume = numpy.einsum("ij,ij->i", corners[:, 0], numpy.cross(corners[:, 1], corners[:, 2])).sum() / 6
    assert volume == pytest.approx(shape["volume"])


def test_mistakes_are_one_line(case_file, case):
    with pytest.raises(firn.InputError) as error:
        case.edit({"interactions.ice-ice.static_frictoin": 0.2})
    assert "static_frictoin: unknown key" in str(error.value)
    case_file.write_text(TWO_BOXES.replace("young_modulus", "young_moduls"))
    with pytest.raises(firn.InputError, match="case.toml:8: .*young_moduls"):
        firn.Case.load(case_file)
    assert "\n" not in str(error.value)
    with pytest.raises(firn.InputError, match="nowhere.toml"):
        firn.Case.load("nowhere.toml")
    with pytest.raises(ValueError, match="duration"):  # InputError is a ValueError
        case.edit({"case.duration": "-1 s"})
