"""Jacobian matrices, and rows of a simulator for a function."""

import numpy
import pytest

import assur


def test_output_jacobian():
    scene = assur.scene("four_bar:1").with_outputs("rocker_angle")
    simulator = assur.Simulator(assur.prepare(scene, controlled=["motor"], threads=1))
    assert simulator.drivers == ["motor"]
    j = simulator.jacobian()
    assert j.outputs == ["rocker_angle"] and j.drivers == ["motor"] and j.status.ok
    assert j.values.shape == (1, 1) and not j.values.flags.writeable
    # The crank lies along the line of the fixed points: the closed form gives -2/3.
    assert j.values[0, 0] == pytest.approx(-2 / 3, abs=1e-14)
    assert j.smallest_singular_value == pytest.approx(2 / 3, abs=1e-14)
    assert "1 output, 1 driver" in repr(j)
    before = simulator.output("rocker_angle")
    simulator.set("motor", 1e-6)
    assert simulator.step()
    assert simulator.output("rocker_angle") - before == pytest.approx(-2e-6 / 3, rel=1e-5)
    assert j.values[0, 0] == pytest.approx(-2 / 3, abs=1e-14), "the result is the caller's own"


def test_constraint_jacobian():
    sparse = pytest.importorskip("scipy.sparse")
    simulator = assur.Simulator(assur.prepare(assur.scene("stewart"), threads=1))
    j = simulator.constraint_jacobian()
    matrix = sparse.csc_matrix((j.data, j.indices, j.indptr), j.shape).toarray()
    assert matrix.shape == (len(j.equations), len(j.unknowns)) and len(set(j.unknowns)) == len(j.unknowns)
    assert numpy.linalg.matrix_rank(matrix) == len(j.unknowns)
    first = simulator.constraint_jacobian(0)
    n = first.shape[0]
    block = sparse.csc_matrix((first.data, first.indices, first.indptr), first.shape).toarray()
    assert (matrix[:n, :n] == block).all()
    assert "equation" in repr(j)
    with pytest.raises(assur.InputError, match="there is no group 1000"):
        simulator.constraint_jacobian(1000)


def test_stream_gives_the_rows_of_run():
    simulator = assur.Simulator(assur.prepare(assur.scene("slider_crank"), threads=1))
    motion = simulator.run()
    column = motion.columns[1]
    times, values = [], []

    def take(t, rows):
        assert rows.shape == (len(t), 1) and len(t) <= 100
        times.extend(t)
        values.extend(rows[:, 0])

    assert simulator.stream(take, columns=[column], every=2, block=100) == len(motion)
    assert times == motion.t[::2].tolist() and values == motion[column][::2].tolist()
    assert simulator.stream(lambda t, rows: None, times=[0, 0.1]) == 2
    with pytest.raises(ZeroDivisionError):
        simulator.stream(lambda t, rows: 1 / 0)
    with pytest.raises(assur.InputError, match="nothing"):
        simulator.stream(take, columns=["nothing"])
