"""Results files as arrays and tables."""

import numpy
import pytest

import firn


@pytest.fixture
def results(case, tmp_path):
    firn.run(case, tmp_path / "run.h5")
    return firn.Results(tmp_path / "run.h5")


def test_arrays(results):
    assert len(results) == len(results.times) == 32 and results.particle_count == 2
    frame = results.frame(-1)
    assert frame.time == results.times[-1]
    for name, width in (("position", 3), ("orientation", 4), ("velocity", 3),
                        ("angular_velocity", 3)):
        array = getattr(frame, name)
        assert array.shape == (2, width) and array.dtype == numpy.float64
        assert array.base is not None and not array.flags.owndata  # a C++ vector has the data
    assert numpy.linalg.norm(frame.orientation, axis=1) == pytest.approx([1, 1])
    assert frame.position[:, 2] == pytest.approx([0.01, 0.01], abs=1e-4)  # on their faces
    position = results.frame(3).position
    first = position.copy()
    del results, frame  # arrays outlive the file
    assert (position == first).all()


def test_frames_out_of_range(results):
    for index in (32, -33):
        with pytest.raises(firn.InputError):
            results.frame(index)


def test_tables(results):
    particles = results.particles()
    assert list(particles["shape"]) == ["box", "box"]
    assert list(particles["mass"]) == pytest.approx([916.7 * 8e-6] * 2)
    stages = results.stages()
    assert stages["end"].iloc[-1] == pytest.approx(0.3, abs=1e-4)
    table = results.response_table()
    assert table.loc["present_count", "value"] == 2
    assert results.measure().keys() == results.responses.keys()
    for name, response in results.measure().items():
        assert response.values.tobytes() == results.responses[name].values.tobytes(), name
    trajectory = results.trajectory()
    last = trajectory[trajectory["time"] == results.times[-1]]
    assert (last[["x", "y", "z"]].to_numpy() == results.frame(-1).position).all()


def test_series(results):
    listed = results.series_list().set_index("path")
    assert listed.loc["/energy/kinetic", "unit"] == "J"
    for path, row in listed.iterrows():
        values = results.series(path)
        assert values.shape == ((32,) if row["width"] == 1 else (32, row["width"]))
    # A path of files of format 1.
    assert (results.series("/health/patches") == results.series("/diagnostics/patches")).all()
    kinetic = results.series("/energy/kinetic")
    assert (results.series("energy/kinetic") == kinetic).all()
    speed = (results.frame(10).velocity ** 2).sum(axis=1)
    assert kinetic[10] >= 0.5 * 916.7 * 8e-6 * speed.sum() * (1 - 1e-9)  # and rotation
    with pytest.raises(firn.InputError):
        results.series("/weather")


def test_samples(results, case, tmp_path):
    assert len(results.sample_times) == len(results.sample_list()) == 0
    sampled = case.edit({"output.samples.interval": "1 ms", "output.samples.boundaries": ["floor"]})
    firn.run(sampled, tmp_path / "sampled.h5")
    samples = firn.Results(tmp_path / "sampled.h5")
    assert len(samples.sample_times) > 290 and samples.sample_times[0] == 0
    listed = samples.sample_list().set_index("path")
    assert listed.loc["/boundaries/floor/force", "unit"] == "N"
    force = samples.samples("boundaries/floor/force")
    assert force.shape == (len(samples.sample_times), 3)
    # The floor bears the weight of both boxes.
    assert force[-100:, 2].mean() == pytest.approx(-2 * 916.7 * 8e-6 * 9.81, rel=0.03)
    with pytest.raises(firn.InputError, match="/boundaries/floor/weather is not sampled"):
        samples.samples("/boundaries/floor/weather")


def test_files_that_are_none(tmp_path):
    file = tmp_path / "no.h5"
    file.write_bytes(b"nothing of the kind")
    with pytest.raises(firn.InputError, match="not a results file"):
        firn.Results(file)


def test_material_records():
    table = firn.material_records()
    assert len(table) > 10 and table["shipped"].any()
    assert numpy.isfinite(table["value"]).all()
    from firn.materials import material_record

    name = table["name"].iloc[0]
    assert material_record(name)["name"] == name
    with pytest.raises(firn.InputError, match="no such material record"):
        material_record("cheese")
