import json
import math
import pathlib

import numpy
import pytest

import assur
from conftest import four_bar


def test_samples_and_parameters():
    scene = assur.scene("stewart:legs=8", omega=2)
    assert "omega" in scene.parameters and scene.dimension == 3
    assert repr(scene).startswith("Scene('stewart") and "1 body," in repr(scene) and "bodys" not in repr(scene)
    assert assur.sample("four_bar:3").dimension == 2
    with pytest.raises(assur.InputError) as refusal:
        assur.scene("stewart", omeja=2)
    assert "omeja" in str(refusal.value) and isinstance(refusal.value, ValueError)
    assert refusal.value.diagnostics[0][1]


def test_files_and_text(tmp_path, mechanism):
    file = tmp_path / "four_bar.json"
    mechanism.write(file)
    assert assur.read_scene(file).to_json() == mechanism.to_json()
    assert assur.scene(file).outputs == ["C", "rocker_angle"]
    as_dict = json.loads(mechanism.to_json())
    assert assur.parse_scene(as_dict).to_json() == mechanism.to_json()
    as_dict["constraints"]["crank"]["distance"] = ["A", "E"]
    with pytest.raises(assur.InputError) as refusal:
        assur.parse_scene(as_dict)
    where, what = refusal.value.diagnostics[0]
    assert where.startswith("/constraints/crank") and "E" in what
    with pytest.raises(assur.MachineError) as missing:
        assur.read_scene(tmp_path / "none.json")
    assert "none.json" in str(missing.value) and isinstance(missing.value, OSError)


def test_what_a_scene_tells(mechanism):
    assert mechanism.name == "four_bar" and mechanism.points == ["A", "D", "B", "C"]
    assert mechanism.constraints == ["crank", "coupler", "rocker"] and mechanism.drivers == ["motor"]
    assert mechanism.measures == ["rocker_angle"] and mechanism.bodies == [] and mechanism.joints == []
    assert mechanism.time == (0, 1, 0.005) and mechanism.warnings == []


def test_other_outputs_times_values_and_laws(mechanism):
    assert mechanism.with_outputs("C.x", "C.y").outputs == ["C.x", "C.y"]
    assert mechanism.with_time(0, 2, 0.5).time == (0, 2, 0.5)
    longer = mechanism.with_values(coupler=3.1)
    assert longer.to_json() == mechanism.with_values({"coupler": 3.1}).to_json() != mechanism.to_json()
    slow = mechanism.with_laws({"motor": [0, 1]})
    assert assur.run(slow)["rocker_angle"][-1] != assur.run(mechanism)["rocker_angle"][-1]
    with pytest.raises(assur.InputError, match="motr"):
        mechanism.with_laws({"motr": 0})


def test_laws():
    assert assur.Law(3)(1) == (3, 0, 0)
    assert assur.Law([1, 2, 3])(2) == (17, 14, 6)
    assert assur.Law.polynomial([1, 2, 3]) == assur.Law([1, 2, 3]) != assur.Law()
    value, rate, acceleration = assur.Law.harmonic(2, 0.5, phase=0.1, offset=1)(0.3)
    angle = math.pi * 0.3 + 0.1
    assert numpy.allclose([value, rate, acceleration],
                          [1 + 2 * math.sin(angle), 2 * math.pi * math.cos(angle), -2 * math.pi**2 * math.sin(angle)])
    t = numpy.linspace(0, 1, 50)
    assert abs(assur.Law.table(t, numpy.sin(t))(0.5)[1] - math.cos(0.5)) < 1e-5
    assert math.isnan(assur.Law.table(t, numpy.sin(t))(2)[0])
    turn = numpy.sin(2 * math.pi * t)
    turn[-1] = turn[0]
    assert abs(assur.Law.table(t, turn, periodic=True)(2.25)[0] - 1) < 1e-5
    assert assur.Law.table([0, 1, 2, 3], [0, 0, 1, 1])(0.5)[0] < -0.01
    assert assur.Law.table([0, 1, 2, 3], [0, 0, 1, 1], monotone=True)(0.5)[0] == 0
    assert (assur.Law(1) + assur.Law([0, 1]))(2) == (3, 1, 0)
    assert sum([assur.Law([0, 1]), 1, assur.Law(2)])(2) == (1 + assur.Law([2, 1]))(2) == (5, 1, 0)
    assert assur.Law(1) == 1.0 and assur.Law(1) != None and not assur.Law(1) == "one"  # noqa: E711
    assert "2 parts" in repr(assur.Law(1) + assur.Law([0, 1]))
    with pytest.raises(assur.InputError):
        assur.Law.table([0, 0], [1, 2])


