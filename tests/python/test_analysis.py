"""Assembly modes, ranges of drivers, references and proofs."""

import math

import numpy
import pytest

import assur
from conftest import four_bar


def test_modes_of_a_four_bar(mechanism):
    modes = assur.assembly_modes(mechanism)[-1]
    assert modes.group == "C" and modes.unknowns == ["C.x", "C.y"] and len(modes) == 2 and modes.has_start
    assert modes.complete and modes.why_none == "" and modes.folds.shape == (0, 2) and "2 modes" in repr(modes)
    # Mirror images about the line from B = (1, 0) to D = (3, 0).
    assert numpy.allclose(modes.values[0], modes.values[1] * [1, -1], rtol=1e-14)
    assert modes[1] == {"C.x": modes.values[1, 0], "C.y": modes.values[1, 1]}
    assert modes.nearest("C", (2.5, -2)) == 1 and all(1 <= c < 10 for c in modes.conditions)
    with pytest.raises(IndexError):
        modes[2]
    with pytest.raises(assur.InputError):
        modes.nearest("C", [1])

    other = assur.prepare(mechanism, modes={"C": 1}, threads=1)
    motion = assur.run(other)
    assert motion["C.y"][0] == modes[1]["C.y"] and (motion["C.y"] < 0).all()
    # The driven line is the same, and so are all mirror images.
    turned = assur.run(mechanism.with_laws({"motor": [0, -2 * math.pi]}))
    assert numpy.allclose(motion["C.y"], -turned["C.y"], atol=1e-12)
    assert motion.prepared.scene.name == "four_bar" and assur.Simulator(other).prepared.groups == other.groups
    with pytest.raises(assur.InputError, match="Q"):
        assur.prepare(mechanism, modes={"Q": 0})


def test_the_range_of_a_driver(mechanism):
    full = assur.motion_range(mechanism)
    assert full.driver == "motor" and full.unit == "rad" and full.start == 0 and "rad" in repr(full)
    assert full.low.code == full.high.code == "ok" and full.high.reached == pytest.approx(2 * math.pi)
    # A crank that is longer than the rocker stops where coupler and rocker are in line.
    a, b, c, d = 2.0, 2.5, 2.0, 3.0
    values = {"crank": a, "coupler": b, "rocker": c, "D.x": d, "B.x": a, "C.x": 3.5, "C.y": 1.9}
    short = assur.motion_range(mechanism.with_values(values))
    fold = math.acos((a * a + d * d - (b + c) ** 2) / (2 * a * d))
    assert short.high.code == "fold" and short.high.group == "C" and "fold" in repr(short.high)
    assert short.high.reached == pytest.approx(fold, abs=1e-10) and short.high.beyond >= short.high.reached
    assert short.passed == [] and all(abs(x) < 1e-6 for x in short.change_points)
    with pytest.raises(assur.InputError, match="moter"):
        assur.motion_range(mechanism, "moter")


def test_references_and_proofs(mechanism):
    motion = assur.run(assur.prepare(mechanism, threads=1))
    error = assur.forward_error(motion)
    assert set(error) == {"position", "velocity", "acceleration"} and 0 < error["position"] < 1e-14
    # Numbers in half the digits are far from the reference.
    assert assur.forward_error(assur.run(assur.prepare(mechanism, accuracy=1e-5, threads=1)))["position"] < 1e-5
    positions = assur.run(mechanism.with_outputs("C.position"))
    assert assur.forward_error(positions)["velocity"] is None

    proofs = assur.certify(motion)
    assert len(proofs) == len(motion) and proofs[7].time == motion.t[7]
    worst = assur.worst_of(proofs)
    assert worst.radius == max(p.radius for p in proofs) < 1e-13 and worst.uniqueness > 1e-3
    assert worst.group == "C" and worst.why_not == "" and "radius" in repr(worst)
    simulator = assur.Simulator(mechanism)
    simulator.step(0.3)
    assert assur.certify(simulator).time == 0.3


def test_plans_tell_their_candidates(mechanism):
    prepared = assur.prepare(mechanism, threads=1)
    assert prepared.expected_seconds > 0
    candidates = prepared.candidates()
    times = [c.expected_seconds for c in candidates if not c.why_not]
    assert times[0] > 0 and times[0] <= 1.03 * min(times) and all(c.factor >= 1 for c in candidates)
    assert candidates[0].origin in ("measured", "interpolated", "extrapolated", "prior")
    assert assur.prepare(mechanism, strategy=candidates[0].strategy, threads=1) and "expected" in repr(candidates[0])
    with pytest.raises(assur.InputError, match="class"):
        prepared.candidates(99)
    model, messages = assur.machine_model()
    assert model.samples >= 0 and isinstance(model.source, str) and "sample" in repr(model)
    assert isinstance(messages, list)
    machine = assur.this_machine()
    assert machine.processors >= len(machine.cores) and machine.quota >= 0 and machine.numa_nodes >= 1
    for level, size, cores in machine.caches:
        assert level in (1, 2, 3) and size > 1024 and cores >= 1


def test_figures_of_groups(mechanism):
    simulator = assur.Simulator(mechanism)
    simulator.step(0.1)
    figures = simulator.examine()
    assert list(figures) == simulator.prepared.groups
    assert set(figures["C"]) == {"residual", "condition", "estimated_error"}
    assert figures["C"]["residual"] < 1e-14 and 1 < figures["C"]["condition"] < 100
    assert 0 < figures["C"]["estimated_error"] < 1e-13


def test_retreat_leaves_a_limit():
    scene = four_bar().with_values(coupler=2.0, rocker=1.4)
    simulator = assur.Simulator(scene)
    assert not simulator.step(0.9)
    stuck = simulator.time
    simulator.retreat()
    assert simulator.time < stuck and simulator.step(simulator.time - 1e-4)
