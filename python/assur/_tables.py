"""Motions as tables of other packages, which need not be there."""


def to_pandas(motion):
    """A pandas.DataFrame with the columns of a Trajectory, indexed by time t (s).

    Of an EnsembleTrajectory, indexed by member and t. The numbers are copied.
    """
    import pandas

    values = motion.values
    if values.ndim == 2:
        return pandas.DataFrame(values, columns=motion.columns, index=pandas.Index(motion.t, name="t"))
    index = pandas.MultiIndex.from_product([range(len(motion)), motion.t], names=["member", "t"])
    return pandas.DataFrame(values.reshape(-1, values.shape[2]), columns=motion.columns, index=index)


def to_xarray(motion):
    """An xarray.DataArray with the dimensions t and column, of an EnsembleTrajectory also member; SI units.

    Nothing is copied.
    """
    import xarray

    coordinates = {"t": motion.t, "column": motion.columns}
    dimensions = ["member", "t", "column"][-motion.values.ndim :]
    return xarray.DataArray(motion.values, dims=dimensions, coords=coordinates)
