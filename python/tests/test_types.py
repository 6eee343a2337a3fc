"""The annotations of the package, and that the stubs name all that the module has."""

import ast
import pathlib
import subprocess
import sys

import pytest

import firn
from firn import _core

PACKAGE = pathlib.Path(firn.__file__).resolve().parent


def test_stubs_are_complete():
    tree = ast.parse((PACKAGE / "_core.pyi").read_text())
    stubs = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    names = {name for name in dir(_core) if not name.startswith("_")}
    assert names == set(stubs)
    for name in names:
        if not isinstance(stubs[name], ast.ClassDef) or issubclass(getattr(_core, name), Exception):
            continue
        members = {m for m in vars(getattr(_core, name)) if not m.startswith("_")}
        stubbed = {node.name for node in stubs[name].body
                   if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")}
        assert members == stubbed, name


def test_public_names_have_docstrings():
    assert (PACKAGE / "py.typed").exists()
    for name in firn.__all__:
        public = getattr(firn, name)
        assert public.__doc__, name
        if isinstance(public, type) and public.__module__ != "firn._core":
            for member, value in vars(public).items():
                if callable(value) and not member.startswith("_"):
                    assert value.__doc__, f"{name}.{member}"


def test_types_agree():
    pytest.importorskip("mypy")
    done = subprocess.run([sys.executable, "-m", "mypy", "--strict", "--ignore-missing-imports",
                           "--cache-dir=/dev/null", "-p", "firn"], capture_output=True, text=True,
                          cwd=PACKAGE.parent)
    assert done.returncode == 0, done.stdout
