"""`assur run --npy` and `--hdf5`: NumPy and h5py read what --csv writes. Arguments: the command."""
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


try:
    import h5py
except ImportError:
    print("h5py is missing")
    h5py = None


def rows_of(name):
    """Rows of a CSV, as doubles; an empty field is NaN."""
    with open(name) as file:
        return [{k: float(v) if v else float("nan") for k, v in row.items()} for row in csv.DictReader(file)]


def run(folder, *arguments):
    files = [os.path.join(folder, "motion." + end) for end in ("csv", "npy", "h5")]
    command = [sys.argv[1], "run", *arguments, "--quiet", "--csv", files[0], "--npy", files[1]]
    if h5py:
        command += ["--hdf5", files[2]]
    done = subprocess.run(command, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True)
    if "HDF5 was not found" in done.stderr:
        print(done.stderr)
        sys.exit(77)
    motion = numpy.load(files[1])
    if h5py:
        compare(files[2], motion)
    return rows_of(files[0]), motion


def compare(name, motion):
    """The HDF5 file has the columns of the array."""
    with h5py.File(name) as file:
        first = motion["t"] if motion.ndim == 1 else motion["t"][0]
        assert numpy.array_equal(file["t"][:], first)
        for column in motion.dtype.names[1:]:
            assert file[column].dtype == motion.dtype[column], column
            assert numpy.array_equal(file[column][:], motion[column], equal_nan=True), column


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

    wrong = subprocess.run([sys.argv[1], "run", "four_bar", "--every", "2"], check=False, capture_output=True, text=True)
    assert wrong.returncode == 2 and "--every: chooses rows of --npy or --hdf5; give one of them" in wrong.stderr, wrong

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
