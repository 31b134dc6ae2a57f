"""Sweeps have the numbers of the command, and those of ensembles."""

import csv
import json
import os
import pathlib
import signal
import subprocess
import threading

import numpy
import pytest

import assur

VARY = {"coupler": (1.9, 3.4), "D.x": (2.5, 3.5)}
TARGET = [[1.2, 1.8], [2, 2.4], [3, 2.2]]


def test_a_sweep_is_an_ensemble_of_its_points(mechanism):
    table = assur.sweep(mechanism, VARY, 300, threads=1, reduce=["max", "range", "mean"])
    assert list(table)[:3] == ["sample", "coupler", "D.x"] and table["sample"].tolist() == list(range(300))
    for name, (low, high) in VARY.items():
        assert (low <= table[name]).all() and (table[name] <= high).all()
        assert numpy.ptp(table[name]) > 0.9 * (high - low)
    ensemble = assur.Ensemble(mechanism, {name: table[name] for name in VARY}, threads=1)
    x = ensemble.summarize(["C.x"])["C.x"]
    assert numpy.allclose(table["C.x.max"], x["maximum"], rtol=0, atol=1e-12, equal_nan=True)
    assert numpy.allclose(table["C.x.range"], x["maximum"] - x["minimum"], rtol=0, atol=1e-12, equal_nan=True)
    codes = [o.status.code if not o.cannot else "not_assembled" for o in ensemble.outcomes]
    assert table["status"].tolist() == codes and {"ok", "fold"} <= set(codes)
    part = assur.sweep(mechanism, VARY, 300, range=(40, 60), threads=2, reduce=["max", "range", "mean"])
    assert all(numpy.array_equal(part[name], table[name][40:60], equal_nan=name != "status") for name in table)


def test_samplers_and_paths(mechanism):
    grid = assur.sweep(mechanism, VARY, 9, sampler="grid", trace="C", target=TARGET, compare="shape")
    assert grid["D.x"].tolist() == [2.5, 3, 3.5] * 3
    assert grid["coupler"].tolist() == [1.9] * 3 + [2.65] * 3 + [3.4] * 3
    done = grid["status"] == "ok"
    assert done.any() and (numpy.isfinite(grid["C.distance"]) == done).all()
    k = int(done.nonzero()[0][0])
    motion = assur.run(mechanism.with_values({name: grid[name][k] for name in VARY}))
    path = numpy.stack([motion["C.x"], motion["C.y"]], axis=1)
    assert grid["C.distance"][k] == pytest.approx(assur.shape_distance(path, TARGET), abs=1e-9)
    sobol = assur.sweep(mechanism, VARY, 64, sampler="sobol", seed=3)
    # Each half of each range has half of the points.
    assert all((sobol[name] < (low + high) / 2).sum() == 32 for name, (low, high) in VARY.items())


def test_wrong_sweeps(mechanism):
    for arguments, what in [
        ({"vary": {}}, "at least one"), ({"sampler": "dice"}, "dice"), ({"reduce": ["median"]}, "median"),
        ({"range": (5, 3)}, "range"), ({"trace": "C"}, "target"), ({"trace": "Q", "target": TARGET}, "Q"),
        ({"vary": {"q": (0, 1)}}, "q"), ({"sampler": "grid"}, "100"), ({"vary": {"coupler": (3, 2)}}, "range"),
        ({"trace": "C", "target": TARGET, "compare": "timed"}, "path 201"),
    ]:
        with pytest.raises(assur.InputError, match=what) as refusal:
            assur.sweep(mechanism, **{"vary": VARY, "samples": 101, **arguments})
        assert "--" not in str(refusal.value)


def test_progress_of_a_sweep(mechanism):
    class Bar:
        total = done = 0

        def update(self, n):
            self.done += n

    bar = Bar()
    assur.sweep(mechanism, VARY, 2500, reduce=["last"], progress=bar)
    assert bar.done == 2500


def test_ctrl_c_keeps_the_samples_that_are_done(mechanism):
    threading.Timer(0.5, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(assur.Interrupted) as stopped:
        assur.sweep(mechanism, VARY, 10**7, threads=1, reduce=["max"])
    table = stopped.value.result
    done = len(table["sample"])
    assert 0 < done < 10**7 and done % 1024 == 0 and table["sample"][-1] == done - 1
    part = assur.sweep(mechanism, VARY, 10**7, range=(0, 100), reduce=["max"])
    assert numpy.array_equal(part["C.x.max"], table["C.x.max"][:100], equal_nan=True)


def test_the_command_writes_the_same_numbers(tmp_path, mechanism):
    command = pathlib.Path(assur.__file__).parents[2] / "assur"
    if not command.exists():
        pytest.skip("the command is not built")
    scene = tmp_path / "four_bar.json"
    content = json.loads(mechanism.to_json())
    content["parameters"] = {"a": 3, "d": 3}  # the command varies parameters only
    content["constraints"]["coupler"]["value"], content["points"]["D"]["at"][0] = "=a", "=d"
    scene.write_text(json.dumps(content))
    ranges = dict(zip("ad", VARY.values()))
    (tmp_path / "target.csv").write_text("x,y\n" + "".join(f"{x},{y}\n" for x, y in TARGET))
    vary = ",".join(f"{name}={low}:{high}" for name, (low, high) in ranges.items())
    subprocess.run([command, "sweep", scene, "--vary", vary, "--samples", "1500", "--seed", "7", "--reduce", "max,last",
                    "--trace", "C", "--target", "target.csv", "--compare", "nearest", "--out", "rows.csv", "--quiet"],
                   check=True, cwd=tmp_path, stdout=subprocess.DEVNULL)
    rows = list(csv.DictReader((tmp_path / "rows.csv").open()))
    table = assur.sweep(assur.scene(scene), ranges, 1500, seed=7, reduce=["max", "last"], trace="C", target=TARGET)
    assert list(rows[0]) == list(table) and len(rows) == 1500
    for name, column in table.items():
        theirs = [row[name] for row in rows]
        if name == "status":
            assert column.tolist() == theirs
        else:
            assert numpy.array_equal(column, [float(x or "nan") for x in theirs], equal_nan=True), name
