"""pip installs the package into a virtual environment."""

import os
import pathlib
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]


def test_pip_installs_the_package(tmp_path):
    environment = tmp_path / "environment"
    subprocess.run([sys.executable, "-m", "venv", "--system-site-packages", str(environment)], check=True)
    python = str(environment / "bin" / "python")
    settings = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
    # The build that runs this test; without it, pip would build all libraries again.
    settings["FIRN_BUILD_FOLDER"] = str(pathlib.Path(os.environ["PYTHONPATH"]).parent)
    # pip writes into the folder of the sources: it gets a copy of what it needs.
    source = tmp_path / "source"
    source.mkdir()
    for name in ("pyproject.toml", "setup.py"):
        (source / name).write_bytes((ROOT / name).read_bytes())
    (source / "python").mkdir()
    subprocess.run(["cp", "-r", str(ROOT / "python" / "firn"), str(source / "python")], check=True)
    subprocess.run([python, "-m", "pip", "install", "-q", "--no-build-isolation", "--no-deps", "--no-index", str(source)],
                   check=True, env=settings)
    case = ROOT / "cases" / "bounce" / "case.toml"
    output = subprocess.run([python, "-c", f"import firn; print(firn.__file__); firn.Case.load({str(case)!r})"],
                          check=True, env=settings, cwd=tmp_path, capture_output=True, text=True).stdout
    assert str(environment) in output
