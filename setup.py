"""pip install: builds the module assur._core by CMake."""

import pathlib
import re
import shutil
import subprocess
import sys

from setuptools import Extension, setup
from setuptools.command.build_ext import build_ext

ROOT = pathlib.Path(__file__).parent.resolve()


class CMakeBuild(build_ext):
    def build_extension(self, ext):
        build = pathlib.Path(self.build_temp).resolve()
        options = {"CMAKE_BUILD_TYPE": "Release", "BUILD_TESTING": "OFF", "ASSUR_BENCH": "OFF", "ASSUR_PYTHON": "ON",
                   "PYTHON_EXECUTABLE": sys.executable}
        settings = [f"-D{name}={value}" for name, value in options.items()]
        subprocess.run(["cmake", "-G", "Ninja", "-S", ROOT, "-B", build, *settings], check=True)
        subprocess.run(["cmake", "--build", build, "--target", "assur_python"], check=True)
        target = pathlib.Path(self.get_ext_fullpath(ext.name))
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(next((build / "python" / "assur").glob("_core*.so")), target)


setup(
    version=re.search(r'ASSUR_VERSION "(.*)"', (ROOT / "include/assur/version.hpp").read_text()).group(1),
    ext_modules=[Extension("assur._core", [])],
    cmdclass={"build_ext": CMakeBuild},
)
