"""Makes a data set of linkages and their paths for machine learning, and reads it back.

Random linkages of 5 to 12 joints are moved as a fleet; those that turn fully are kept, with their paths in their normal
places (centered, radius 1, longest along x). Needs NumPy. Usage: linkage_data.py [FILE.npz [LINKAGES [SEED]]]
"""

import sys

import numpy

import assur

JOINTS = (5, 12)
TIMES = numpy.arange(200) / 200  # of one turn, s
KINDS = ["ground", "crank", "dyad"]


def rows_of(linkages):
    """The joints as arrays of (linkages, joints, ...); unused joints are 0."""
    shape = (len(linkages), JOINTS[1])
    kind, left = numpy.zeros(shape, numpy.uint8), numpy.zeros(shape, bool)
    parents, value = numpy.zeros((*shape, 2), numpy.uint16), numpy.zeros((*shape, 3))
    for i, joints in enumerate(linkages):
        for k, joint in enumerate(joints):
            kind[i, k], left[i, k] = KINDS.index(joint.kind), joint.left
            parents[i, k], value[i, k] = (joint.first, joint.second), joint.value
    return {"joints": numpy.array([len(joints) for joints in linkages]), "kind": kind, "left": left,
            "parents": parents, "value": value}


def make(file, count=5000, seed=0):
    """Writes the linkages of `count` random ones that turn fully. Returns their number."""
    times = numpy.append(TIMES, 1)  # a linkage must not jam after the last time of its path
    paths, _, status = assur.Fleet.random(count, seed=seed, joints=JOINTS).run(times)
    done = [k for k in range(count) if status[k] == "ok"]
    frames = [assur.frame_of(paths[k, :-1]) for k in done]
    numpy.savez_compressed(
        file, seed=seed, sample=done, times=TIMES,
        curves=numpy.array([assur.normalize(paths[k, :-1]) for k in done], numpy.float32),
        center=[frame.center for frame in frames], radius=[frame.radius for frame in frames],
        angle=[frame.angle for frame in frames],
        **rows_of([assur.random_linkage(seed, k, JOINTS) for k in done]),
    )
    return len(done)


def linkage_in(data, row):
    """A linkage of the data set, as a list of LinkageJoint."""
    joint = assur.LinkageJoint
    out = []
    for kind, left, (a, b), (u, v, w) in zip(*(data[name][row] for name in ("kind", "left", "parents", "value"))):
        if len(out) == data["joints"][row]:
            break
        a, b, u, v, w = int(a), int(b), float(u), float(v), float(w)
        make_joint = [lambda: joint.ground(u, v), lambda: joint.crank(a, u, v, w),
                      lambda: joint.dyad(a, b, u, v, bool(left))]
        out.append(make_joint[kind]())
    return out


def main(file="linkages.npz", count=5000, seed=0):
    rows = make(file, int(count), int(seed))
    data = dict(numpy.load(file))
    paths, _, _ = assur.Fleet([linkage_in(data, row) for row in range(rows)]).run(TIMES)
    again = numpy.array([assur.normalize(path) for path in paths])
    print(f"{rows} of {count} linkages turn fully; curves read back differ by {abs(again - data['curves']).max():.1e}")
    return data


if __name__ == "__main__":
    main(*sys.argv[1:])
