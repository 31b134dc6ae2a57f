"""Calls from Python and C against the same calls in C++, interleaved.

Usage: callers.py CALLERS_BENCH FOLDER_OF_THE_PACKAGE [ROUNDS [STEPS [MEMBERS]]]
"""

import statistics
import subprocess
import sys
import time

sys.path.insert(0, sys.argv[2])
import numpy  # noqa: E402

import assur  # noqa: E402

ROUNDS, STEPS, MEMBERS = (int(a) for a in (sys.argv[3:] + ["9", "200000", "10000"][len(sys.argv) - 3 :]))


def four_bar():
    b = assur.SceneBuilder("four_bar", 2).point("A", (0, 0), fixed=True).point("D", (3, 0), fixed=True)
    b.point("B", (1, 0)).point("C", (2.5, 2.4)).distance("crank", "A", "B", 1).distance("coupler", "B", "C", 3)
    b.distance("rocker", "D", "C", 2.5).drive_angle("motor", "A", "B", [0, 6.283185307179586])
    return b.output("C").time(0, 1, 0.005).build()


def loop():
    """ns for one turn of the loop, and a sum of outputs."""
    simulator = assur.Simulator(assur.prepare(four_bar(), controlled=["motor"], threads=1))
    motor, x = simulator.driver("motor"), simulator.index("C.x")
    set_target, step, output = simulator.set, simulator.step, simulator.output
    total = 0.0
    begin = time.perf_counter()
    for k in range(1, STEPS + 1):
        set_target(motor, 0.01 * k, 2.0)
        if not step():
            raise SystemExit(1)
        total += output(x)
    return 1e9 * (time.perf_counter() - begin) / STEPS, total


COUPLERS = 2.8 + 0.4 * numpy.arange(MEMBERS) / (MEMBERS - 1)
OTHERS = COUPLERS[::-1].copy()


def ensemble():
    """s to bind and run another table, and an output."""
    designs = assur.Ensemble(four_bar(), {"coupler": COUPLERS}, threads=1)
    designs.run()
    begin = time.perf_counter()
    designs.bind({"coupler": OTHERS})
    motion = designs.run()
    seconds = time.perf_counter() - begin
    column = motion["C.x"]
    first = motion.values.__array_interface__["data"][0]
    assert column.__array_interface__["data"][0] == first and motion.values.base is not None
    total = 0.0
    for value in column[:, 200].tolist():
        total += value
    return seconds, total


def compiled(*arguments):
    text = subprocess.run([sys.argv[1], *map(str, arguments)], check=True, capture_output=True, text=True).stdout
    return tuple(float(word) for word in text.split())


def compare(name, unit, here, there, language="Python"):
    pairs = [(here(), there()) for _ in range(ROUNDS)]
    assert all(a[1] == b[1] for a, b in pairs), "the numbers differ"
    mine, theirs = ([p[i][0] for p in pairs] for i in (0, 1))
    print(f"{name}: {language} {statistics.median(mine):.4g} {unit} ({min(mine):.4g} to {max(mine):.4g}), "
          f"C++ {statistics.median(theirs):.4g} ({min(theirs):.4g} to {max(theirs):.4g}); "
          f"median of the differences {statistics.median(a[0] - b[0] for a, b in pairs):.4g} {unit}, "
          f"of the ratios C++ / {language} {statistics.median(b[0] / a[0] for a, b in pairs):.3f}")


compare("set, step, output", "ns", loop, lambda: compiled("loop", STEPS))
compare("set, step, output", "ns", lambda: compiled("c", STEPS), lambda: compiled("loop", STEPS), "C")
compare(f"{MEMBERS} four-bars, bound and run", "s", ensemble, lambda: compiled("ensemble", MEMBERS))