def test_laws_as_functions(mechanism):
    def law(t):
        return 6 * t * t, 12 * t, 12.0

    slow = assur.run(mechanism.with_laws({"motor": assur.Law.function(law)}))
    fast = assur.run(mechanism.with_laws({"motor": [0, 0, 6]}))
    assert numpy.array_equal(slow.values, fast.values)

    def wrong(t):
        return 6 * t, 7.0, 0.0

    with pytest.raises(assur.InputError, match="motor"):
        assur.run(mechanism.with_laws({"motor": assur.Law.function(wrong)}))

    def fails(t):
        raise RuntimeError("no law")

    with pytest.raises(RuntimeError, match="no law"):
        assur.run(mechanism.with_laws({"motor": assur.Law.function(fails)}))


def test_every_part_of_the_builder():
    b = assur.SceneBuilder("arm", 3)
    assert repr(b) == "SceneBuilder()"
    b.body("arm", points={"tip": (1, 0, 0)}, in_ground=True).body("hand", points={"nail": (1.5, 0, 0)}, in_ground=True)
    b.revolute("hip", "ground", "arm", (0, 0, 0), (0, 0, 1)).revolute("wrist", "arm", "hand", (1, 0, 0), (0, 1, 0))
    b.drive_coordinate("turn", "hip.angle", [0, 1]).drive_coordinate("bend", "wrist.angle", 0.1)
    b.measure_coordinate("bent", "wrist.angle").limit("bent", -1, 1).output("nail", "bent").time(0, 1, 0.1)
    motion = assur.run(b.build())
    assert math.isclose(motion["nail.x"][-1], (1 + 0.5 * math.cos(0.1)) * math.cos(1), rel_tol=1e-12)

    # The other joints, each closing a chain that can be computed by hand.
    b = assur.SceneBuilder("slide", 3)
    b.body("carriage", points={"P": (1, 0, 0)}, in_ground=True).prismatic("rail", "ground", "carriage", (1, 0, 0))
    b.body("drum", points={"Q": (1, 1, 0)}, in_ground=True)
    b.cylindrical("shaft", "carriage", "drum", (1, 0, 0), (1, 0, 0))
    b.body("lid", points={"R": (1, 1, 0)}, in_ground=True).fixed("bolt", "drum", "lid")
    b.drive_coordinate("move", "rail.displacement", [0, 2]).drive_coordinate("turn", "shaft.angle", [0, 1])
    b.drive_coordinate("push", "shaft.displacement", [0, 3]).output("R").time(0, 1, 0.25)
    motion = assur.run(b.build())
    assert numpy.allclose([motion["R.x"][-1], motion["R.y"][-1], motion["R.z"][-1]], [6, math.cos(1), math.sin(1)])

    b = assur.SceneBuilder("parts", 2)
    b.point("O", (0, 0), fixed=True).vector("e", (1, 0), fixed=True).point("P", (1, 1)).point("Q", (2, 1))
    b.on_line("rail", "P", "O", "e").coordinate("level", "Q.y", 1).distance("rod", "P", "Q", 2)
    b.drive_distance("piston", "O", "P", [1, 0.5]).measure_distance("far", "O", "Q")
    b.measure_angle_between("slope", ("P", "Q"), "e").measure_sum("twice", {"far": 2}, 1).time(0, 1, 0.5)
    b.output("all")
    motion = assur.run(b.build())
    far = math.hypot(1.5 + math.sqrt(3), 1)
    assert math.isclose(motion["far"][-1], far) and math.isclose(motion["twice"][-1], 1 + 2 * far)
    assert math.isclose(abs(motion["slope"][-1]), math.pi / 6)

    b = assur.SceneBuilder("wrong", 2)
    b.point("A", (0, 0)).equal_distance("equal", "A", "B", "A", "C").dot("dot", ("A", "B"), "v", 0)
    b.parallel("parallel", "u", "v").linear("sum", {"A": 1, "B": -1}).on_plane("plane", "A", "B", "u", "v")
    b.gear("gear", "i.angle", "j.angle", 2).spherical("ball", "ground", "c", (0, 0)).group("g", ["A"])
    b.universal("cross", "ground", "c", (0, 0), (1, 0), (0, 1)).planar("flat", "ground", "c", "n")
    b.drive_relative_angle("turn", "u", "v", 0).drive_pose("pose", "c", [0, 0], [0])
    with pytest.raises(assur.InputError) as refusal:
        b.build()
    assert len(refusal.value.diagnostics) > 10
    with pytest.raises(assur.InputError, match="2 or 3 numbers"):
        assur.SceneBuilder("x", 2).point("A", (0,))


