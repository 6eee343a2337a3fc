#!/usr/bin/env python3
"""Figures 4 to 12 of the paper, in this simulation: stills and plots from the runs of cases/validation.toml.

usage: scripts/paper_figures.py VALIDATION_FOLDER OUTPUT_FOLDER [--set NAME] [--seed N]

Takes the runs of one parameter set (the first of the suite) and one seed (1). Needs chromium, for the stills
are those of the replay on the pages of the runs.
"""
import argparse
import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile

BUCKET = "-1.05,0.42,0.72,0,0,0.09"  # azimuth, elevation, distance, and the place looked at
AUGER = "-1.05,0.3,1.1,0.06,0,-0.03"

ROOT = pathlib.Path(__file__).resolve().parent.parent
FIRN = str(ROOT / "firn")


def run(*command):
    done = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    if done.returncode != 0:
        sys.exit(f"paper_figures: {' '.join(str(c) for c in command)}: status {done.returncode}\n{done.stderr}")
    return done.stdout


class Runs:
    """The results files of a validation, by experiment."""

    def __init__(self, folder, parameter_set, seed):
        self.folder = pathlib.Path(folder)
        results = json.loads((self.folder / "results.json").read_text())
        self.set = parameter_set or results["parameter_sets"][0]["name"]
        self.files = {}
        for experiment in results["experiments"]:
            for one in experiment["runs"]:
                if (one["purpose"], one["parameter_set"], one["seed"]) == ("base", self.set, seed):
                    here = self.folder / "runs" / (one["key"] + ".h5")
                    self.files[experiment["name"]] = here if here.exists() else pathlib.Path(one["results_file"])

    def file(self, experiment):
        file = self.files.get(experiment)
        if not file or not file.exists():
            sys.exit(f"paper_figures: no run of \"{experiment}\" with \"{self.set}\" in {self.folder}")
        return file


class Figures:
    def __init__(self, out, work):
        self.out, self.work = pathlib.Path(out), pathlib.Path(work)
        self.out.mkdir(parents=True, exist_ok=True)
        self.pages = {}

    def page(self, results):
        """The page of a run, and the folder of its plots."""
        if results not in self.pages:
            page = self.work / (results.stem + ".html")
            plots = self.work / results.stem
            run(FIRN, "report", results, "-o", page, "--figures", plots)
            self.pages[results] = (page, plots)
        return self.pages[results]

    def still(self, name, results, size=(900, 640), **state):
        """A picture of the replay in a state as its links have it."""
        page = self.page(results)[0]
        state = "&".join(f"{k}={v}" for k, v in {**state, "still": 1, "stay": 1}.items())
        run("chromium", "--headless", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
            "--hide-scrollbars", f"--window-size={size[0]},{size[1]}", "--virtual-time-budget=20000",
            f"--user-data-dir={self.work / 'chromium'}", f"--screenshot={self.out / (name + '.png')}",
            f"{page.as_uri()}#{state}")
        print(self.out / (name + ".png"))

    def plot(self, name, folder, plot):
        shutil.copy(pathlib.Path(folder) / (plot + ".svg"), self.out / (name + ".svg"))
        print(self.out / (name + ".svg"))


def responses(results):
    measured = json.loads(run(FIRN, "measure", results, "--json"))["responses"]
    return {name: r["value"] for name, r in measured.items()}


def number(value):
    return value[0] if isinstance(value, list) else value


def particles(results, work):
    folder = work / (results.stem + "-csv")
    run(FIRN, "export", results, "--to", "csv", "--every", "100000", "-o", folder)
    with open(folder / "particles.csv") as file:
        return list(csv.DictReader(file))


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("folder")
    parser.add_argument("output")
    parser.add_argument("--set", default="")
    parser.add_argument("--seed", type=int, default=1)
    a = parser.parse_args()
    runs = Runs(a.folder, a.set, a.seed)
    with tempfile.TemporaryDirectory() as folder:
        work = pathlib.Path(folder)
        f = Figures(a.output, work)
        run(FIRN, "report", a.folder, "-o", work / "suite.html", "--no-replays", "--figures", work / "suite")

        # 4: the cube, as it lies on a table.
        cube = work / "cube.h5"
        run(FIRN, "run", ROOT / "cases/icemaker/platen_test.toml", "--set", "case.duration=20 ms", "-o", cube)
        f.still("figure-04-cube", cube, size=(600, 400), t=0, hide="upper platen,lower platen", color="batch",
                view="-1.2,0.7,0.14,0,0,0.01")

        # 5: what stays in the drained box, with the lines through both slopes.
        run(FIRN, "export", runs.file("drained repose"), "--to", "png", "-o", f.out / "figure-05-drained.png")

        # 6: arm and ejector over a cycle, as angles and as pictures.
        harvest = runs.file("harvest")
        short = work / "cycle.h5"
        run(FIRN, "run", ROOT / "cases/icemaker/harvest.toml", "--set", "case.duration=4 s", "-o", short)
        f.plot("figure-06-angles", f.page(short)[1], "moving-parts")
        for letter, t in (("a", 18.0), ("b", 19.5)):
            f.still(f"figure-06{letter}-harvest", harvest, t=t, hide="cover,chute,container,guard", color="batch", view=BUCKET)

        # 7: the bucket is out; what fell behind it is marked, with its way.
        pull = runs.file("bucket pull")
        state = dict(t=round(sum(number(v) for k, v in responses(pull).items() if k.startswith("duration_")), 2),
                     hide="cover,container,guard", color="batch", view="-1.05,0.35,1.1,0,0.1,0")
        lost = [p for p in particles(pull, work) if p["lost_time [s]"]]
        if lost:
            last = max(lost, key=lambda p: float(p["lost_time [s]"]))
            state.update(particle=last["particle"], t=round(float(last["lost_time [s]"]), 2))
        f.still("figure-07-pulled", pull, **state)

        # 8 and 9: the half full bucket half way, and what has come out of it.
        half = runs.file("auger, half full")
        r = responses(half)
        start = number(r["duration_harvest"]) + number(r["duration_settle"])
        f.still("figure-08-half-full", half, t=round(start + 0.5 * number(r["duration_dispense"]), 2), color="time",
                hide="mold,ejector,stripper,cover,arm,guard", view=AUGER)
        f.plot("figure-09-batches", work / "suite", "mixing-2")

        # 10: the full bucket by columns, before and after.
        full = runs.file("auger, full")
        r = responses(full)
        start = number(r["duration_harvest"]) + number(r["duration_settle"])
        for letter, t in (("a", start + 0.05), ("b", start + number(r["duration_dispense"]))):
            f.still(f"figure-10{letter}-columns", full, t=round(t, 2), color="tag",
                    hide="mold,ejector,stripper,cover,arm,guard", view=AUGER)
        f.plot("figure-10c-columns", work / "suite", "columns-2")

        # 11: forces on the container, and where it is hit. 12: loads on all cubes compared with the breaking force.
        glass = runs.file("glass impact")
        f.plot("figure-11-impact", f.page(glass)[1], "loads-on-boundaries")
        f.still("figure-11-map", glass, t=3, map="peak_stress", log=1, alone=1, hide="chute,mold,ejector,stripper,cover,arm,guard,bucket,auger,flap",
                view="-1.05,1.4,0.4,0.212,0,-0.24")
        f.plot("figure-12-loads", work / "suite", "damage")


if __name__ == "__main__":
    main()
