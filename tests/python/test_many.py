import os
import signal
import threading
import types

import numpy
import pytest

import assur


def test_an_ensemble_from_arrays(mechanism):
    coupler = numpy.linspace(2.8, 3.2, 50)
    ensemble = assur.Ensemble(mechanism, {"coupler": coupler, "D.x": 3.0}, threads=1)
    motion = ensemble.run()
    assert motion.values.shape == (50, 201, len(motion.columns)) and motion["C.x"].shape == (50, 201)
    assert numpy.shares_memory(motion["C.x"], motion.values) and len(motion) == len(ensemble) == 50
    assert (motion.rows == 201).all() and "C.x" in motion and motion.keys() == motion.columns and motion.t[-1] == 1
    for i in (0, 17, 49):
        alone = assur.run(mechanism.with_values(coupler=coupler[i]))
        assert numpy.allclose(motion.values[i], alone.values, rtol=0, atol=1e-9)
    assert ensemble.report.status.ok and ensemble.outcomes[0].status.ok and ensemble.names == ["coupler", "D.x"]
    assert ensemble.outcomes[0].reached == 1 and ensemble.outcomes[0].cannot == "" and not ensemble.outcomes[0].alone
    assert ensemble.outcomes[0].events == [] and "ok" in repr(ensemble.outcomes[0])
    assert ensemble.prepared.name == "four_bar" and "50 members" in repr(ensemble) and "50 members" in repr(motion)
    figures = ensemble.summarize(["C.x"])["C.x"]
    assert numpy.array_equal(figures["maximum"], motion["C.x"].max(axis=1))
    assert numpy.array_equal(figures["maximum_time"], motion.t[motion["C.x"].argmax(axis=1)])
    assert set(figures) == {"minimum", "maximum", "minimum_time", "maximum_time", "mean", "last"}

    ensemble.bind({"D.x": 3.1, "coupler": coupler[:3]})
    again = ensemble.run([0, 0.5])
    assert again.values.shape[:2] == (3, 2)
    alone = assur.run(mechanism.with_values({"coupler": coupler[2], "D.x": 3.1}), [0, 0.5])
    assert numpy.allclose(again.values[2], alone.values, rtol=0, atol=1e-9)


def test_named_outputs_have_the_same_bits(mechanism):
    couplers = numpy.linspace(1.9, 3.2, 40)  # the shortest ones jam
    ensemble = assur.Ensemble(mechanism, {"coupler": couplers, "rocker": 1.4}, threads=1)
    every = ensemble.run()
    some = ensemble.run(outputs=["rocker_angle", "C.x"])
    assert some.columns == ["rocker_angle", "C.x"] and some.values.shape == (40, 201, 2)
    assert 0 < (some.rows < 201).sum() < 40 and numpy.array_equal(some.rows, every.rows)
    for name in some.columns:
        assert numpy.array_equal(some[name], every[name], equal_nan=True)
    early = ensemble.run([0, 0.1], outputs=["C.x"])
    assert early.values.shape == (40, 2, 1)
    assert numpy.array_equal(early["C.x"], ensemble.run([0, 0.1])["C.x"], equal_nan=True)
    with pytest.raises(assur.InputError, match="C.q"):
        ensemble.run(outputs=["C.q"])


def test_streams(mechanism):
    ensemble = assur.Ensemble(mechanism, {"coupler": numpy.linspace(1.9, 3.2, 40), "rocker": 1.4}, threads=2)
    motion = ensemble.run()
    blocks = {}
    ensemble.stream(lambda *rows: blocks.setdefault(rows[0], []).append(rows[1:]), columns=["C.x", "C.vy"], every=3,
                    block=20)
    assert set(blocks) == set(motion.rows.nonzero()[0]) and len(blocks[39]) == 4
    for i, of in blocks.items():
        t, values = (numpy.concatenate(part) for part in zip(*of))
        assert (numpy.diff(t) > 0).all() and all(len(part[0]) <= 20 for part in of)
        assert numpy.array_equal(t, motion.t[: motion.rows[i] : 3])
        assert numpy.array_equal(values, motion.values[i, : motion.rows[i] : 3][:, [0, 3]])
    whole = {}
    ensemble.stream(lambda i, t, values: whole.update({i: values}), times=[0, 0.01, 0.02])
    assert whole[5].shape == (3, len(motion.columns))

    def full(*rows):
        raise RuntimeError("the disk is full")

    with pytest.raises(RuntimeError, match="disk"):
        ensemble.stream(full)
    with pytest.raises(assur.InputError, match="every"):
        ensemble.stream(full, every=0)


