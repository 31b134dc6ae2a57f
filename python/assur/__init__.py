"""Kinematic analysis of multibody systems by group equations, tuned to the machine.

>>> import assur
>>> motion = assur.run("stewart")
>>> motion["handle1"]

All quantities are in SI units, angles in rad.
"""

from ._core import (
    AssemblyModes,
    Candidate,
    Certificate,
    ConstraintJacobian,
    CurveFrame,
    DriverHandle,
    Ensemble,
    EnsembleTrajectory,
    Event,
    Fleet,
    ImportedModel,
    Law,
    LinkageJoint,
    Machine,
    MotionRange,
    Outcome,
    OutputJacobian,
    PerformanceModel,
    Prepared,
    RangeEnd,
    Report,
    Scene,
    SceneBuilder,
    Simulator,
    SimulatorState,
    Status,
    Trajectory,
    __version__,
    assembly_modes,
    backends,
    certify,
    fitted_distance,
    forward_error,
    frame_of,
    import_model,
    load_plan,
    machine_model,
    motion_range,
    nearest_distance,
    normalize,
    parse_scene,
    prepare,
    random_linkage,
    read_scene,
    sample,
    scene,
    scene_of,
    shape_distance,
    sweep,
    this_machine,
    timed_distance,
    worst_of,
)
from ._errors import Error, InputError, Interrupted, MachineError, NumericalError
from ._pictures import html, plot
from ._tables import to_pandas, to_xarray

__all__ = [
    "AssemblyModes",
    "Candidate",
    "Certificate",
    "ConstraintJacobian",
    "CurveFrame",
    "DriverHandle",
    "Ensemble",
    "EnsembleTrajectory",
    "Error",
    "Event",
    "Fleet",
    "ImportedModel",
    "InputError",
    "Interrupted",
    "Law",
    "LinkageJoint",
    "Machine",
    "MachineError",
    "MotionRange",
    "NumericalError",
    "Outcome",
    "OutputJacobian",
    "PerformanceModel",
    "Prepared",
    "RangeEnd",
    "Report",
    "Scene",
    "SceneBuilder",
    "Simulator",
    "SimulatorState",
    "Status",
    "Trajectory",
    "__version__",
    "assembly_modes",
    "backends",
    "certify",
    "fitted_distance",
    "forward_error",
    "frame_of",
    "import_model",
    "load_plan",
    "machine_model",
    "motion_range",
    "nearest_distance",
    "normalize",
    "parse_scene",
    "plot",
    "prepare",
    "random_linkage",
    "read_scene",
    "run",
    "sample",
    "scene",
    "scene_of",
    "shape_distance",
    "sweep",
    "this_machine",
    "timed_distance",
    "to_pandas",
    "to_xarray",
    "worst_of",
]

Trajectory.to_pandas = EnsembleTrajectory.to_pandas = to_pandas
Trajectory.to_xarray = EnsembleTrajectory.to_xarray = to_xarray
Trajectory.plot = plot
Scene._repr_html_ = Prepared._repr_html_ = Trajectory._repr_html_ = html


def run(what, times=None, *, progress=None, **options):
    """Opens, prepares and runs a mechanism in one call; returns a Trajectory, SI units.

    A motion may end early: the status of the Trajectory tells why.

    what: a Scene, a Prepared, or what scene() opens. times: an array of (times,), s; None: the time grid of the scene.
    Options as in prepare().
    """
    if isinstance(what, Prepared):
        if options:
            raise InputError("a Prepared has its options already; give them to prepare()")
        prepared = what
    else:
        prepared = prepare(what if isinstance(what, Scene) else scene(what), **options)
    return Simulator(prepared).run(times, progress=progress)
