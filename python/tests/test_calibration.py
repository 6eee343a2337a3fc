"""Calibration of simulators that are Python functions."""

import math
import os
import random
import signal

import numpy
import pytest

import firn

PARAMETERS = [firn.Parameter("mu_ramp", 0.02, 0.5, scale="log"),
              firn.Parameter("mu_flat", 0.02, 0.5, scale="log")]


def slide(values, seed):
    """A block slides down a ramp and out on the flat; the seed moves its start."""
    start = 0.5 * (1 + 0.02 * (random.Random(seed).random() - 0.5))
    pull = 9.81 * (math.sin(0.6) - values["mu_ramp"] * math.cos(0.6))
    return {"time": (math.sqrt(2 * start / pull), "s"),
            "run_out": (pull * start / (values["mu_flat"] * 9.81), "m")}


def targets(mu_ramp, mu_flat):
    pull = 9.81 * (math.sin(0.6) - mu_ramp * math.cos(0.6))
    return [firn.Target("time", math.sqrt(1 / pull), 0.005, "s"),
            firn.Target("run_out", pull * 0.5 / (mu_flat * 9.81), 0.03, "m")]


# The truth lies in nearly all 95 % intervals; of these members in all.
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_finds_random_truths(seed):
    dice = random.Random(seed)
    truth = {p.name: math.exp(dice.uniform(math.log(0.05), math.log(0.3))) for p in PARAMETERS}
    answer = firn.calibrate(slide, PARAMETERS, targets(**truth), runs=60, seed=seed)
    assert answer.verdict == "calibrated", answer.headline
    estimates = answer.estimates()
    for name, value in truth.items():
        assert estimates.loc[name, "low"] <= value <= estimates.loc[name, "high"]
        assert estimates.loc[name, "best"] == pytest.approx(value, rel=0.15)
    assert answer.samples.shape == (len(answer.weights), 2)
    assert answer.weights.sum() == pytest.approx(1)
    mean = numpy.average(answer.posterior()["mu_ramp"], weights=answer.posterior()["weight"])
    assert estimates.loc["mu_ramp", "low"] < mean < estimates.loc["mu_ramp", "high"]
    assert answer.answer["verdict"] == "calibrated" and "mu_flat" in answer.table


def test_a_discrepancy_widens_the_interval():
    def width(discrepancy):
        aims = targets(0.1, 0.2)
        aims[1].discrepancy = discrepancy
        estimate = firn.calibrate(slide, PARAMETERS, aims, runs=40).estimates().loc["mu_flat"]
        return estimate["high"] - estimate["low"]
    assert width(0.1) > 2 * width(0)


def test_threads_change_nothing():
    one = firn.calibrate(slide, PARAMETERS, targets(0.1, 0.2), runs=40)
    four = firn.calibrate(slide, PARAMETERS, targets(0.1, 0.2), runs=40, jobs=4)
    assert one.samples.tobytes() == four.samples.tobytes()
    assert one.estimates().equals(four.estimates())


def test_a_folder_keeps_runs(tmp_path):
    calls = []

    def counted(values, seed):
        calls.append(seed)
        return slide(values, seed)

    def fit(version):
        return firn.calibrate(counted, PARAMETERS, targets(0.1, 0.2), runs=40,
                              directory=tmp_path / "study", simulator_version=version)

    first = fit("1")
    assert len(calls) == first.runs <= 40
    again = fit("1")
    assert len(calls) == first.runs  # nothing was simulated twice
    assert again.samples.tobytes() == first.samples.tobytes()
    fit("2")
    assert len(calls) == 2 * first.runs
    table = firn.StudyResults(tmp_path / "study").parameters()
    assert list(table.index) == ["mu_ramp", "mu_flat"] and (table["low"] < table["high"]).all()


