"""The types of a vector and of the outcomes of its comparisons, in numba and in LLVM."""
# mypy: disable-error-code="no-untyped-call, untyped-decorator, misc, import-untyped"

from __future__ import annotations

from typing import Any, NamedTuple

from electrovib.solve.recursion.vectors.width import WIDTH


class Kinds(NamedTuple):
    """Types of values in compiled code.

    Parameters
    ----------
    numbers, conditions : numba type
        Vector of float64, and vector of truth values.
    single, truth : numba type
        One float64, and one truth value.
    wide : LLVM type
        Vector of float64.
    """

    numbers: Any
    conditions: Any
    single: Any
    truth: Any
    wide: Any


def vector_kinds() -> Kinds:
    """Return the types of vectors, made known to numba."""
    from llvmlite import ir
    from numba import types
    from numba.extending import models, register_model

    class Lanes(types.Type):
        """Numbers of a vector, or the outcomes of a comparison of each of them."""

    numbers, conditions = Lanes(f"Lanes({WIDTH})"), Lanes(f"Conditions({WIDTH})")
    wide, outcome = ir.VectorType(ir.DoubleType(), WIDTH), ir.VectorType(ir.IntType(1), WIDTH)

    @register_model(Lanes)
    class _Model(models.PrimitiveModel):
        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, wide if kind is numbers else outcome)

    return Kinds(numbers, conditions, types.float64, types.boolean, wide)