def test_equations_in_python():
    """A point on a parabola, driven along x."""

    def build(residual=lambda x: [x[1] - x[0] ** 2], jacobian=lambda x: [[-2 * x[0], 1]]):
        b = assur.SceneBuilder("parabola", 2).point("P", (1, 1))
        b.equations("curve", ["P.x", "P.y"], 1, residual=residual, jacobian=jacobian,
                    curvature=lambda x, rates: [-2 * rates[0] ** 2])
        return b.drive_coordinate("push", "P.x", [1, 0.5]).output("P").time(0, 1, 0.1).build()

    motion = assur.run(build())
    x = 1 + 0.5 * motion.t
    assert numpy.allclose(motion["P.y"], x**2) and numpy.allclose(motion["P.vy"], x)
    assert numpy.allclose(motion["P.ay"], 0.5)
    with pytest.raises(assur.InputError, match="curve"):
        assur.run(build(jacobian=lambda x: [[-3 * x[0], 1]]))
    with pytest.raises(assur.InputError, match="residual must return 1 number, not 2"):
        assur.run(build(residual=lambda x: [0, 0]))
    with pytest.raises(ZeroDivisionError):
        assur.run(build(residual=lambda x: 1 / 0))


def test_four_bar_closes(mechanism):
    motion = assur.run(mechanism)
    b = numpy.stack([numpy.cos(2 * numpy.pi * motion.t), numpy.sin(2 * numpy.pi * motion.t)])
    c = numpy.stack([motion["C.x"], motion["C.y"]])
    assert numpy.allclose(numpy.hypot(*(c - b)), 3) and numpy.allclose(numpy.hypot(c[0] - 3, c[1]), 2.5)
    assert four_bar().to_json() == mechanism.to_json()


def test_models_of_mujoco():
    file = pathlib.Path(__file__).parents[2] / "scenes/mjcf/five_bar.xml"
    model = assur.import_model(file, key="low", drive={"left": "0,0.3"})
    assert model.scene.name == model.name and model.loops >= 1 and "joint" in repr(model)
    name, start, driven = model.coordinates["left"]
    assert driven and model.scene.drivers == list(model.drivers) and name in {c for c, _ in model.drivers.values()}
    motion = assur.run(model.scene.with_outputs(name).with_time(0, 1, 0.1))
    assert motion[name][-1] == pytest.approx(0.3) and start != assur.import_model(file).coordinates["left"][1]
    assert all(count > 0 for count in model.left_out.values()) and isinstance(model.notes, list)
    with pytest.raises(assur.InputError, match="high"):
        assur.import_model(file, key="high")
