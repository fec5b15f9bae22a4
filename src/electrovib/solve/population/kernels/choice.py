"""Which kernel computes populations: chosen once for each process."""

from __future__ import annotations

import functools
import os
from typing import Any, Final

from electrovib.core.errors import InputError

CHOICE: Final = "ELECTROVIB_KERNEL"
"""Variable of the environment with the name of the kernel, ``numpy`` or ``numba``; by default numba where installed."""


@functools.cache
def compiled() -> Any:
    """Return the module of compiled kernels; None while there is none.

    Returns
    -------
    kernels : module or None
        None: numpy computes everything.

    Raises
    ------
    InputError
        If the environment asks for another kernel than numpy.
    """
    wanted = os.environ.get(CHOICE, "")
    if wanted not in {"", "numpy"}:
        raise InputError(f"{CHOICE} = {wanted!r} in the environment: expected numpy.")
    return None


def kernel_name() -> str:
    """Return the kernel of this process, with the version and vector width on which its last bits depend.

    Returns
    -------
    name : str
        ``"numpy 2.4.6"``, or ``"numba 0.68.1, width 8"``.
    """
    kernel = compiled()
    if kernel is None:
        import numpy as np

        return f"numpy {np.__version__}"
    return str(kernel.name())
