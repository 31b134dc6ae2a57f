"""Objects that change serve one call at a time; all others may be shared by threads."""

import collections
import inspect
import os
import subprocess
import sys
import threading

import numpy
import pytest

import assur

WAIT = 60  # s; only a test that fails waits so long


class Gate:
    """A function for a call in another thread: it stops the call until leave() is called."""

    def __init__(self):
        self.inside, self.go_on = threading.Event(), threading.Event()

    def __call__(self, *_):
        self.inside.set()
        assert self.go_on.wait(WAIT)

    def __enter__(self):
        assert self.inside.wait(WAIT)
        return self

    def __exit__(self, *_):
        self.go_on.set()


def background(call):
    """Starts a call in another thread; returns a function that waits for its result."""
    results = []

    def work():
        try:
            results.append(call())
        except Exception as error:
            results.append(error)

    thread = threading.Thread(target=work, daemon=True)
    thread.start()

    def result():
        thread.join(WAIT)
        assert not thread.is_alive(), "the call hangs"
        return results[0]

    return result


def calls_of(item, arguments, free):
    """All public methods and properties of an object as functions without arguments, except the free ones."""
    for name, part in inspect.getmembers(type(item)):
        if name.startswith("_") or name in free:
            continue
        if callable(part):
            yield name, lambda name=name: getattr(item, name)(*arguments.get(name, ()))
        else:
            yield name, lambda name=name: getattr(item, name)
    yield "__exit__", lambda: item.__exit__(None, None, None)


def refused(call):
    with pytest.raises(assur.InputError, match="in use") as error:
        call()
    return str(error.value)


def test_each_call_of_a_simulator_in_use_is_refused(mechanism):
    prepared = assur.prepare(mechanism, controlled=["motor"])
    simulator = assur.Simulator(prepared)
    state, motor, outputs = simulator.save(), simulator.driver("motor"), simulator.outputs
    arguments = {"set": (motor, 0.1), "driver": ("motor",), "index": ("C.x",), "output": (0,), "restore": (state,),
                 "stream": (print,), "name_of": (simulator.report.status,)}
    gate = Gate()
    rows = background(lambda: simulator.stream(gate))
    with gate:
        calls = dict(calls_of(simulator, arguments, free=()))
        assert {"run", "step", "close", "outputs", "report", "time", "columns", "jacobian"} <= set(calls)
        for name, call in calls.items():
            assert "simulator of 'four_bar'" in refused(call), name
        for call in (lambda: simulator.set("motor", 0.1), lambda: simulator.set(motor, 0.1, 2.0),
                     lambda: simulator.step(0.1), lambda: simulator.step(t=0.1), lambda: simulator.output("C.x"),
                     lambda: simulator.output(column=0), lambda: assur.certify(simulator)):
            refused(call)
        assert repr(simulator) == "Simulator(in use)" and numpy.isfinite(outputs).all()
    assert rows() == 201
    assert numpy.array_equal(simulator.run().values, assur.run(prepared).values)
    simulator.close()
    assert repr(simulator) == "Simulator(closed)"


def test_each_call_of_an_ensemble_in_use_is_refused(mechanism):
    values = {"coupler": numpy.linspace(2.9, 3.0, 5)}
    ensemble = assur.Ensemble(mechanism, values, threads=1)
    before = ensemble.run().values
    arguments = {"bind": (values,), "stream": (print,), "summarize": (["C.x"],)}
    gate = Gate()
    done = background(lambda: ensemble.stream(gate))
    with gate:
        calls = dict(calls_of(ensemble, arguments, free=("names",)))
        assert {"run", "close", "outcomes", "report", "prepared"} <= set(calls)
        for name, call in calls.items():
            assert "ensemble of 'four_bar'" in refused(call), name
        assert ensemble.names == ["coupler"] and len(ensemble) == 5 and repr(ensemble) == "Ensemble(in use)"
    assert done() is None
    assert numpy.array_equal(ensemble.run().values, before)


def test_laws_that_use_their_simulator(mechanism):
    for use in (lambda s: s.step(), lambda s: s.output(0), lambda s: s.run(), lambda s: s.reset(), lambda s: s.close(),
                lambda s: s.outputs, lambda s: assur.certify(s)):
        simulator, armed = None, False

        def law(t):
            if armed:
                use(simulator)
            return (t, 1.0, 0.0)

        simulator = assur.Simulator(mechanism.with_laws({"motor": assur.Law.function(law)}))
        assert simulator.step()
        at = simulator.time
        armed = True
        for call in (simulator.step, lambda: simulator.step(0.5), simulator.run, lambda: simulator.stream(print)):
            refused(call)
        armed = False
        simulator.reset()
        assert simulator.step() and simulator.time == at


def test_callbacks_that_use_what_calls_them(mechanism):
    simulator = assur.Simulator(assur.prepare(mechanism, controlled=["motor"]))
    ensemble = assur.Ensemble(mechanism, {"coupler": [2.9, 3.0, 3.1]}, threads=2)
    rows, members = simulator.run().values, ensemble.run().values

    class Bar:
        def __init__(self, use):
            self.use, self.total = use, 0

        def update(self, n):
            self.use()

    def with_rows(use):
        return lambda *_: use()

    for use in (simulator.step, simulator.run, simulator.reset, lambda: simulator.time, simulator.close):
        refused(lambda: simulator.stream(with_rows(use)))
        refused(lambda: simulator.run(progress=Bar(use)))
        assert numpy.array_equal(simulator.run().values, rows)
    for use in (ensemble.run, lambda: ensemble.outcomes, lambda: ensemble.bind({"coupler": [3.0]}), ensemble.close):
        refused(lambda: ensemble.stream(with_rows(use)))
        refused(lambda: ensemble.run(progress=Bar(use)))
        refused(lambda: ensemble.summarize(["C.x"], progress=Bar(use)))
        assert numpy.array_equal(ensemble.run().values, members)


