import collections
import gc
import os
import resource
import signal
import threading
import time
import types

import numpy
import pytest

import assur


def test_prepare_and_plans(tmp_path, mechanism):
    prepared = assur.prepare(mechanism, strategy="groups/eigen", threads=1, controlled=["motor"])
    assert prepared.strategies[0].startswith("groups/eigen") and len(prepared.reasons) == len(prepared.strategies)
    assert prepared.groups and prepared.threads == 1 and prepared.lanes >= 1 and prepared.controlled == ["motor"]
    assert prepared.name == prepared.scene.name == "four_bar" and prepared.time == mechanism.time
    assert "groups/eigen" in repr(prepared)
    prepared.save(tmp_path / "plan")
    loaded = assur.load_plan(tmp_path / "plan")
    assert loaded.scene is None
    assert numpy.array_equal(assur.Simulator(loaded).run().values, assur.Simulator(prepared).run().values)
    redundant = assur.prepare(assur.sample("bricard_joints"), threads=1)
    runs = [assur.Simulator(p).run() for p in (redundant, redundant.rehearse())]
    assert numpy.array_equal(runs[0].values, runs[1].values)
    with pytest.raises(assur.InputError, match="backend"):
        assur.prepare(mechanism, strategy="groups/abacus")
    with pytest.raises(assur.InputError, match="throughput"):
        assur.prepare(mechanism, mode="fast")
    with pytest.raises(assur.InputError, match="options"):
        assur.run(prepared, strategy="groups/eigen")
    assert "eigen" in assur.backends() and assur.this_machine().threads >= 1
    machine = assur.this_machine()
    assert "thread" in repr(machine) and machine.cores and machine.source and isinstance(machine.model, str)
    assert machine.instructions and assur.__version__.count(".") == 2


def test_statuses_are_compared(mechanism):
    status = assur.run(mechanism).status
    assert status == "ok" and status != "fold" and status == assur.run(mechanism).status
    assert status != None and not status == 5 and status in [None, "ok"] and status not in [None, 0]  # noqa: E711
    jammed = assur.run(mechanism.with_values(rocker=1.4, coupler=2.0)).status
    assert jammed != status and jammed == jammed and jammed == "fold"


def test_wrong_arguments_of_a_simulator():
    for wrong in ("four_bar", None, 3):
        with pytest.raises(TypeError, match="needs a Prepared or a Scene"):
            assur.Simulator(wrong)


def test_numerical_errors():
    apart = assur.SceneBuilder("apart", 2).point("A", (0, 0), fixed=True).point("D", (9, 0), fixed=True)
    apart.point("B", (1, 0)).point("C", (2, 2)).distance("crank", "A", "B", 1).distance("coupler", "B", "C", 1)
    apart.distance("rocker", "D", "C", 1).drive_angle("motor", "A", "B", [0, 1]).time(0, 1, 0.1)
    with pytest.raises(assur.NumericalError) as refusal:
        assur.prepare(apart.build())
    assert isinstance(refusal.value, ArithmeticError)


def test_arrays_show_the_memory_of_the_motion(mechanism):
    motion = assur.run(mechanism)
    assert len(motion) == 201 and motion.values.shape == (201, len(motion.columns)) and motion.t.shape == (201,)
    x = motion["C.x"]
    assert numpy.shares_memory(x, motion.values) and numpy.array_equal(x, motion.values[:, motion.columns.index("C.x")])
    assert "C.x" in motion and "C.q" not in motion and motion.keys() == motion.columns == list(motion)
    assert set(dict(motion)) == set(motion.columns)
    with pytest.raises(ValueError):
        x[0] = 1
    copy = x.copy()
    del motion
    gc.collect()
    assert numpy.array_equal(x, copy)
    with pytest.raises(assur.InputError, match="C.x"):
        assur.run(mechanism)["C.q"]


def test_times_and_reports(tmp_path, mechanism):
    simulator = assur.Simulator(assur.prepare(mechanism))
    motion = simulator.run([0, 0.1, 0.7])
    assert list(motion.t) == [0, 0.1, 0.7] and simulator.time == 0.7
    report = simulator.report
    assert report.status.ok and report.status == "ok" and report.reached == 0.7 and report.events == []
    assert report.counters["steps"] > 0 and report.residuals["position"] < 1e-12
    assert report.estimated_errors["position"] < 1e-9 and report.fallbacks == [] and report.dropped_events == 0
    assert repr(report).startswith("Report(Status('ok')") and "3 rows" in repr(motion) and "four_bar" in repr(simulator)
    motion.write_csv(str(tmp_path / "motion.csv"))
    assert numpy.genfromtxt(tmp_path / "motion.csv", delimiter=",", names=True)["Cx"][-1] == motion["C.x"][-1]
    with pytest.raises(assur.InputError):
        simulator.run([1, 0])


