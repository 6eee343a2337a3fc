"""Calibrates a simulator that is a Python function: the friction of a ramp and of the flat behind it."""

import math
import random

import firn


def slide(values, seed):
    """A block slides down a ramp and out on the flat; the seed moves its start by up to 1 %."""
    start = 0.5 * (1 + 0.02 * (random.Random(seed).random() - 0.5))  # m
    pull = 9.81 * (math.sin(0.6) - values["ramp"] * math.cos(0.6))   # m/s^2
    return {"time": (math.sqrt(2 * start / pull), "s"),
            "run_out": (pull * start / (values["flat"] * 9.81), "m")}


answer = firn.calibrate(
    slide,
    [firn.Parameter("ramp", 0.02, 0.5, scale="log"), firn.Parameter("flat", 0.02, 0.5, scale="log")],
    [firn.Target("time", 0.463, 0.005, "s"), firn.Target("run_out", 1.19, 0.03, "m")], runs=60)
print(answer.headline)
print(answer.estimates()[["best", "low", "high"]])
ramp, flat = answer.samples.T
mean_ramp, mean_flat = (answer.weights * ramp).sum(), (answer.weights * flat).sum()
print(f"posterior mean: ramp {mean_ramp:.4f}, flat {mean_flat:.4f}")
