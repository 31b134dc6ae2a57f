"""Kinematic analysis of multibody systems by group equations, tuned to the machine.

>>> import assur
>>> motion = assur.run("stewart")
>>> motion["handle1"]

All quantities are in SI units, angles in rad.
"""

from ._core import (
    DriverHandle,
    Ensemble,
    EnsembleTrajectory,
    Event,
    Fleet,
    Law,
    LinkageJoint,
    Machine,
    Outcome,
    Prepared,
    Report,
    Scene,
    SceneBuilder,
    Simulator,
    SimulatorState,
    Status,
    Trajectory,
    __version__,
    backends,
    fitted_distance,
    load_plan,
    nearest_distance,
    parse_scene,
    prepare,
    read_scene,
    sample,
    scene,
    shape_distance,
    this_machine,
    timed_distance,
)
from ._errors import Error, InputError, Interrupted, MachineError, NumericalError
from ._tables import to_pandas, to_xarray

__all__ = [
    "DriverHandle",
    "Ensemble",
    "EnsembleTrajectory",
    "Error",
    "Event",
    "Fleet",
    "InputError",
    "Interrupted",
    "Law",
    "LinkageJoint",
    "Machine",
    "MachineError",
    "NumericalError",
    "Outcome",
    "Prepared",
    "Report",
    "Scene",
    "SceneBuilder",
    "Simulator",
    "SimulatorState",
    "Status",
    "Trajectory",
    "__version__",
    "backends",
    "fitted_distance",
    "load_plan",
    "nearest_distance",
    "parse_scene",
    "prepare",
    "read_scene",
    "run",
    "sample",
    "scene",
    "shape_distance",
    "this_machine",
    "timed_distance",
    "to_pandas",
    "to_xarray",
]

Trajectory.to_pandas = EnsembleTrajectory.to_pandas = to_pandas
Trajectory.to_xarray = EnsembleTrajectory.to_xarray = to_xarray


def run(what, times=None, *, progress=None, **options):
    """Opens, prepares and runs a mechanism in one call; returns a Trajectory.

    what: a Scene, a Prepared, or what scene() opens. times: s; None: the time grid of the scene. Options as in
    prepare().
    """
    if isinstance(what, Prepared):
        if options:
            raise InputError("a Prepared has its options already; give them to prepare()")
        prepared = what
    else:
        prepared = prepare(what if isinstance(what, Scene) else scene(what), **options)
    return Simulator(prepared).run(times, progress=progress)
