"""Width of the vectors of this processor."""

from __future__ import annotations

import os
from typing import Final

_VARIABLE: Final = "ELECTROVIB_WIDTH"  # for tests of the narrower kernels


def _width() -> int:
    """Return how many float64 numbers a vector of the compiled kernels holds.

    8 with AVX-512; 4 with AVX2 and fused products, and on processors other than x86, where the compiler divides
    vectors into those of the processor; 1, plain loops, on older processors.
    """
    from llvmlite import binding

    if chosen := os.environ.get(_VARIABLE):
        return int(chosen)
    features = binding.get_host_cpu_features()
    if features.get("avx512f"):
        return 8
    is_old = binding.get_process_triple().startswith("x86") and not (
        features.get("avx2") and features.get("fma")
    )
    return 1 if is_old else 4


WIDTH: Final = _width()
"""Numbers in a vector."""
