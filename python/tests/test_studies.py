"""Batches through the program, and their folders as tables."""

import pytest

import firn

STUDY = """
[study]
name = "density"
case = "case.toml"
[budget]
runs = 14
[[parameters]]
name = "density"
keys = ["materials.ice.density"]
min = "500 kg/m^3"
max = "1500 kg/m^3"
[[targets]]
response = "present_mass"
value = "0.0144 kg"
uncertainty = "0.0002 kg"
"""
SWEEP = """
[sweep]
name = "densities"
case = "case.toml"
seeds = 2
responses = ["present_mass"]
[[vary]]
name = "density"
keys = ["materials.ice.density"]
values = ["900 kg/m^3", "1800 kg/m^3"]
"""
OPTIMIZATION = """
[optimization]
name = "heaviest"
case = "case.toml"
maximize = "present_mass"
runs = 14
replicates_per_design = 2
confirmation_replicates = 4
[[parameters]]
name = "density"
keys = ["materials.ice.density"]
min = "900 kg/m^3"
max = "1800 kg/m^3"
[[limits]]
response = "present_mass"
above = "1 kg"
probability = 0.5
[[compare]]
name = "as it is"
values = { density = "917 kg/m^3" }
"""
SUITE = """
[suite]
name = "boxes"
seeds = 3
[[parameter_sets]]
name = "as it is"
[[experiments]]
name = "fall"
case = "case.toml"
[[comparisons]]
name = "mass"
kind = "value"
experiment = "fall"
measurement = "mass.toml"
"""
MASS = """
name = "mass of two boxes"
response = "present_mass"
values = ["0.0146 kg", "0.0147 kg", "0.0148 kg"]
status = "measured"
source = "a balance"
"""


def test_study(case_file):
    folder = case_file.parent
    (folder / "study.toml").write_text(STUDY)
    batch = firn.Study(folder / "study.toml").start(folder / "out", jobs=2)
    study = batch.wait()
    assert not batch.running
    low, best, high = study.parameters().loc["density", ["low", "best", "high"]]
    assert low <= 0.0144 / 16e-6 <= high and low <= best <= high
    assert study.targets().loc["present_mass", "value"] == 0.0144
    assert (study.runs()["status"] == "finished").all()
    assert study.posterior()["weight"].sum() == pytest.approx(1)
    assert study.verdict and study.headline
    predicted = study.predictions().loc["present_mass"]
    assert predicted["measured", "value"] == 0.0144
    for kind in ("mean_response", "single_run"):
        assert list(predicted[kind]) == sorted(predicted[kind])
        assert predicted[kind, 0.025] <= 0.0144 <= predicted[kind, 0.975]
    history = study.history()
    assert history["runs"].is_monotonic_increasing
    last = history.iloc[-1]
    assert last["low_95"] <= last["low_68"] <= last["median"] <= last["high_68"] <= last["high_95"]
    assert [last["low_95"], last["median"], last["high_95"]] == list(
        study.parameters().loc["density", ["low", "median", "high"]])


def test_results_of_earlier_versions_have_no_predictions(case_file):
    folder = case_file.parent / "old"
    folder.mkdir()
    (folder / "results.json").write_text(
        '{"study": "old", "verdict": "calibrated", "targets": [{"response": "mass"}]}')
    study = firn.StudyResults(folder)
    assert study.predictions().empty and study.history().empty


def test_results_of_earlier_versions_have_the_names_of_this_one(case_file):
    folder = case_file.parent / "old"
    folder.mkdir()
    (folder / "results.json").write_text(
        '{"study": "old", "verdict": "out of reach", "answer": {"parameters": {"mu": 0.1}}, "parameters": [{'
        '"name": "mu", "min": 0, "max": 1, "unit": "1", "scale": "linear"}]}')
    study = firn.StudyResults(folder)
    assert study.verdict == "infeasible" and study.parameters().loc["mu", "best"] == 0.1
    (folder / "results.json").write_text(
        '{"kind": "validation", "comparisons": [{"name": "n", "title": "t", "kind": "value", "experiment": "e", '
        '"parameter_set": "p", "verdict": "information", "headline": "h", "value": {"difference": 2.5}}]}')
    comparison = firn.ValidationResults(folder).comparisons().iloc[0]
    assert comparison["comparison_error"] == 2.5 and comparison["verdict"] == "not judged"


def test_interrupted_study_continues(case_file):
    folder = case_file.parent
    (folder / "study.toml").write_text(STUDY)
    study = firn.Study(folder / "study.toml")
    with study.start(folder / "out", jobs=1) as batch:
        with pytest.raises(TimeoutError):
            batch.wait(timeout=0.05)
        batch.interrupt()
        with pytest.raises(firn.RunError):
            batch.wait(timeout=30)
    assert study.run(folder / "out").verdict


def test_sweep(case_file):
    folder = case_file.parent
    (folder / "sweep.toml").write_text(SWEEP)
    sweep = firn.Sweep(folder / "sweep.toml").run(folder / "out")
    table = sweep.combinations()
    assert list(table["present_mass"]) == pytest.approx([900 * 16e-6, 1800 * 16e-6], rel=0.01)
    assert len(sweep.runs()) == 4


def test_optimization(case_file):
    folder = case_file.parent
    (folder / "optimization.toml").write_text(OPTIMIZATION)
    results = firn.Optimization(folder / "optimization.toml").run(folder / "out")
    confirmed = results.confirmed()
    assert list(confirmed["design"]) == ["best", "as it is"]
    assert confirmed["mean"][0] == pytest.approx(confirmed["density"][0] * 16e-6, rel=0.01)
    assert confirmed["density"][0] > 1700 and list(confirmed["present_mass above 1"]) == [0, 0]
    assert len(results.designs()) == 3 and len(results.runs()) == 14
    assert results.verdict and "present_mass" in results.headline
    with pytest.raises(firn.InputError):
        firn.SweepResults(folder / "out")


def test_validation(case_file):
    folder = case_file.parent
    (folder / "suite.toml").write_text(SUITE)
    (folder / "mass.toml").write_text(MASS)
    validation = firn.Validation(folder / "suite.toml").run(folder / "out")
    row = validation.comparisons().iloc[0]
    assert row["measured"] == pytest.approx(0.0147) and row["simulated"] == pytest.approx(916.7 * 16e-6)
    assert row["verdict"] and len(validation.runs()) >= 3


def test_mistakes(case_file, tmp_path):
    (tmp_path / "wrong.toml").write_text(STUDY.replace("case.toml", "none.toml"))
    with pytest.raises(firn.InputError, match="none.toml"):
        firn.Study(tmp_path / "wrong.toml").run(tmp_path / "out")
    with pytest.raises(firn.InputError, match="results.json"):
        firn.StudyResults(tmp_path / "nothing")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "results.json").write_text("[]")
    with pytest.raises(firn.InputError, match="holds no study"):
        firn.StudyResults(tmp_path / "other")