def test_calls_of_a_control_loop_take_all_arguments(mechanism):
    """Handles and floats take a short way; the numbers are the same as by names and keywords."""
    prepared = assur.prepare(mechanism, controlled=["motor"])
    a, b, c = (assur.Simulator(prepared) for _ in range(3))
    motor, x = a.driver("motor"), a.index("C.x")
    for k in range(1, 6):
        a.set(motor, 0.01 * k, 2.0, 0.5)
        b.set("motor", 0.01 * k, 2, acceleration=0.5)
        c.set(driver=motor, value=numpy.float64(0.01 * k), rate=2.0, acceleration=0.5)
        assert bool(a.step()) and bool(b.step()) and bool(c.step(c.time + 0.005))
        assert a.output(x) == b.output("C.x") == c.output(column=x) == c.output(numpy.int64(x))
    a.set(motor, 1)
    assert a.step(t=1.0) is a.step() and a.time == 1.005
    for wrong in (lambda: a.set(motor), lambda: a.set(motor, "1"), lambda: a.set(motor, 1, 2, 3, 4), lambda: a.output(),
                  lambda: a.step(1, 2), lambda: a.set(motor, 1, speed=2), lambda: a.output(1.5),
                  lambda: assur.Simulator.step(prepared), lambda: assur.Simulator.set(motor, 1, 2)):
        with pytest.raises(TypeError):
            wrong()
    for wrong in (len(a.columns), -1, 2**70):
        with pytest.raises((IndexError, TypeError)):
            a.output(wrong)
    a.set(motor, float("nan"))
    status = a.step()
    assert not status and status.code == "not_finite"

    class Own(assur.Simulator):
        def __init__(self, *options):
            if options:
                super().__init__(*options)

    with pytest.raises(TypeError):
        bool(assur.Status.__new__(assur.Status))
    assert Own(prepared).step() and "__init__" in str(pytest.raises(TypeError, lambda: Own().step()).value)


def test_laws_of_python_fail_in_steps(mechanism):
    def law(t):
        if t > 0.1:
            raise RuntimeError("no more data")
        return (t, 1.0, 0.0)

    simulator = assur.Simulator(mechanism.with_laws({"motor": assur.Law.function(law)}))
    with pytest.raises(RuntimeError, match="no more data"):
        while simulator.step():
            pass
    assert 0 < simulator.time <= 0.1


def test_files_of_a_motion(tmp_path, mechanism):
    motion = assur.run(mechanism)
    motion.write_npy(tmp_path / "motion.npy", every=7)
    stored = numpy.load(tmp_path / "motion.npy")
    assert stored.dtype.names == ("t", *motion.columns)
    assert numpy.array_equal(stored["t"], motion.t[::7]) and numpy.array_equal(stored["C.vy"], motion["C.vy"][::7])
    with pytest.raises(assur.InputError, match="every"):
        motion.write_npy(tmp_path / "motion.npy", every=0)
    with pytest.raises(assur.MachineError, match="nowhere"):
        motion.write_csv(tmp_path / "nowhere" / "motion.csv")


def test_a_closed_simulator(mechanism):
    prepared = assur.prepare(mechanism, controlled=["motor"])
    with assur.Simulator(prepared) as simulator:
        motor = simulator.driver("motor")
        simulator.set(motor, 0.1)
        assert simulator.step()
        outputs = simulator.outputs
        row = outputs.copy()
    gc.collect()
    assert repr(simulator) == "Simulator(closed)" and numpy.array_equal(outputs, row)
    for use in (simulator.step, simulator.run, simulator.reset, simulator.retreat, simulator.save,
                lambda: simulator.set(motor, 0.2), lambda: simulator.set("motor", 0.2), lambda: simulator.output(0),
                lambda: simulator.outputs, lambda: simulator.time, lambda: simulator.step(0.5),
                lambda: assur.certify(simulator)):
        with pytest.raises(assur.InputError, match="closed"):
            use()
    simulator.close()
    with pytest.raises(RuntimeError, match="mine"):
        with assur.Simulator(prepared) as simulator:
            raise RuntimeError("mine")
    assert repr(simulator) == "Simulator(closed)"


def test_a_limit_ends_the_motion(mechanism):
    simulator = assur.Simulator(mechanism.with_values(rocker=1.4, coupler=2.0))
    motion = simulator.run()
    status = simulator.report.status
    assert status.code == "fold" and not status.ok and not status and not status.arrived
    assert len(motion) < 201 and "fold" in repr(status) and status.figure >= 0 and status.index >= -1
    event = simulator.report.events[-1]
    assert event.kind == "fold" and event.time <= event.until and event.group in repr(event)
    assert isinstance(event.detail, str) and isinstance(event.unit, str) and event.figure == event.figure