def test_files_of_members(tmp_path, mechanism):
    motion = assur.Ensemble(mechanism, {"coupler": [2.9, 3.0]}).run()
    motion.write_npy(tmp_path / "members.npy", every=10, single=True)
    stored = numpy.load(tmp_path / "members.npy")
    assert stored.shape == (2, 21) and stored["C.x"].dtype == numpy.float32
    assert numpy.array_equal(stored["C.x"], motion["C.x"][:, ::10].astype(numpy.float32))
    motion.write_csv(tmp_path / "members.csv")
    table = numpy.genfromtxt(tmp_path / "members.csv", delimiter=",", names=True)
    assert table.shape == (402,) and table["member"][-1] == 2 and table["Cx"][-1] == motion["C.x"][1, -1]
    with pytest.raises(assur.MachineError, match="nowhere"):
        motion.write_csv(tmp_path / "nowhere" / "members.csv")


def test_a_closed_ensemble(mechanism):
    with assur.Ensemble(mechanism, {"coupler": [2.9, 3.0]}) as ensemble:
        motion = ensemble.run()
        x = motion["C.x"].copy()
    assert repr(ensemble) == "Ensemble(closed)" and numpy.array_equal(motion["C.x"], x)
    for use in (ensemble.run, lambda: ensemble.bind({"coupler": [3]}), lambda: ensemble.outcomes, lambda: len(ensemble),
                lambda: ensemble.stream(print), lambda: ensemble.summarize(["C.x"]), lambda: ensemble.report):
        with pytest.raises(assur.InputError, match="closed"):
            use()
    ensemble.close()


def test_members_that_fail(mechanism):
    ensemble = assur.Ensemble(mechanism, {"coupler": [3, 2.0, 0.1], "rocker": [2.5, 1.4, 0.1]})
    motion = ensemble.run()
    assert ensemble.outcomes[1].status.code == "fold" and ensemble.outcomes[2].cannot
    assert 0 < motion.rows[1] < 201 and motion.rows[2] == 0
    assert numpy.isnan(motion["C.x"][1, motion.rows[1] :]).all() and numpy.isnan(motion["C.x"][2]).all()


def test_members_of_which_none_can_be_assembled(mechanism):
    with assur.Ensemble(mechanism, {"coupler": [6.0, 6.1]}) as ensemble:
        motion = ensemble.run()
        assert (motion.rows == 0).all() and numpy.isnan(motion.values).all() and motion["C.x"].shape == (2, 201)
        for outcome in ensemble.outcomes:
            assert outcome.status == "not_assembled" and "group C cannot be assembled" in outcome.cannot
        assert ensemble.report.status == "not_assembled" and ensemble.prepared.name == "four_bar"
        ensemble.bind({"coupler": [3.0, 6.1, 3.1]})
        assert list(ensemble.run().rows) == [201, 0, 201]
    nowhere = mechanism.with_values(rocker=0.1)
    ensemble = assur.Ensemble(nowhere, {"coupler": [0.3]})
    assert ensemble.run().rows == [0] and len(ensemble.summarize(["C.x"])["C.x"]["mean"]) == 1
    with pytest.raises(assur.NumericalError, match="scene as written"):
        ensemble.prepared
    assert repr(ensemble) == "Ensemble('four_bar', 1 member by coupler)"
    with pytest.raises(assur.InputError, match="abacus"):
        assur.Ensemble(mechanism, {"coupler": [6.0, 6.1]}, strategy="groups/abacus")


