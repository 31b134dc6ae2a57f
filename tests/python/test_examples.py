"""The examples run, and their results mean what they say."""

import importlib.util
import pathlib

import numpy
import pytest

import assur

FOLDER = pathlib.Path(__file__).parents[2] / "examples"


def example(name):
    spec = importlib.util.spec_from_file_location(name, FOLDER / (name + ".py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_a_four_bar_is_fitted_to_a_curve():
    pytest.importorskip("scipy")
    fit = example("fit_curve")
    design, distance, before = fit.main(designs=1500, refined=4)
    assert distance < 0.05 < 0.3 < before, "refining must bring a distant path close to a curve 2 m wide"
    # The design moves as a scene, on the same path.
    motion = assur.run(assur.scene_of(fit.linkage(design), 0, 1, 1 / 60))
    path = numpy.stack([motion["J4.x"], motion["J4.y"]], axis=1)[:-1]
    assert assur.timed_distance(path, fit.target()) == pytest.approx(distance, rel=1e-6)


def test_a_data_set_can_be_read_back(tmp_path):
    linkages = example("linkage_data")
    data = linkages.main(tmp_path / "linkages.npz", 600, seed=4)
    rows = len(data["sample"])
    assert 100 < rows < 400 and data["curves"].shape == (rows, 200, 2)
    curves = data["curves"].astype(float)
    assert abs(curves.mean(axis=1)).max() < 1e-6 and numpy.allclose((curves**2).sum(axis=2).mean(axis=1), 1, atol=1e-6)
    # Each path closes after one turn: the last step is about as long as its neighbours.
    steps = numpy.linalg.norm(numpy.diff(curves, axis=1, append=curves[:, :1]), axis=2)
    assert (steps[:, -1] < 3 * steps.max(axis=1).clip(0.01)).all() and (steps[:, -1] <= 3 * steps[:, -2] + 0.05).all()
    # A row in its place is the motion of its linkage as a scene.
    row = int(data["joints"].argmax())
    motion = assur.run(assur.scene_of(linkages.linkage_in(data, row), 0, 1, 0.005))
    name = f"J{data['joints'][row] - 1}"
    path = numpy.stack([motion[name + ".x"], motion[name + ".y"]], axis=1)[:-1]
    c, s = numpy.cos(data["angle"][row]), numpy.sin(data["angle"][row])
    placed = data["center"][row] + data["radius"][row] * curves[row] @ [[c, s], [-s, c]]
    assert abs(placed - path).max() < 1e-6
