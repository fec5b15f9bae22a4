"""Types of arrays, for the type checker."""

from __future__ import annotations

from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

Real: TypeAlias = NDArray[np.float64]
Complex: TypeAlias = NDArray[np.complex128]
Indices: TypeAlias = NDArray[np.intp]
Numbers: TypeAlias = NDArray[Any]
"""Real or complex, or objects that are all Decimal."""
