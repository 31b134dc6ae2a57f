import math
import os
import random

import numpy
import pytest

import assur


def robot(grid=True):
    """A platform on three legs that rest at the start."""
    scene = assur.SceneBuilder("platform", 2)
    scene.point("A", (0, 0), fixed=True).point("B", (3, 1.1), fixed=True).point("C", (1.5, 3), fixed=True)
    scene.point("P", (1, 1.2)).point("Q", (2, 1.1)).point("R", (1.5, 1.9))
    for a, b in ("PQ", "QR", "RP"):
        scene.distance(a + b, a, b)
    home = [math.hypot(1, 1.2), 1.0, 1.1]
    for name, a, b, length in zip(("leg1", "leg2", "leg3"), "ABC", "PQR", home):
        scene.drive_distance(name, a, b, length)
    if grid:
        scene.time(0, 1, 0.01)
    return assur.prepare(scene.build(), controlled=["leg1", "leg2", "leg3"], threads=1,
                         strategy="irreducible/eigen"), home


def test_a_rejected_target_does_not_move_the_robot_later(tmp_path):
    prepared, home = robot()
    prepared.save(tmp_path / "plan")
    for plan in (prepared, assur.load_plan(tmp_path / "plan")):
        simulator = assur.Simulator(plan)
        there = simulator.outputs.copy()
        simulator.set("leg1", 9)
        assert not simulator.step()
        assert numpy.array_equal(simulator.outputs, there)
        assert simulator.step() and simulator.outputs == pytest.approx(there, abs=1e-14)
        assert simulator.step(simulator.time + 1e-3) and simulator.outputs == pytest.approx(there, abs=1e-14)
        simulator.set("leg2", math.nan)
        simulator.set("leg1", home[0] + 0.01)
        assert not simulator.step() and simulator.step() and simulator.outputs == pytest.approx(there, abs=1e-14)


def test_an_exception_of_a_law_drops_the_targets():
    fails = False

    def law(t):
        if fails:
            raise ValueError("no value")
        return (t, 1, 0)

    scene = assur.SceneBuilder("two", 2).point("A", (0, 0), fixed=True).point("B", (1, 0)).point("E", (2, 0))
    scene.drive_angle("motor", "A", "B", 0.5).drive_coordinate("x", "E.x", assur.Law.function(law)).drive_coordinate("y", "E.y", 0)
    simulator = assur.Simulator(assur.prepare(scene.time(0, 1, 0.01).build(), controlled=["motor", "x"]))
    for step in (lambda: simulator.step(), lambda: simulator.step(simulator.time + 0.01)):
        there = simulator.output("B.x")
        fails = True
        simulator.set("motor", 1.0)
        simulator.set("x", 3)
        with pytest.raises(ValueError):
            step()
        fails = False
        assert simulator.step() and simulator.output("B.x") == pytest.approx(there, abs=1e-15)
        assert simulator.output("E.x") == pytest.approx(simulator.time, abs=1e-14)


def test_steps_without_a_time_grid_reach_their_targets():
    scene = assur.SceneBuilder("b", 2).point("A", (0, 0), fixed=True).point("B", (1, 0)).drive_angle("q", "A", "B", 0.0)
    simulator = assur.Simulator(assur.prepare(scene.output("B.position").build(), controlled=["q"]))
    for angle in (0.5, -0.25, 3):
        simulator.set("q", angle)
        assert simulator.step() == "ok"
        assert simulator.outputs == pytest.approx([math.cos(angle), math.sin(angle)], abs=1e-15)
    assert simulator.time == 3


def test_the_constraint_jacobian_of_a_loaded_plan(tmp_path):
    prepared, _ = robot()
    prepared.save(tmp_path / "plan")
    a = assur.Simulator(prepared).constraint_jacobian()
    b = assur.Simulator(assur.load_plan(tmp_path / "plan")).constraint_jacobian()
    assert len(a.equations) == len(a.unknowns) > 0 and len(a.data) > 0
    assert a.equations == b.equations and a.unknowns == b.unknowns
    assert numpy.array_equal(a.data, b.data) and numpy.array_equal(a.indices, b.indices)
    assert numpy.array_equal(a.indptr, b.indptr) and a.shape == b.shape


def test_random_commands_leave_the_bits_of_a_twin():
    """One simulator gets all commands, its twin those that succeed."""
    prepared, home = robot()
    every, twin = assur.Simulator(prepared), assur.Simulator(prepared)
    draw = random.Random(52)
    at = list(home)
    failed = arrived = 0
    cycles = int(os.environ.get("ASSUR_RANDOM_SCENES", 1000))
    for k in range(cycles):
        jump = draw.choice((0.03, 0.03, 0.03, 3))
        begin = home if draw.random() < 0.1 else at  # far from home the commands would be like each other
        targets = {}
        for i in range(3):
            if begin is home or draw.random() < 0.7:
                value = math.nan if draw.random() < 0.03 else begin[i] + draw.uniform(-jump, jump)
                targets[i] = (value, draw.uniform(-3, 3) if draw.random() < 0.3 else 0.0)
        until = every.time + draw.uniform(-0.01, 0.03) if draw.random() < 0.2 else None

        def give(to):
            for i, (value, rate) in targets.items():
                to.set(f"leg{i + 1}", value, rate)
            return to.step() if until is None else to.step(until)

        status = give(every)
        if status:
            arrived += 1
            assert give(twin) == status.code, k
            for i, (value, _) in targets.items():
                at[i] = value
        elif until is not None:
            state = twin.save()
            every.restore(state)
            twin.restore(state)
        else:
            failed += 1
        assert every.time == twin.time, k
        assert numpy.array_equal(every.outputs, twin.outputs), k
    assert failed > cycles / 20 and arrived > cycles / 4


def test_statuses_name_their_driver():
    prepared, _ = robot()
    simulator = assur.Simulator(prepared)
    assert simulator.name_of(simulator.step()) == ""
    simulator.set("leg3", math.inf)
    status = simulator.step()
    assert status == "not_finite" and status.index == 2 and simulator.name_of(status) == "leg3"
