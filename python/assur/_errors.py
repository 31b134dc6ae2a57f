"""Exceptions of assur."""


class Error(Exception):
    """Wrong input, a computation that fails, or a machine that lacks something.

    ``diagnostics`` is a list of pairs (where, what): ``where`` is the JSON pointer of a place in the scene, or "" for
    the whole; ``what`` is the problem and its remedy.
    """

    def __init__(self, message, diagnostics=()):
        super().__init__(message)
        self.diagnostics = list(diagnostics)


class InputError(Error, ValueError):
    """Wrong use of the package, or a wrong scene; an undetermined mechanism is a wrong scene."""


class NumericalError(Error, ArithmeticError):
    """A computation that fails, such as the assembly of a mechanism."""


class MachineError(Error, OSError):
    """The machine: a backend that cannot run here, no memory, a file that cannot be read."""

    def __str__(self):
        return str(self.args[0])


class Interrupted(KeyboardInterrupt):
    """Ctrl-C stopped a call; ``result`` holds what was done before."""

    def __init__(self, result):
        super().__init__("interrupted; the attribute `result` has the rows that were done")
        self.result = result
