"""Width of the vectors of this processor."""
# mypy: disable-error-code="import-untyped"

from __future__ import annotations

import os
from typing import Final

_VARIABLE: Final = "ELECTROVIB_WIDTH"  # for tests of the narrower kernels


def _width() -> tuple[int, bool]:
    """Return how many float64 numbers a vector of the compiled kernels holds, and whether reciprocals are estimated.

    8 with AVX-512; 4 with AVX2 and fused products, and on processors other than x86, where the compiler divides
    vectors into those of the processor; 1, plain loops, on older processors.
    """
    from llvmlite import binding

    features = binding.get_host_cpu_features()
    is_old = binding.get_process_triple().startswith("x86") and not (
        features.get("avx2") and features.get("fma")
    )
    has_512 = bool(features.get("avx512f"))
    width = int(os.environ.get(_VARIABLE, "0")) or (1 if is_old else 8 if has_512 else 4)
    return width, has_512 and width == 8


WIDTH, ESTIMATES = _width()
"""Numbers in a vector; whether the processor has an instruction for the estimates of their reciprocals."""