def test_a_control_loop(mechanism):
    prepared = assur.prepare(mechanism, controlled=["motor"])
    by_name, by_handle = assur.Simulator(prepared), assur.Simulator(prepared)
    motor, x = by_handle.driver("motor"), by_handle.index("C.x")
    outputs = by_handle.outputs
    for k in range(1, 20):
        by_name.set("motor", 0.03 * k, rate=3.0)
        by_handle.set(motor, 0.03 * k, 3.0)
        assert by_name.step() and by_handle.step().ok
        assert by_name.output("C.x") == by_handle.output(x) == outputs[x]
    assert by_handle.columns[0] == "C.x"
    state = by_handle.save()
    assert state.time == by_handle.time
    by_handle.set(motor, 0.6)
    by_handle.step()
    after = by_handle.output(x)
    by_handle.restore(state)
    assert by_handle.time == state.time and by_handle.output(x) != after
    by_handle.reset()
    assert by_handle.time == 0 and by_handle.prepared.name == "four_bar"
    assert by_handle.step(0.5).arrived and by_handle.time == 0.5
    with pytest.raises(assur.InputError, match="motor"):
        by_name.driver("moter")
    with pytest.raises(assur.InputError, match="handle"):
        assur.Simulator(assur.prepare(mechanism)).set(motor, 1)
    with pytest.raises(IndexError):
        by_name.output(99)


def test_long_calls_let_other_threads_go_on():
    """The bar is filled without a line of Python: with the lock held, this thread would see it only when it is full."""
    simulator = assur.Simulator(assur.prepare(assur.scene("stewart").with_outputs("handle1"), threads=1))
    rows = collections.deque()
    bar = types.SimpleNamespace(update=rows.append, total=0)
    times = numpy.linspace(0, 10, 2000000)
    thread = threading.Thread(target=simulator.run, args=(times,), kwargs={"progress": bar})
    thread.start()
    while not rows:
        time.sleep(0.01)
    seen = sum(rows)
    thread.join()
    assert 0 < seen < sum(rows) == 2000000


def test_ctrl_c_keeps_what_is_done():
    # One output, so that the rows need little memory.
    simulator = assur.Simulator(assur.prepare(assur.scene("stewart").with_outputs("handle1"), threads=1))
    threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    with pytest.raises(KeyboardInterrupt) as stopped:
        simulator.run(numpy.linspace(0, 10, 5000000))
    motion = stopped.value.result
    assert isinstance(stopped.value, assur.Interrupted) and 0 < len(motion) < 5000000
    assert simulator.report.status.code == "interrupted" and not numpy.isnan(motion.values).any()


class Bar:
    """The protocol of tqdm."""

    def __init__(self, total=None):
        self.total, self.done, self.closed = total, 0, False
        Bar.latest = self

    def update(self, n):
        self.done += n

    def close(self):
        self.closed = True


def test_progress(mechanism):
    simulator = assur.Simulator(assur.prepare(mechanism))
    simulator.run(progress=Bar)
    assert Bar.latest.done == Bar.latest.total == 201 and Bar.latest.closed
    own = Bar()
    simulator.run(progress=own)
    assert own.done == own.total == 201 and not own.closed

    class Bad(Bar):
        def update(self, n):
            raise RuntimeError("no bar")

    with pytest.raises(RuntimeError, match="no bar"):
        simulator.run(progress=Bad)
    tqdm = pytest.importorskip("tqdm")
    simulator.run(progress=tqdm.tqdm)


def test_memory_stays_flat(mechanism):
    prepared = assur.prepare(mechanism)
    for _ in range(1000):
        assur.Simulator(prepared).run([0, 0.1])
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(10000):
        assur.Simulator(prepared).run([0, 0.1])
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 2000  # kB


def test_other_packages(mechanism):
    motion = assur.run(mechanism)
    pandas = pytest.importorskip("pandas")
    frame = motion.to_pandas()
    assert isinstance(frame, pandas.DataFrame) and frame["C.x"].iloc[-1] == motion["C.x"][-1]
    assert frame.index.name == "t" and assur.to_pandas(motion).equals(frame)
    pytest.importorskip("xarray")
    array = motion.to_xarray()
    assert array.sel(column="C.x")[-1] == motion["C.x"][-1] and numpy.shares_memory(array.values, motion.values)
    assert assur.to_xarray(motion).dims == ("t", "column")


def test_a_motion_that_ends_early_tells_why():
    b = assur.SceneBuilder("jams", 2).point("A", (0, 0), fixed=True).point("D", (1, 0), fixed=True)
    b.point("B", (0.5, 0)).point("C", (0.9, 0.6)).distance("k", "B", "C").distance("r", "D", "C")
    motion = assur.run(b.drive_angle("m", "A", "B", [0, 3]).output("C").time(0, 2, 0.01).build())
    assert motion.status.code == "fold" and motion.report.events and len(motion) < 201
    assert "fold" in repr(motion)
    done = assur.run("four_bar:1")
    assert done.status.ok and done.report.reached == done.t[-1] and "status" not in repr(done)