def test_a_builder_that_grows_while_it_builds():
    """The law adds points to the builder that calls it: the scene has the parts that it had before."""
    builder = assur.SceneBuilder("grows", 2).point("A", (0, 0), fixed=True).point("B", (1, 0))

    def law(t):
        for _ in range(100):
            builder.point(f"P{law.count}", (law.count, 1), fixed=True)
            law.count += 1
        return (t, 1.0, 0.0)

    law.count = 0
    builder.drive_angle("motor", "A", "B", assur.Law.function(law)).output("B").time(0, 1, 0.1)
    for _ in range(3):
        count = law.count
        scene = builder.build()
        assert len(scene.points) == 2 + count
        assur.run(scene)
    assert law.count > 0


# A step that keeps the lock of the interpreter while threads of the plan wait for it never ends: in a process of its
# own, so that a test can end it.
THREADS_THAT_CALL_PYTHON = """
import assur
b = assur.SceneBuilder("rods", 2).point("A", (0, 0), fixed=True).point("B", (1, 0))
b.drive_angle("motor", "A", "B", assur.Law.function(lambda t: (t, 1.0, 0.0)))
for i in range(8):
    b.point(f"D{i}", (3, i), fixed=True).point(f"C{i}", (2, 1 + i)).distance(f"c{i}", "B", f"C{i}").output(f"C{i}")
    at = [f"C{i}.x", f"C{i}.y"]
    r2 = 2.0
    b.equations(f"r{i}", at, 1, residual=lambda x, i=i: [(x[0] - 3) ** 2 + (x[1] - i) ** 2 - r2],
                jacobian=lambda x, i=i: [2 * (x[0] - 3), 2 * (x[1] - i)],
                curvature=lambda x, v: [2 * v[0] ** 2 + 2 * v[1] ** 2])
prepared = assur.prepare(b.time(0, 0.2, 0.01).build(), strategy="groups/eigen 2x1", threads=2)
assert prepared.threads == 2
simulator = assur.Simulator(prepared)
for use in (simulator.step, lambda: simulator.step(0.05), simulator.examine, simulator.jacobian, simulator.save,
            simulator.constraint_jacobian, simulator.retreat, simulator.reset, simulator.step, simulator.run):
    use()
print("done", simulator.time)
"""


def test_threads_of_a_plan_call_python():
    package = os.path.dirname(os.path.dirname(assur.__file__))
    out = subprocess.run([sys.executable, "-c", THREADS_THAT_CALL_PYTHON], capture_output=True, text=True, timeout=WAIT,
                         env={**os.environ, "PYTHONPATH": package}, check=False)
    assert out.stdout == "done 0.2\n", out.stderr


def test_many_threads_at_random(mechanism):
    """Each call of a shared object has the right result or is refused, and nothing else happens."""
    prepared = assur.prepare(mechanism, threads=1)
    simulator = assur.Simulator(prepared)
    ensemble = assur.Ensemble(mechanism, {"coupler": numpy.linspace(2.9, 3.1, 20)}, threads=2)
    fleet = assur.Fleet.random(50, seed=3)
    law = assur.Law.function(lambda t: (6.0 * t, 6.0, 0.0))
    times = numpy.linspace(0, 1, 11)
    ways = {
        "run": lambda: simulator.run().values,
        "steps": lambda: (simulator.reset(), simulator.step(), simulator.step()) and None,
        "ensemble": lambda: ensemble.run(times).values,
        "summary": lambda: ensemble.summarize(["C.x"], times)["C.x"]["maximum"],
        "fleet": lambda: fleet.run(times)[0],
        "scene": lambda: assur.run(mechanism.with_values(rocker=2.4), times, threads=1).values,
        "law": lambda: assur.run(mechanism.with_laws({"motor": law}), times, threads=1).values,
        "prepared": lambda: assur.Simulator(prepared).run(times).values,
    }
    right = {name: way() for name, way in ways.items()}
    seen = collections.Counter()
    wrong = []

    def work(seed):
        draw = numpy.random.default_rng(seed)
        for _ in range(60):
            name = draw.choice(list(ways))
            try:
                result = ways[name]()
            except assur.InputError as error:
                if name not in ("run", "steps", "ensemble", "summary") or "in use" not in str(error):
                    wrong.append((name, error))
                seen["refused"] += 1
                continue
            except Exception as error:
                wrong.append((name, error))
                continue
            seen[name] += 1
            if right[name] is not None and not numpy.array_equal(result, right[name], equal_nan=True):
                wrong.append((name, result))

    threads = [threading.Thread(target=work, args=(seed,), daemon=True) for seed in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(WAIT)
        assert not thread.is_alive(), "a call hangs"
    assert not wrong and sum(seen.values()) == 240 and min(seen[name] for name in ways) > 0, seen
    assert numpy.array_equal(simulator.run().values, right["run"])


def test_outputs_stay_valid():
    """Other redundant equations are chosen on the way: the array shows each new posture nevertheless."""
    simulator = assur.Simulator(assur.prepare(assur.sample("bennett"), threads=1))
    row = simulator.outputs
    address = row.__array_interface__["data"][0]
    for _ in range(200):
        if not simulator.step():
            break
        assert simulator.outputs.__array_interface__["data"][0] == address
        assert numpy.array_equal(row, simulator.outputs)
    simulator.reset()
    assert numpy.array_equal(row, simulator.outputs)