def test_members_that_stand(mechanism):
    """They are solved in lanes, once in each run."""
    b = assur.SceneBuilder("stands", 2).point("A", (0, 0), fixed=True).point("D", (3, 0), fixed=True)
    b.point("B", (1, 0)).point("C", (2.5, 2.4)).distance("coupler", "B", "C", 3).distance("rocker", "D", "C", 2.5)
    stands = b.drive_angle("motor", "A", "B", 0.0).output("C.position").build()
    lengths = numpy.linspace(2.9, 3.1, 40)
    ensemble = assur.Ensemble(stands, {"coupler": lengths}, threads=1)
    motion = ensemble.run()
    assert ensemble.report.counters["group_solutions"] >= 40 and ensemble.report.fallbacks == []
    c = motion.values[:, 0]
    assert numpy.allclose(numpy.hypot(c[:, 0] - 1, c[:, 1]), lengths, rtol=0, atol=1e-14)
    assert numpy.allclose(numpy.hypot(c[:, 0] - 3, c[:, 1]), 2.5, rtol=0, atol=1e-14)


def test_wrong_tables(mechanism):
    for values, what in [({}, "at least one"), ({"a": [1, 2], "b": [1, 2, 3]}, "3 values"), ({"q": [1]}, "q"),
                         ({"coupler": [[1, 2]]}, "one number")]:
        with pytest.raises(assur.InputError, match=what):
            assur.Ensemble(mechanism, values)
    with pytest.raises(assur.InputError, match="names"):
        assur.Ensemble(mechanism, {"coupler": [3]}).bind({"crank": [1]})
    with pytest.raises(assur.InputError, match="C.q"):
        assur.Ensemble(mechanism, {"coupler": [3]}).run()["C.q"]


def test_tables_of_other_packages(mechanism):
    motion = assur.Ensemble(mechanism, {"coupler": [2.9, 3.0]}).run()
    pytest.importorskip("pandas")
    assert motion.to_pandas().loc[(1, 1.0), "C.x"] == motion["C.x"][1, -1]
    pytest.importorskip("xarray")
    assert motion.to_xarray().dims == ("member", "t", "column")


def test_fleets():
    joint = assur.LinkageJoint
    linkages = [
        [joint.ground(0, 0), joint.crank(0, 1, 0, 2 * numpy.pi), joint.ground(3, 0), joint.dyad(1, 2, b, 2.5, True),
         joint.point(1, 3, 0.5, 0.4)]
        for b in (2.5, 3, 9)
    ]
    linkages.append(linkages[1][:4] + [joint.ground(0.5, 5), joint.triad(1, 2.8, 0, 2.5), joint.triad(3, 2, 3.5, 4),
                                       joint.triad(4, 2, 1, 4)])
    fleet = assur.Fleet(linkages)
    times = numpy.linspace(0, 1, 101)
    paths, reached, status = fleet.run(times, threads=2, accuracy=1e-6)
    assert paths.shape == (4, 101, 2) and status[1] == "ok" and status[2] == "not_assembled" and reached[1] == 1
    assert numpy.isnan(paths[2]).all() and len(fleet) == 4 and repr(fleet) == "Fleet(4 linkages)"
    for linkage in linkages:
        for j in linkage:
            assert eval(repr(j), {"LinkageJoint": joint}) == j, "the text of a joint makes it again"
    assert repr(linkages[1][3]) == "LinkageJoint.dyad(1, 2, 3.0, 2.5, True)"
    assert joint.dyad(1, 2, 3, 2.5, True) != joint.dyad(1, 2, 3, 2.5, False) != None  # noqa: E711
    assert joint.ground(0, 1) == joint.ground(0, 1) != joint.point(0, 1, 0, 1)
    assert len({joint.ground(0, 1), joint.ground(0, 1), joint.crank(0, 1, 0, 1)}) == 2
    with pytest.raises(assur.InputError, match="linkage 0"):
        assur.Fleet([[joint.crank(0, 1, 0, 1)]])


