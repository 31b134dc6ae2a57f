"""Finds a four-bar whose coupler point draws a given curve.

Many random four-bars are moved as a fleet; the closest ones are refined by least squares, in which all steps of the
difference quotients are one fleet again. Needs NumPy and SciPy. Prints the distances, m.
"""

import numpy
from scipy.optimize import least_squares

import assur

TIMES = numpy.linspace(0, 1, 60, endpoint=False)  # one turn of the crank, s


def target():
    """The curve: an egg about 2 m wide, an array of (times, 2), m."""
    angle = 2 * numpy.pi * TIMES
    return numpy.stack([1.2 + numpy.cos(angle), 1.5 + (0.45 + 0.12 * numpy.cos(angle)) * numpy.sin(angle)], axis=1)


# Of a design: ground joints A (x, y) and D (x, y); lengths of crank, coupler and rocker; the crank's angle at t = 0;
# the coupler point along and across the coupler, in parts of its length. m and rad.
LOW = numpy.array([-2, -2, -2, -2, 0.1, 0.5, 0.5, 0, -1, -1])
HIGH = numpy.array([3, 3, 4, 4, 1.5, 4, 4, 2 * numpy.pi, 2, 2])


def linkage(design):
    xa, ya, xd, yd, crank, coupler, rocker, angle, along, across = design
    joint = assur.LinkageJoint
    return [
        joint.ground(xa, ya),
        joint.crank(0, crank, angle, 2 * numpy.pi),
        joint.ground(xd, yd),
        joint.dyad(1, 2, coupler, rocker, True),
        joint.point(1, 3, along, across),
    ]


def paths_of(designs):
    """Paths of the coupler points, an array of (designs, times, 2), m; NaN after a four-bar has jammed."""
    paths, _, _ = assur.Fleet([linkage(design) for design in designs]).run(TIMES)
    return paths


def refine(design, curve, scale=HIGH - LOW):
    """The design at a minimum of the distances between path and curve at equal times."""

    def residuals(designs):
        return numpy.nan_to_num((paths_of(designs) - curve).reshape(len(designs), -1), nan=10)

    def slopes(x, step=1e-6):
        ends = residuals(x + step * numpy.concatenate([numpy.diag(scale), -numpy.diag(scale)]))
        return ((ends[: len(x)] - ends[len(x) :]) / (2 * step * scale[:, None])).T

    found = least_squares(lambda x: residuals([x])[0], design, jac=slopes, bounds=(LOW, HIGH), x_scale=scale)
    return found.x


def main(designs=4000, refined=8):
    curve = target()
    draws = numpy.random.default_rng(0).uniform(LOW, HIGH, (designs, len(LOW)))
    paths = paths_of(draws)
    moving = numpy.isfinite(paths).all(axis=(1, 2)).nonzero()[0]
    distance = numpy.array([assur.timed_distance(paths[i], curve) for i in moving])
    best = draws[moving[numpy.argsort(distance)[:refined]]]
    print(f"{len(moving)} of {designs} random four-bars turn fully; the closest is {distance.min():.3f} m away")
    fits = [refine(design, curve) for design in best]
    ends = [assur.timed_distance(path, curve) for path in paths_of(fits)]
    print(f"refined: {min(ends):.4f} m")
    return fits[int(numpy.argmin(ends))], min(ends), distance.min()


if __name__ == "__main__":
    main()
