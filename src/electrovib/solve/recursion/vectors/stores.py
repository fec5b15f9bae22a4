"""Instructions of LLVM that write vectors: into arrays and tables, transposed, in turn, or past the caches."""
# mypy: disable-error-code="no-untyped-call, untyped-decorator, misc, import-untyped, no-any-return"
# ruff: noqa: ARG001

from __future__ import annotations

from typing import Any

from electrovib.solve.recursion.vectors.operations import KINDS, place_of
from electrovib.solve.recursion.vectors.width import WIDTH


def _storer() -> Any:
    from numba import types
    from numba.extending import intrinsic

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        where_ = place_of(context, builder, sign.args[0], given[0], given[1])
        kind, value = where_.type.pointee, given[2]
        builder.store(value if kind == KINDS.wide else builder.fptrunc(value, kind), where_, align=4)
        return context.get_dummy_value()

    def typed(context: Any, array: Any, place: Any, number: Any) -> Any:
        return types.void(array, types.intp, KINDS.numbers), write

    return intrinsic(typed)


def _to_row(past: bool) -> Any:
    """Return the function that writes a vector to a row of a table; past the caches only where a vector is aligned."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic
    from numba.np.arrayobj import make_array

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        table = make_array(sign.args[0])(context, builder, given[0])
        width = cgutils.unpack_tuple(builder, table.shape)[1]
        place = builder.gep(table.data, [builder.add(builder.mul(given[1], width), given[2])])
        where_ = builder.bitcast(place, KINDS.wide.as_pointer())
        stored = builder.store(given[3], where_, align=8 * WIDTH if past else 8)
        if past:
            once = ir.Constant(ir.IntType(32), 1)
            stored.set_metadata("nontemporal", builder.module.add_metadata([once]))
        return context.get_dummy_value()

    def typed(context: Any, table: Any, row: Any, column: Any, number: Any) -> Any:
        return types.void(table, types.intp, types.intp, KINDS.numbers), write

    return intrinsic(typed)


def _drainer() -> Any:
    """Return the function that completes all stores before it, those past the caches included."""
    from numba import types
    from numba.extending import intrinsic

    def write(context: Any, builder: Any, _sign: Any, _given: Any) -> Any:
        builder.fence("seq_cst")
        return context.get_dummy_value()

    def typed(context: Any) -> Any:
        return types.void(), write

    return intrinsic(typed)


def _pair_storer() -> Any:
    """Return the function that writes two vectors, number by number in turn, into an array of float64."""
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        indices, half = ir.VectorType(ir.IntType(32), WIDTH), WIDTH // 2
        for part in range(2):
            order = [part * half + each // 2 + WIDTH * (each % 2) for each in range(WIDTH)]
            mixed = builder.shuffle_vector(given[2], given[3], ir.Constant(indices, order))
            at = builder.add(given[1], ir.Constant(ir.IntType(64), part * WIDTH))
            builder.store(mixed, place_of(context, builder, sign.args[0], given[0], at), align=8)
        return context.get_dummy_value()

    def typed(context: Any, array: Any, place: Any, one: Any, other: Any) -> Any:
        return types.void(array, types.intp, KINDS.numbers, KINDS.numbers), write

    return intrinsic(typed)


def _address_storer() -> Any:
    """Return the function that writes a vector of float64 to a place after an address."""
    from llvmlite import ir
    from numba import types
    from numba.extending import intrinsic

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        begin = builder.inttoptr(given[0], ir.DoubleType().as_pointer())
        where_ = builder.bitcast(builder.gep(begin, [given[1]]), KINDS.wide.as_pointer())
        builder.store(given[2], where_, align=8)
        return context.get_dummy_value()

    def typed(context: Any, address: Any, place: Any, number: Any) -> Any:
        return types.void(types.int64, types.intp, KINDS.numbers), write

    return intrinsic(typed)


def _row_storer() -> Any:
    """Return the function that writes a square of numbers, of which a row is contiguous, transposed into a table."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic
    from numba.np.arrayobj import make_array

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        table, step = make_array(sign.args[0])(context, builder, given[0]), ir.Constant(ir.IntType(64), WIDTH)
        rows, at = [], given[4]
        for _ in range(WIDTH):
            rows.append(builder.load(place_of(context, builder, sign.args[3], given[3], at), align=8))
            at = builder.add(at, step)
        width = cgutils.unpack_tuple(builder, table.shape)[1]
        at = builder.add(builder.mul(given[1], width), given[2])
        for each in _transposed(builder, rows):
            where_ = place_of(context, builder, sign.args[0], given[0], at)
            kind = where_.type.pointee
            builder.store(each if kind == KINDS.wide else builder.fptrunc(each, kind), where_, align=4)
            at = builder.add(at, width)
        return context.get_dummy_value()

    def typed(context: Any, target: Any, row: Any, column: Any, source: Any, place: Any) -> Any:
        return types.void(target, types.intp, types.intp, source, types.intp), write

    return intrinsic(typed)


def _transposed(builder: Any, rows: list[Any]) -> list[Any]:
    """Transpose a square of numbers by exchanging halves of its rows, then halves of these, and so on."""
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


store, store_at, store_rows = _storer(), _address_storer(), _row_storer()
drain, store_pairs = _drainer(), _pair_storer()
store_row, stream_row = _to_row(past=False), _to_row(past=True)
