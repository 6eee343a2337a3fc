"""The notebook of the drained calibration, with 60 cubes of softer ice in a small box."""

import pathlib
import re

from conftest import SOURCE
from notebook import execute, pictures_of, text_of

NOTEBOOK = SOURCE / "examples" / "python" / "drained_calibration.ipynb"

SMALL = {r"^count = 880": "count = 60", r"^box = .*": 'box = "12 3 10 in"',
         r"^door_width = .*": 'door_width = "4 in"', r'^young_modulus = "0.01 GPa"': 'young_modulus = "0.001 GPa"',
         r'^pour_height = .*': 'pour_height = "0.4 m"'}


def small_study(folder):
    """The shipped study of a small case."""
    shipped = SOURCE / "cases" / "drained_repose"
    text = (shipped / "case.toml").read_text()
    for pattern, line in SMALL.items():
        text, count = re.subn(pattern, line, text, flags=re.MULTILINE)
        assert count == 1, pattern
    (folder / "case.toml").write_text(text)
    study = (shipped / "study.toml").read_text()
    (folder / "study.toml").write_text(study.replace("../measurements", str(SOURCE / "cases" / "measurements")))
    return folder / "study.toml"


def test_notebook(tmp_path):
    study = small_study(tmp_path)
    book = execute(NOTEBOOK, tmp_path, {"jobs": 2, "study_file": study})
    text = text_of(book)
    assert re.search(r"angle of repose -?\d+\.\d \+- \d+\.\d deg", text), text
    assert re.search(r"^\d\d runs in", text, re.MULTILINE), text
    assert re.search(r"paper's table: \d+\.\d \+- \d+\.\d deg", text), text
    assert pictures_of(book) == 2
    assert (tmp_path / "drained_repose" / "study" / "report.html").exists()


def test_notebook_has_no_outputs():
    import nbformat

    book = nbformat.read(NOTEBOOK, as_version=4)
    assert all(not c.outputs and c.execution_count is None for c in book.cells if c.cell_type == "code")
