"""`assur run --npy`: NumPy reads what --csv writes. Arguments: the command."""
import csv
import os
import subprocess
import sys
import tempfile

try:
    import numpy
except ImportError:
    print("NumPy is missing")
    sys.exit(77)


def rows_of(name):
    """Rows of a CSV, as doubles; an empty field is NaN."""
    with open(name) as file:
        return [{k: float(v) if v else float("nan") for k, v in row.items()} for row in csv.DictReader(file)]


def run(folder, *arguments):
    files = [os.path.join(folder, "motion.csv"), os.path.join(folder, "motion.npy")]
    subprocess.run([sys.argv[1], "run", *arguments, "--quiet", "--csv", files[0], "--npy", files[1]], check=False,
                   stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return rows_of(files[0]), numpy.load(files[1])


with tempfile.TemporaryDirectory() as folder:
    rows, motion = run(folder, "stewart", "--steps", "12")
    assert motion.shape == (13,) and motion.dtype["t"] == numpy.float64
    assert list(motion.dtype.names) == list(rows[0])
    for name in motion.dtype.names:
        assert numpy.array_equal(motion[name], [row[name] for row in rows], equal_nan=True), name

    rows, motion = run(folder, "four_bar", "--steps", "20", "--every", "7", "--single")
    assert motion.shape == (3,) and motion.dtype["B1.x"] == numpy.float32
    for name in motion.dtype.names:
        assert numpy.array_equal(motion[name], numpy.float32([row[name] for row in rows[::7]])), name

    # The second member jams, the third one is no mechanism.
    variants = os.path.join(folder, "variants.csv")
    with open(variants, "w") as file:
        file.write("crank_length,rod_length\n0.1,0.3\n0.2,0.15\n-0.1,0.3\n")
    rows, motion = run(folder, "slider_crank", "--steps", "500", "--ensemble", variants)
    assert motion.shape == (3, 501)
    assert numpy.array_equal(motion["t"][0], motion["t"][2])
    reached = [sum(row["member"] == member for row in rows) for member in (1, 2, 3)]
    assert reached[0] == 501 and 0 < reached[1] < 501 and reached[2] == 0, reached
    at = 0
    for member, count in enumerate(reached):
        for name in motion.dtype.names:
            expected = [row[name] for row in rows[at : at + count]]
            assert numpy.array_equal(motion[name][member, :count], expected, equal_nan=True), name
            assert name == "t" or numpy.isnan(motion[name][member, count:]).all(), name
        at += count
print("done")
