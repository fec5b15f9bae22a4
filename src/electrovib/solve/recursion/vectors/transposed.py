"""The transpose of a square of numbers in vectors, by exchanges that processors have instructions for."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.solve.recursion.vectors.width import WIDTH

if TYPE_CHECKING:
    from typing import Any


def transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """Transpose a square of numbers by exchanging halves of its rows, then halves of these, and so on.

    Parameters
    ----------
    builder : llvmlite.ir.IRBuilder
        Where the instructions are added.
    rows : list
        As many vectors of LLVM as each of them has numbers.

    Returns
    -------
    rows : list
        Columns of the square, as vectors.
    """
    from llvmlite import ir

    distance, indices = WIDTH // 2, ir.VectorType(ir.IntType(32), WIDTH)
    while distance:
        lower = [each if not each & distance else WIDTH + each - distance for each in range(WIDTH)]
        upper = [each + distance if not each & distance else WIDTH + each for each in range(WIDTH)]
        masks = [ir.Constant(indices, each) for each in (lower, upper)]
        for row in range(WIDTH):
            if not row & distance:
                pair = rows[row], rows[row + distance]
                rows[row], rows[row + distance] = (builder.shuffle_vector(*pair, mask) for mask in masks)
        distance //= 2
    return rows
