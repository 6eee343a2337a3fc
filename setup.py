"""`pip install .`: builds the extension module with CMake. pyproject.toml has the metadata.

FIRN_BUILD_FOLDER names a folder that CMake has configured already; by default the module is built in
build/python. The libraries of scripts/packages.txt, [build] and [python], must be installed.
"""

import os
import pathlib
import shutil
import subprocess
import sys
import sysconfig

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).resolve().parent


class CMakeBuild(build_ext):
    def build_extension(self, extension):
        folder = pathlib.Path(os.environ.get("FIRN_BUILD_FOLDER", ROOT / "build" / "python")).resolve()
        if not (folder / "CMakeCache.txt").exists():
            subprocess.run(
                ["cmake", "-S", str(ROOT), "-B", str(folder), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                 "-DFIRN_TESTS=OFF", "-DFIRN_BENCHMARKS=OFF", f"-DPython3_EXECUTABLE={sys.executable}"],
                check=True)
        subprocess.run(["cmake", "--build", str(folder), "--target", "firn_python"], check=True)
        module = folder / "python" / "firn" / ("_core" + sysconfig.get_config_var("EXT_SUFFIX"))
        if not module.exists():
            raise SystemExit(f"{folder}: its module is for another version of Python than {sys.executable}")
        target = pathlib.Path(self.get_ext_fullpath(extension.name)).resolve()
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy2(module, target)


setup(ext_modules=[Extension("firn._core", sources=[])], cmdclass={"build_ext": CMakeBuild})
