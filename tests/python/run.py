"""Runs pytest on the tests beside this file. Arguments: the folder that has the package assur."""

import pathlib
import sys

sys.dont_write_bytecode = True
sys.path[:0] = [sys.argv[1], str(pathlib.Path(__file__).parent)]
try:
    import numpy  # noqa: F401
    import pytest
except ImportError as missing:
    print(missing)
    sys.exit(77)
sys.exit(pytest.main(["-q", "-p", "no:cacheprovider", str(pathlib.Path(__file__).parent)]))
