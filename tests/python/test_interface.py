"""Every public name has a docstring, and is used by a test; examples in the pages run."""

import ast
import importlib.util
import inspect
import pathlib
import re

import pytest

import assur

ROOT = pathlib.Path(__file__).parents[2]
TESTS = "".join(file.read_text() for file in pathlib.Path(__file__).parent.glob("*.py"))


def public():
    for name in assur.__all__:
        if name.startswith("__"):
            continue
        item = getattr(assur, name)
        yield name, item
        if inspect.isclass(item):
            for part in vars(item):
                if not part.startswith("_"):
                    yield name + "." + part, inspect.getattr_static(item, part)


@pytest.mark.parametrize("name, item", public(), ids=lambda x: x if isinstance(x, str) else "")
def test_documented_and_used(name, item):
    doc = inspect.getdoc(item) or ""
    text = re.sub(r"\A\w+\(.*$|^Overloaded function\.$|^\d+\. .*$", "", doc, flags=re.M).strip()
    assert text, name + " has no docstring"
    if not inspect.isclass(item):
        assert re.search(r"\b" + name.split(".")[-1] + r"\b", TESTS), name + " is not used by a test"


def stubs():
    """Pairs of the name of a public function or property, and its stub."""
    tree = ast.parse((ROOT / "python/assur/_core.pyi").read_text())
    for node in tree.body:
        if isinstance(node, ast.FunctionDef):
            yield node.name, node
        for part in node.body if isinstance(node, ast.ClassDef) else ():
            if isinstance(part, ast.FunctionDef) and (part.name == "__init__" or not part.name.startswith("_")):
                yield node.name + "." + part.name, part


def annotations(stub):
    arguments = [*stub.args.args, *stub.args.kwonlyargs]
    parts = [a.annotation for a in arguments] + [stub.args.kwarg and stub.args.kwarg.annotation, stub.returns]
    return " ".join(ast.unparse(part) for part in parts if part)


def docstring(name):
    item = assur
    for part in name.split("."):
        item = getattr(item, part)
    return inspect.getdoc(item) or ""


NUMBERS = re.compile(r"\b(float|Array|ArrayLike|Place|Anchor|AnyLaw|Parameters|NDArray\[Any\])\b")
ARRAYS = re.compile(r"\b(Array|ArrayLike|NDArray)\b")
UNIT = re.compile(r"(?<![\w'])(m|rad|s|Hz|rad/s|SI|SI units)(?![\w'])|\bunits?\b|\brelative\b")
SHAPE = re.compile(r"\barrays?\s+of\s+\((\w+,|\w+(,\s\w+)+)\)")


@pytest.mark.parametrize("name, stub", stubs(), ids=lambda x: x if isinstance(x, str) else "")
def test_docstrings_name_units_and_shapes(name, stub):
    """Whatever takes or gives numbers names their unit or says that there is none; whatever has arrays, their shape."""
    doc = re.sub(r"^.*->.*$", "", docstring(name), flags=re.M)
    if NUMBERS.search(annotations(stub)):
        assert UNIT.search(doc), f"{name} names no unit: {doc}"
    if ARRAYS.search(annotations(stub)):
        assert SHAPE.search(doc), f"{name} names no shape: {doc}"


def test_docstrings_of_the_package_name_units():
    for name in ("run", "plot", "to_pandas", "to_xarray"):
        assert UNIT.search(docstring(name)), name


def pages():
    every = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]
    return [page for page in every if "```python\n" in page.read_text()]


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.name)
def test_examples_run(page, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in re.findall(r"^```python\n(.*?)^```", page.read_text(), flags=re.M | re.S):
        if ".plot(" in block and not importlib.util.find_spec("matplotlib"):
            continue
        exec(compile(block, page.name, "exec"), names)


def test_stubs_name_everything():
    """Each public name of the module is in its stub, and the other way around."""
    import assur._core

    tree = ast.parse((ROOT / "python/assur/_core.pyi").read_text())
    stubs = {node.name: node for node in tree.body if isinstance(node, (ast.ClassDef, ast.FunctionDef))}
    module = {name for name in vars(assur._core) if not name.startswith("_")}
    assert set(stubs) == module
    for name in module:
        item = getattr(assur._core, name)
        if inspect.isclass(item):
            parts = {part.name for part in stubs[name].body if isinstance(part, ast.FunctionDef)}
            assert {p for p in parts if not p.startswith("_")} == {p for p in vars(item) if not p.startswith("_")}, name


def test_mypy_accepts_a_typical_program(tmp_path, monkeypatch):
    api = pytest.importorskip("mypy.api")
    monkeypatch.setenv("MYPYPATH", str(pathlib.Path(assur.__file__).parents[1]))
    program = tmp_path / "program.py"
    program.write_text("""
import numpy
from numpy.typing import NDArray

import assur

scene = assur.scene("stewart", omega=2).with_outputs("all")
motion = assur.Simulator(assur.prepare(scene, threads=1)).run(numpy.linspace(0, 1, 11))
x: float = float(motion["handle1"].max()) + motion.values[0, 0]
ensemble = assur.Ensemble(scene, {"omega": [1, 2]})
rows: NDArray[numpy.int64] = ensemble.run().rows
joint = assur.LinkageJoint.ground(0, 0)
paths, reached, status = assur.Fleet([[joint]]).run([0, 1])
reveal = status[0].upper()
with assur.Simulator(scene) as simulator, ensemble:
    y: float = simulator.output("handle1")
    ensemble.stream(lambda member, t, values: print(member, t[0], values[0, 0]), columns=["handle1"], block=5)
    assert not assur.certify(simulator).why_not and assur.certify(motion)[0].radius < 1
table = assur.sweep(scene, {"omega": (1, 2)}, 10, reduce=["range"])
best: int = int(table["handle1.range"].argmax())
modes: list[float] = assur.assembly_modes(scene)[0].conditions
motion.plot(["handle1"])
page: str = scene.page()
""")
    wrong = tmp_path / "wrong.py"
    wrong.write_text("import assur\nassur.prepare(3)\n")
    for file, expected in ((program, 0), (wrong, 1)):
        options = ["--strict", "--follow-imports=silent", "--cache-dir", str(tmp_path / "cache")]
        out, err, code = api.run([*options, str(file)])
        assert code == expected, out + err