def test_ctrl_c_keeps_the_linkages_that_are_done():
    fleet = assur.Fleet.random(1000000)
    threading.Timer(0.2, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(assur.Interrupted) as stopped:
        fleet.run(numpy.linspace(0, 1, 10), threads=2)
    paths, reached, status = stopped.value.result
    missing = numpy.array(status) == "interrupted"
    assert 0 < missing.sum() < 1000000 and numpy.isnan(reached[missing]).all() and numpy.isnan(paths[missing]).all()
    assert not numpy.isnan(paths[numpy.array(status) == "ok"]).any()


def test_a_bar_shows_linkages():
    told = []
    assur.Fleet.random(3000).run(numpy.linspace(0, 1, 10), progress=types.SimpleNamespace(update=told.append, total=0))
    assert sum(told) == 3000


def test_random_linkages():
    times = numpy.arange(101) / 100
    fleet = assur.Fleet.random(200, seed=5, first=1000, joints=(5, 8))
    paths, reached, status = fleet.run(times, threads=2)
    assert len(fleet) == 200 and 20 < status.count("ok") < 180
    linkages = [assur.random_linkage(5, k, (5, 8)) for k in range(1000, 1200)]
    again, _, _ = assur.Fleet(linkages).run(times)
    assert numpy.array_equal(paths, again, equal_nan=True) and {len(joints) for joints in linkages} == {5, 6, 7, 8}
    k = status.index("ok")
    crank, last = linkages[k][1], linkages[k][-1]
    assert crank.kind == "crank" and crank.first == 0 and crank.value[2] == 2 * numpy.pi and last.kind == "dyad"
    # The path ends at the right distances from both parents of its dyad.
    assert max(last.first, last.second) < len(linkages[k]) - 1 and isinstance(last.left, bool)
    motion = assur.run(assur.scene_of(linkages[k], 0, 1, 0.01))
    name = f"J{len(linkages[k]) - 1}"
    assert numpy.allclose(paths[k], numpy.stack([motion[name + ".x"], motion[name + ".y"]], axis=1), atol=1e-9)
    with pytest.raises(assur.InputError, match="fewest"):
        assur.random_linkage(5, 0, (2, 8))


def test_normal_places():
    t = numpy.linspace(0, 2 * numpy.pi, 100, endpoint=False)
    turn = numpy.array([[numpy.cos(0.3), numpy.sin(0.3)], [-numpy.sin(0.3), numpy.cos(0.3)]])
    curve = numpy.stack([2 * numpy.cos(t), numpy.sin(t)], axis=1) @ turn + [5, 6]
    frame = assur.frame_of(curve)
    assert frame.center == pytest.approx([5, 6]) and frame.angle == pytest.approx(0.3)
    assert frame.radius == pytest.approx(numpy.sqrt(2.5))
    normal = assur.normalize(curve)
    assert numpy.allclose(normal, (curve - [5, 6]) @ turn.T / frame.radius)


def test_distances():
    t = numpy.linspace(0, 2 * numpy.pi, 200, endpoint=False)
    ellipse = numpy.stack([2 * numpy.cos(t), numpy.sin(t)], axis=1)
    moved = ellipse @ [[0, 3], [-3, 0]] + [5, 6]
    assert assur.timed_distance(ellipse, ellipse + [3, 4]) == pytest.approx(5)
    assert assur.nearest_distance(ellipse, numpy.roll(ellipse, 7, axis=0)) == pytest.approx(0, abs=1e-12)
    assert assur.fitted_distance(ellipse, moved) == pytest.approx(0, abs=1e-12)
    assert assur.shape_distance(ellipse, moved) == pytest.approx(0, abs=1e-12)
    with pytest.raises(assur.InputError, match="points, 2"):
        assur.timed_distance([1, 2], ellipse)
