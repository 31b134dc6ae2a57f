"""Runs a sample with the installed package, whose folder is the argument."""

import pathlib
import sys

try:
    import numpy  # noqa: F401
except ImportError:
    sys.exit(77)  # skipped
sys.path.insert(0, sys.argv[1])
sys.dont_write_bytecode = True
import assur

motion = assur.run("stewart")
print(assur.__file__, motion)
assert pathlib.Path(assur.__file__).is_relative_to(sys.argv[1])
assert abs(motion["handle1"][-1] - 2.0782333566916) < 1e-12  # as in use_assur_core.cpp
try:
    assur.scene("stewart", omeja=2)
    sys.exit("a wrong option was accepted")
except assur.InputError as error:  # thrown by the library, caught in the module
    print(error)
