"""Mechanisms in motion, in notebooks, and plots."""

from html import escape

from ._errors import Error, InputError, MachineError

# The page has styles and scripts of its own: in a frame they do not meet those of the notebook.
FRAME = '<iframe srcdoc="{}" sandbox="allow-scripts" style="width: 100%; height: 900px; border: 0"></iframe>'
STYLE = ".stage { height: 380px; }"  # the frame is tall enough for the picture and one row of curves


def html(item):
    """The mechanism in motion for a notebook; text, if it cannot be drawn."""
    try:
        return FRAME.format(escape(item.page().replace("</style>", STYLE + "</style>", 1)))
    except Error as error:
        return "<pre>" + escape(f"{item!r}\n{error}") + "</pre>"


def plot(motion, columns=None, axes=None):
    """Draws columns of a Trajectory over time t (s) by matplotlib; returns its Figure.

    columns: names; None: all positions, angles and lengths, without their rates. Columns of one unit share a diagram.
    axes: of matplotlib, for columns of one unit; None: a new figure.
    """
    try:
        import matplotlib.pyplot
    except ImportError as missing:
        raise MachineError(f"plot() needs the package matplotlib: {missing}") from missing

    units = motion.units
    if columns is None:
        columns = [name for name in motion.columns if "/s" not in units[name]]
    columns = [columns] if isinstance(columns, str) else list(columns)
    diagrams = {}
    for name in columns:
        diagrams.setdefault(units[name] if name in units else "", []).append((name, motion[name]))
    if not diagrams:
        raise InputError("plot() needs at least one column")
    if axes is None:
        size = (7, 1 + 2.4 * len(diagrams))
        _, rows = matplotlib.pyplot.subplots(
            len(diagrams), sharex=True, squeeze=False, figsize=size, layout="constrained"
        )
        rows = rows[:, 0]
    elif len(diagrams) == 1:
        rows = [axes]
    else:
        raise InputError(f"axes take columns of one unit, not of {', '.join(map(repr, diagrams))}")
    for row, (unit, lines) in zip(rows, diagrams.items()):
        for name, values in lines:
            row.plot(motion.t, values, label=name)
        row.set_ylabel(unit if len(lines) > 1 else f"{lines[0][0]}{unit and f' ({unit})'}")
        if len(lines) > 1:
            row.legend(fontsize="small")
        row.grid(alpha=0.3)
    rows[-1].set_xlabel("t (s)")
    return rows[-1].figure
