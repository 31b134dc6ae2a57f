#!/usr/bin/env python3
"""Makes a data set of linkages with `assur sweep linkages`, reads it with h5py, and computes it again with NumPy.

usage: linkages.py ASSUR [SAMPLES [BATCH]]

Prints the largest difference of the curves and the times of both ways; ends with 1 if the curves differ, with 77 if h5py
or HDF5 is missing. The NumPy way solves a batch of linkages at once, for all times: dyad after dyad in closed form. It
gets only linkages that are known to move, and computes neither rates nor errors.
"""
import pathlib
import subprocess
import sys
import tempfile
import time

GROUND, CRANK, DYAD, POINT = range(4)  # LinkageJoint::Kind


def paths(np, joints, kind, left, parents, values, times):
    """Complex positions (linkage, joint, time) of joints (linkage, joint)."""
    linkages, most = kind.shape
    at = np.zeros((linkages, most, len(times)), complex)
    row = np.arange(linkages)
    for j in range(int(joints.max())):
        k, v = kind[:, j], values[:, j]
        first, second = at[row, parents[:, j, 0]], at[row, parents[:, j, 1]]
        ground, crank, dyad = ((j < joints) & (k == x) for x in (GROUND, CRANK, DYAD))
        at[ground, j] = (v[ground, 0] + 1j * v[ground, 1])[:, None]
        angle = v[crank, 1, None] + v[crank, 2, None] * times
        at[crank, j] = first[crank] + v[crank, 0, None] * np.exp(1j * angle)
        a, b = v[dyad, 0, None], v[dyad, 1, None]
        line = second[dyad] - first[dyad]
        square = line.real**2 + line.imag**2
        along = (square + (a - b) * (a + b)) / (2 * square)
        across = np.sqrt(a * a / square - along * along) * np.where(left[dyad, j, None], 1, -1)
        at[dyad, j] = first[dyad] + (along + 1j * across) * line
    return at


def normalize(np, path):
    """Curves (linkage, time) in their normal places."""
    z = path - path.mean(1, keepdims=True)
    z /= np.sqrt((abs(z) ** 2).mean(1, keepdims=True))
    return z * np.exp(-0.5j * np.angle((z * z).sum(1, keepdims=True)))


def main():
    try:
        import h5py
        import numpy as np
    except ImportError as e:
        print(f"skipped: {e}")
        return 77
    command, samples = sys.argv[1], int(sys.argv[2]) if len(sys.argv) > 2 else 20000
    batch = int(sys.argv[3]) if len(sys.argv) > 3 else 500
    with tempfile.TemporaryDirectory() as folder:
        name = pathlib.Path(folder) / "linkages.h5"
        begin = time.perf_counter()
        made = subprocess.run([command, "sweep", "linkages:precision=double", "--samples", str(samples), "--threads", "1",
                               "--quiet", "--out", name], capture_output=True, text=True)
        seconds = time.perf_counter() - begin
        if "HDF5 was not found" in made.stderr:
            print(f"skipped: {made.stderr}")
            return 77
        if made.returncode != 0:
            print(made.stderr)
            return 1
        with h5py.File(name) as file:
            data = {key: file[key][:] for key in file}
            done, rows = file.attrs["samples"], file.attrs["rows"]
    assert done == samples and rows == len(data["sample"]) > 0, "all samples are done"
    assert (np.diff(data["sample"]) > 0).all() and data["sample"][-1] < samples, "samples ascend"
    curves = data["curves"][..., 0] + 1j * data["curves"][..., 1]
    joints = data["joints"]
    dyads = int((data["kind"] == DYAD).sum()) * len(data["times"])

    begin = time.perf_counter()
    again, original = np.empty_like(curves), np.empty_like(curves)
    for i in range(0, rows, batch):
        part = slice(i, i + batch)
        at = paths(np, joints[part], data["kind"][part], data["left"][part], data["parents"][part], data["values"][part],
                   data["times"])
        original[part] = at[np.arange(len(at)), joints[part] - 1]
        again[part] = normalize(np, original[part])
    by_numpy = time.perf_counter() - begin

    # The direction of a curve without a longest direction is not determined.
    centered = original - original.mean(1, keepdims=True)
    long = abs((centered**2).sum(1)) / (abs(centered) ** 2).sum(1)
    sure = long > 1e-3
    turned = np.minimum(abs(again - curves).max(1), abs(again + curves).max(1))[sure].max()
    frame = data["center"][:, 0] + 1j * data["center"][:, 1]
    back = curves * (data["radius"] * np.exp(1j * data["angle"]))[:, None] + frame[:, None]
    moved = (abs(back - original).max(1) / abs(original).max(1)).max()
    print(f"{samples} samples, {rows} rows, {dyads:.3g} dyads in them")
    print(f"assur, one thread, with all samples that jam and the file: {seconds:.2f} s, {dyads / seconds:.3g} dyads/s")
    print(f"NumPy, the rows alone, no file: {by_numpy:.2f} s, {dyads / by_numpy:.3g} dyads/s")
    print(f"largest relative difference: {moved:.2g} of the paths, {turned:.2g} of the curves in their normal places")
    return 0 if moved < 1e-9 and turned < 1e-6 else 1


if __name__ == "__main__":
    sys.exit(main())
