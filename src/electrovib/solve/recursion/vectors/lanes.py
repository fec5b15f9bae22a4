"""Vectors of numbers in the registers of the processor, one number for each finger.

A kernel is written once with `load`, `store`, `splat`, `fma`, `where` and the operators. With a width of 1 these are
plain functions of numbers, so that the kernel is a plain loop; otherwise they emit vector instructions of LLVM.
"""

from __future__ import annotations

import math
from typing import Any

from electrovib.solve.recursion.vectors.jit import inlined
from electrovib.solve.recursion.vectors.width import WIDTH


def _put(array: Any, place: Any, number: Any) -> Any:
    array[place] = number


def _put_rows(target: Any, row: Any, column: Any, source: Any, place: Any) -> Any:
    target[row, column] = source[place]


def _put_row(target: Any, row: Any, column: Any, number: Any) -> Any:
    target[row, column] = number


def _put_pairs(array: Any, place: Any, one: Any, other: Any) -> Any:
    array[place], array[place + 1] = one, other


def _shift(number: Any, power: Any) -> Any:
    return math.ldexp(number, int(power - 6755399441055744.0))


if WIDTH == 1:
    load = inlined(lambda array, place: array[place] + 0.0)
    store, store_rows, shift_exponent = inlined(_put), inlined(_put_rows), inlined(_shift)
    spread = inlined(lambda array, place: array[place] + 0.0)
    splat = inlined(lambda number: number + 0.0)
    fma = inlined(lambda one, other, third: one * other + third)
    root, size = inlined(lambda number: math.sqrt(number + 0.0)), inlined(lambda number: abs(number + 0.0))
    where = inlined(lambda condition, one, other: one if condition else other)
    either, both = inlined(lambda one, other: one or other), inlined(lambda one, other: one and other)
    other_than, some = inlined(lambda condition: not condition), inlined(lambda condition: condition)
    prefetch = inlined(lambda _table, _row, _column: None)
    store_row = stream_row = inlined(_put_row)
    drain, store_pairs = inlined(lambda: None), inlined(_put_pairs)
    inverse = inlined(lambda number: 1.0 / number)
else:
    from electrovib.solve.recursion.vectors.operations import (
        both,
        either,
        fma,
        inverse,
        load,
        other_than,
        prefetch,
        root,
        shift_exponent,
        size,
        some,
        splat,
        spread,
        where,
    )
    from electrovib.solve.recursion.vectors.stores import (
        drain,
        store,
        store_pairs,
        store_row,
        store_rows,
        stream_row,
    )

__all__ = [
    "both",
    "drain",
    "either",
    "fma",
    "inverse",
    "load",
    "other_than",
    "prefetch",
    "root",
    "shift_exponent",
    "size",
    "some",
    "splat",
    "spread",
    "store",
    "store_pairs",
    "store_row",
    "store_rows",
    "stream_row",
    "where",
]
