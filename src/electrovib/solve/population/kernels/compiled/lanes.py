"""Vectors of numbers in the registers of the processor, one number for each finger.

A kernel is written once with `load`, `store`, `splat`, `fma`, `where` and the operators. With a width of 1 these are
plain functions of numbers, so that the kernel is a plain loop; otherwise they emit vector instructions of LLVM.
"""

from __future__ import annotations

import math
import operator
from typing import TYPE_CHECKING, Any, Final

from electrovib.solve.population.kernels.compiled.jit import inlined
from electrovib.solve.population.kernels.compiled.width import WIDTH

if TYPE_CHECKING:
    from collections.abc import Callable

_COMPARED: Final = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
_FLAGS: Final = ("contract", "nsz")


def _plain() -> dict[str, Callable[..., Any]]:
    """Return the operations on single numbers."""
    return {
        "load": inlined(lambda array, place: array[place]),
        "store": inlined(_put),
        "splat": inlined(lambda number: number + 0.0),
        "fma": inlined(lambda one, other, third: one * other + third),
        "root": inlined(lambda number: math.sqrt(number)),
        "size": inlined(lambda number: abs(number)),
        "where": inlined(lambda condition, one, other: one if condition else other),
        "either": inlined(lambda one, other: one or other),
        "both": inlined(lambda one, other: one and other),
        "other_than": inlined(lambda condition: not condition),
        "some": inlined(lambda condition: condition),
        "store_rows": inlined(_put_rows),
        "shift_exponent": inlined(lambda number, power: math.ldexp(number, int(power - 6755399441055744.0))),
    }


def _put(array: Any, place: Any, number: Any) -> Any:
    array[place] = number


def _put_rows(target: Any, row: Any, column: Any, source: Any, place: Any) -> Any:
    target[row, column] = source[place]