def test_failed_runs_and_other_exceptions():
    def sometimes(values, seed):
        if seed % 7 == 3:
            raise firn.RunError("jammed")
        return slide(values, seed)

    answer = firn.calibrate(sometimes, PARAMETERS, targets(0.1, 0.2), runs=60)
    assert answer.answer["runs"]["failed"] > 0 and len(answer.estimates()) == 2

    def broken(values, seed):
        raise ZeroDivisionError("a mistake in the simulator")

    for jobs in (1, 3):
        with pytest.raises(ZeroDivisionError, match="a mistake"):
            firn.calibrate(broken, PARAMETERS, targets(0.1, 0.2), runs=40, jobs=jobs)


def test_ctrl_c_between_calls():
    def pressed(values, seed):
        os.kill(os.getpid(), signal.SIGINT)
        return slide(values, seed)

    with pytest.raises(KeyboardInterrupt):
        firn.calibrate(pressed, PARAMETERS, targets(0.1, 0.2), runs=40)


@pytest.mark.parametrize("change, message", [
    ({"parameters": [firn.Parameter("mu", 0.5, 0.1)]}, "min below max"),
    ({"parameters": [firn.Parameter("mu", 0, 0.1, scale="log")]}, "logarithm"),
    ({"parameters": [firn.Parameter("mu", 0, 0.1, scale="cubic")]}, "scale"),
    ({"parameters": [firn.Parameter("a.b", 0, 1)]}, "letters"),
    ({"parameters": []}, "parameters"),
    ({"targets": []}, "targets"),
    ({"targets": [firn.Target("time", 1, 0, "s")]}, "uncertainty"),
    ({"targets": [firn.Target("time", 1, 0.1, "min")]}, "unit"),
    ({"targets": [firn.Target("time", 1, 0.1, "s", -1)]}, "discrepancy is -1"),
    ({"targets": [firn.Target("time", 1, 0.1, "s", math.nan)]}, "discrepancy is nan"),
    ({"targets": [firn.Target("weather", 1, 0.1)]}, "weather"),
    ({"runs": 3}, "runs"),
    ({"jobs": 0}, "jobs"),
    ({"simulator": lambda values, seed: 1}, "dict"),
    ({"simulator": lambda values, seed: {"time": "late"}}, "number"),
])
def test_mistakes_are_one_line(change, message):
    arguments = {"simulator": slide, "parameters": PARAMETERS, "targets": targets(0.1, 0.2),
                 "runs": 40, **change}
    with pytest.raises(firn.InputError, match=message) as error:
        firn.calibrate(**arguments)
    assert "\n" not in str(error.value)


def test_a_response_of_ones_own_of_a_case(case):
    """Finds the density of the boxes from a force that Python measures."""
    def floor_force(results):
        return {"floor_force": (-results.series("/boundaries/floor/force")[-30:, 2].mean(), "N")}

    # Boxes that rock on their springs swing the force: its mean over half of the time.
    case = case.edit({"case.duration": "0.6 s"})
    simulator = firn.case_simulator(case, {"density": ["materials.ice.density"]}, floor_force,
                                    units={"density": "kg/m^3"})
    truth = 900
    answer = firn.calibrate(
        simulator, [firn.Parameter("density", 500, 1500, "kg/m^3")],
        [firn.Target("floor_force", 2 * truth * 8e-6 * 9.81, 0.002, "N")], runs=16)
    low, high = answer.estimates().loc["density", ["low", "high"]]
    assert low <= truth <= high and high - low < 100


def test_named_responses_of_a_case(case):
    simulator = firn.case_simulator(case, {"density": ["materials.ice.density"]}, ["present_mass"],
                                    units={"density": "kg/m^3"})
    assert simulator({"density": 900}, 1) == {"present_mass": (pytest.approx(900 * 16e-6), "kg")}
    unknown = firn.case_simulator(case, {}, ["weather"])
    with pytest.raises(firn.InputError, match="no response 'weather'"):
        unknown({}, 1)
