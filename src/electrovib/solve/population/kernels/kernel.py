"""The loops over fingers: compiled, or without numba as operations on arrays."""

from importlib.metadata import version
from types import ModuleType

from electrovib.solve.recursion.compiling import is_compiled


def kernel() -> ModuleType:
    """Return the loops over fingers."""
    if is_compiled():
        from electrovib.solve.population.kernels import loops

        return loops
    from electrovib.solve.population.kernels import plain

    return plain


def kernel_name() -> str:
    """Return what computes populations, with the version on which the last bits of results depend."""
    name = "numba" if is_compiled() else "numpy"
    return f"{name} {version(name)}"