def _vectors() -> dict[str, Callable[..., Any]]:
    """Return the operations on vectors, and make the operators of Python work on them."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.core.typing.templates import AbstractTemplate, infer_global, signature
    from numba.extending import intrinsic, lower_builtin, models, register_model
    from numba.np.arrayobj import make_array

    class Lanes(types.Type):  # type: ignore[misc]
        """Numbers of a vector, or the outcomes of a comparison of each of them."""

    numbers, conditions = Lanes(f"Lanes({WIDTH})"), Lanes(f"Conditions({WIDTH})")

    wide = ir.VectorType(ir.DoubleType(), WIDTH)
    whole, outcome = ir.VectorType(ir.IntType(64), WIDTH), ir.VectorType(ir.IntType(1), WIDTH)

    @register_model(Lanes)
    class _Model(models.PrimitiveModel):  # type: ignore[misc]
        def __init__(self, manager: Any, kind: Any) -> None:
            super().__init__(manager, kind, wide if kind is numbers else outcome)

    def constant(value: float) -> Any:
        return ir.Constant(wide, [value] * WIDTH)

    def operation(of: Any, arity: int, result: Any, write: Callable[..., Any]) -> None:
        """Make an operator of Python work on vectors."""

        @infer_global(of)
        class _Typed(AbstractTemplate):  # type: ignore[misc]
            def generic(self, given: Any, _named: Any) -> Any:
                return signature(result, *given) if given == (numbers,) * arity else None

        @lower_builtin(of, *[Lanes] * arity)
        def _lower(_context: Any, builder: Any, _signature: Any, given: Any) -> Any:
            return write(builder, *given)

    operation(operator.add, 2, numbers, lambda b, x, y: b.fadd(x, y, flags=_FLAGS))
    operation(operator.sub, 2, numbers, lambda b, x, y: b.fsub(x, y, flags=_FLAGS))
    operation(operator.mul, 2, numbers, lambda b, x, y: b.fmul(x, y, flags=_FLAGS))
    operation(operator.truediv, 2, numbers, lambda b, x, y: b.fdiv(x, y, flags=_FLAGS))
    operation(operator.neg, 1, numbers, lambda b, x: b.fsub(constant(-0.0), x, flags=_FLAGS))
    for compared, sign in _COMPARED.items():
        operation(compared, 2, conditions, lambda b, x, y, sign=sign: b.fcmp_ordered(sign, x, y))

    def called(builder: Any, name: str, *given: Any) -> Any:
        """Call a function of LLVM on vectors."""
        kind = ir.FunctionType(wide, [wide] * len(given))
        function = cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64")
        return builder.call(function, given)

    def spread(builder: Any, number: Any) -> Any:
        one = builder.insert_element(ir.Constant(wide, ir.Undefined), number, ir.Constant(ir.IntType(32), 0))
        same = ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), [0] * WIDTH)
        return builder.shuffle_vector(one, ir.Constant(wide, ir.Undefined), same)

    def place_of(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
        """Return the address of a vector in a contiguous array."""
        data = make_array(kind)(context, builder, array).data
        element = ir.VectorType(data.type.pointee, WIDTH)
        return builder.bitcast(builder.gep(data, [index]), element.as_pointer())

    def transposed(builder: Any, rows: list[Any]) -> list[Any]:
        """Transpose a square of numbers by exchanging halves of its rows, then halves of these, and so on."""
        distance = WIDTH // 2
        while distance:
            lower = [each if not each & distance else WIDTH + each - distance for each in range(WIDTH)]
            upper = [each + distance if not each & distance else WIDTH + each for each in range(WIDTH)]
            masks = [ir.Constant(ir.VectorType(ir.IntType(32), WIDTH), each) for each in (lower, upper)]
            for row in range(WIDTH):
                if not row & distance:
                    pair = rows[row], rows[row + distance]
                    rows[row], rows[row + distance] = (builder.shuffle_vector(*pair, mask) for mask in masks)
            distance //= 2
        return rows

    def shifted(builder: Any, number: Any, power: Any) -> Any:
        """Multiply by 2 to a power, which is in the last bits of another number."""
        exponent = builder.shl(builder.bitcast(power, whole), ir.Constant(whole, [52] * WIDTH))
        return builder.bitcast(builder.add(builder.bitcast(number, whole), exponent), wide)

    def made(write: Callable[..., Any], *given: Any, result: Any = numbers) -> Any:
        """Return a function for compiled code; `given` are the kinds of its arguments."""

        def typed(_context: Any, *arguments: Any) -> Any:
            return result(*given), lambda _c, builder, _s, values: write(builder, *values)

        def one(context: Any, x: Any) -> Any:
            return typed(context, x)

        def two(context: Any, x: Any, y: Any) -> Any:
            return typed(context, x, y)

        def three(context: Any, x: Any, y: Any, z: Any) -> Any:
            return typed(context, x, y, z)

        return intrinsic((one, two, three)[len(given) - 1])

    @intrinsic  # type: ignore[untyped-decorator]
    def load(_context: Any, array: Any, place: Any) -> Any:
        def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
            found = builder.load(place_of(context, builder, sign.args[0], given[0], given[1]), align=8)
            return found if found.type == wide else builder.fpext(found, wide)

        return numbers(array, types.intp), write

    @intrinsic  # type: ignore[untyped-decorator]
    def store(_context: Any, array: Any, place: Any, number: Any) -> Any:
        def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
            where = place_of(context, builder, sign.args[0], given[0], given[1])
            kind, value = where.type.pointee, given[2]
            value = value if kind == wide else builder.fptrunc(value, kind)
            builder.store(value, where, align=8 if kind == wide else 4)
            return context.get_dummy_value()

        return types.void(array, types.intp, number), write

    @intrinsic  # type: ignore[untyped-decorator]
    def store_rows(_context: Any, target: Any, row: Any, column: Any, source: Any, place: Any) -> Any:
        """Write a square of numbers, of which a row is contiguous in memory, transposed into a table."""

        def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
            table, step = (
                make_array(sign.args[0])(context, builder, given[0]),
                ir.Constant(ir.IntType(64), WIDTH),
            )
            rows, at = [], given[4]
            for _ in range(WIDTH):
                rows.append(builder.load(place_of(context, builder, sign.args[3], given[3], at), align=8))
                at = builder.add(at, step)
            width = cgutils.unpack_tuple(builder, table.shape)[1]
            at = builder.add(builder.mul(given[1], width), given[2])
            for each in transposed(builder, rows):
                where = place_of(context, builder, sign.args[0], given[0], at)
                kind = where.type.pointee
                builder.store(each if kind == wide else builder.fptrunc(each, kind), where, align=4)
                at = builder.add(at, width)
            return context.get_dummy_value()

        return types.void(target, types.intp, types.intp, source, types.intp), write

    def is_some(builder: Any, condition: Any) -> Any:
        packed = builder.bitcast(condition, ir.IntType(WIDTH))
        return builder.icmp_unsigned("!=", packed, ir.Constant(ir.IntType(WIDTH), 0))

    return {
        "load": load,
        "store": store,
        "store_rows": store_rows,
        "splat": made(spread, types.float64),
        "fma": made(lambda b, x, y, z: called(b, "fma", x, y, z), numbers, numbers, numbers),
        "root": made(lambda b, x: called(b, "sqrt", x), numbers),
        "size": made(lambda b, x: called(b, "fabs", x), numbers),
        "where": made(lambda b, c, x, y: b.select(c, x, y), conditions, numbers, numbers),
        "either": made(lambda b, x, y: b.or_(x, y), conditions, conditions, result=conditions),
        "both": made(lambda b, x, y: b.and_(x, y), conditions, conditions, result=conditions),
        "other_than": made(lambda b, x: b.not_(x), conditions, result=conditions),
        "some": made(is_some, conditions, result=types.boolean),
        "shift_exponent": made(shifted, numbers, numbers),
    }


_operations = _plain() if WIDTH == 1 else _vectors()
load, store, splat, fma = (_operations[name] for name in ("load", "store", "splat", "fma"))
root, size, where = (_operations[name] for name in ("root", "size", "where"))
either, both, some = (_operations[name] for name in ("either", "both", "some"))
other_than = _operations["other_than"]
shift_exponent, store_rows = _operations["shift_exponent"], _operations["store_rows"]
