"""Which kernel computes populations: chosen once for each process."""

from __future__ import annotations

import functools
import os
from typing import Any, Final

from electrovib.core.errors import InputError

CHOICE: Final = "ELECTROVIB_KERNEL"
"""Variable of the environment with the name of the kernel, ``numpy`` or ``numba``; by default numba where installed."""
_CHOICES: Final = ("numba", "numpy")


@functools.cache
def compiled() -> Any:
    """Return the module of compiled kernels; None where numba is not installed or numpy is chosen."""
    wanted = os.environ.get(CHOICE, "")
    if wanted not in {"", *_CHOICES}:
        raise InputError(f"{CHOICE} = {wanted!r} in the environment: expected {' or '.join(_CHOICES)}.")
    if wanted == "numpy":
        return None
    try:
        from electrovib.solve.population.kernels import compiled as kernels
    except ImportError as error:
        if wanted:
            raise InputError(
                f"{CHOICE} = {wanted!r} in the environment, but numba cannot be imported: install numba, or choose numpy."
            ) from error
        return None
    return kernels


def kernel_name() -> str:
    """Return the kernel of this process, with the version and vector width on which its last bits depend."""
    kernel = compiled()
    if kernel is None:
        import numpy as np

        return f"numpy {np.__version__}"
    return str(kernel.name())
