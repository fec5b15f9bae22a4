"""The vector type of compiled code, and the instructions of LLVM for its operations.

Products and sums may be contracted, and the sign of zero is free; nothing else is reordered.
"""
# mypy: disable-error-code="no-untyped-call, untyped-decorator, misc, import-untyped, no-any-return"
# ruff: noqa: ARG001

from __future__ import annotations

import operator
from typing import TYPE_CHECKING, Any, Final

from electrovib.solve.recursion.vectors.vector_type import Kinds, vector_kinds
from electrovib.solve.recursion.vectors.width import ESTIMATES, WIDTH

if TYPE_CHECKING:
    from collections.abc import Callable

_FLAGS: Final = ("contract", "nsz")
_COMPARED: Final = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">="}
KINDS: Final[Kinds] = vector_kinds()
"""Types of the vectors of this process; made once, since each call makes other types."""


def _operator(of: Any, arity: int, result: Any, write: Callable[..., Any]) -> None:
    """Make an operator of Python work on vectors."""
    from numba.core.typing.templates import AbstractTemplate, infer_global, signature
    from numba.extending import lower_builtin

    numbers = KINDS.numbers

    @infer_global(of)
    class _Typed(AbstractTemplate):
        def generic(self, given: Any, _named: Any) -> Any:
            return signature(result, *given) if given == (numbers,) * arity else None

    @lower_builtin(of, *[type(numbers)] * arity)
    def _lower(_context: Any, builder: Any, _signature: Any, given: Any) -> Any:
        return write(builder, *given)


def _make_operators() -> None:
    numbers, conditions = KINDS.numbers, KINDS.conditions
    _operator(operator.add, 2, numbers, lambda b, x, y: b.fadd(x, y, flags=_FLAGS))
    _operator(operator.sub, 2, numbers, lambda b, x, y: b.fsub(x, y, flags=_FLAGS))
    _operator(operator.mul, 2, numbers, lambda b, x, y: b.fmul(x, y, flags=_FLAGS))
    _operator(operator.truediv, 2, numbers, lambda b, x, y: b.fdiv(x, y, flags=_FLAGS))
    _operator(operator.neg, 1, numbers, lambda b, x: b.fsub(_constant(-0.0), x, flags=_FLAGS))
    for compared, sign in _COMPARED.items():
        _operator(compared, 2, conditions, lambda b, x, y, sign=sign: b.fcmp_ordered(sign, x, y))


def _constant(value: float) -> Any:
    from llvmlite import ir

    return ir.Constant(KINDS.wide, [value] * WIDTH)


def _called(builder: Any, name: str, *given: Any) -> Any:
    """Call a function of LLVM on vectors."""
    from llvmlite import ir
    from numba.core import cgutils

    kind = ir.FunctionType(KINDS.wide, [KINDS.wide] * len(given))
    return builder.call(
        cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), given
    )


def _spread(builder: Any, number: Any) -> Any:
    from llvmlite import ir

    nothing, index = ir.Constant(KINDS.wide, ir.Undefined), ir.IntType(32)
    one = builder.insert_element(nothing, number, ir.Constant(index, 0))
    return builder.shuffle_vector(one, nothing, ir.Constant(ir.VectorType(index, WIDTH), [0] * WIDTH))


def _shifted(builder: Any, number: Any, power: Any) -> Any:
    """Multiply by 2 to a power, which is in the last bits of another number."""
    from llvmlite import ir

    whole = ir.VectorType(ir.IntType(64), WIDTH)
    exponent = builder.shl(builder.bitcast(power, whole), ir.Constant(whole, [52] * WIDTH))
    return builder.bitcast(builder.add(builder.bitcast(number, whole), exponent), KINDS.wide)


def _is_some(builder: Any, condition: Any) -> Any:
    from llvmlite import ir

    packed = ir.IntType(WIDTH)
    return builder.icmp_unsigned("!=", builder.bitcast(condition, packed), ir.Constant(packed, 0))


def _inverse(builder: Any, number: Any) -> Any:
    """Return 1/x: an estimate of 14 bits and two steps of Newton's method where the processor has it, else a division."""
    from llvmlite import ir
    from numba.core import cgutils

    one = _constant(1.0)
    if not ESTIMATES:
        return builder.fdiv(one, number, flags=_FLAGS)
    kind = ir.FunctionType(KINDS.wide, [KINDS.wide, KINDS.wide, ir.IntType(8)])
    estimate = cgutils.get_or_insert_function(builder.module, kind, "llvm.x86.avx512.rcp14.pd.512")
    found = builder.call(estimate, [number, _constant(0.0), ir.Constant(ir.IntType(8), 255)])
    opposite = builder.fsub(_constant(-0.0), number, flags=_FLAGS)
    for _ in range(2):
        found = _called(builder, "fma", found, _called(builder, "fma", opposite, found, one), found)
    return found


def _made(write: Callable[..., Any], *given: Any, result: Any) -> Any:
    """Return a function for compiled code; `given` are the kinds of its arguments."""
    from numba.extending import intrinsic

    def typed(*arguments: Any) -> Any:
        return result(*given), lambda _context, builder, _signature, values: write(builder, *values)

    def one(context: Any, x: Any) -> Any:
        return typed()

    def two(context: Any, x: Any, y: Any) -> Any:
        return typed()

    def three(context: Any, x: Any, y: Any, z: Any) -> Any:
        return typed()

    return intrinsic((one, two, three)[len(given) - 1])


def place_of(context: Any, builder: Any, kind: Any, array: Any, index: Any) -> Any:
    """Return the address of a vector in a contiguous array."""
    from llvmlite import ir
    from numba.np.arrayobj import make_array

    data = make_array(kind)(context, builder, array).data
    return builder.bitcast(builder.gep(data, [index]), ir.VectorType(data.type.pointee, WIDTH).as_pointer())


def _loader() -> Any:
    from numba import types
    from numba.extending import intrinsic

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        found = builder.load(place_of(context, builder, sign.args[0], given[0], given[1]), align=8)
        return found if found.type == KINDS.wide else builder.fpext(found, KINDS.wide)

    def typed(context: Any, array: Any, place: Any) -> Any:
        return KINDS.numbers(array, types.intp), write

    return intrinsic(typed)


def _spreader() -> Any:
    """Return the function that reads one number of an array into a vector; its place is not counted from the end."""
    from numba import types
    from numba.extending import intrinsic
    from numba.np.arrayobj import make_array

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        data = make_array(sign.args[0])(context, builder, given[0]).data
        return _spread(builder, builder.load(builder.gep(data, [given[1]])))

    def typed(context: Any, array: Any, place: Any) -> Any:
        return KINDS.numbers(array, types.intp), write

    return intrinsic(typed)


def _prefetcher() -> Any:
    """Return the function that requests the line of the cache with a number of a table, which is read soon."""
    from llvmlite import ir
    from numba import types
    from numba.core import cgutils
    from numba.extending import intrinsic
    from numba.np.arrayobj import make_array

    def write(context: Any, builder: Any, sign: Any, given: Any) -> Any:
        table, number = make_array(sign.args[0])(context, builder, given[0]), ir.IntType(32)
        width = cgutils.unpack_tuple(builder, table.shape)[1]
        place = builder.gep(table.data, [builder.add(builder.mul(given[1], width), given[2])])
        byte = ir.IntType(8).as_pointer()
        kind = ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        builder.call(
            function, [builder.bitcast(place, byte), *[ir.Constant(number, each) for each in (0, 2, 1)]]
        )
        return context.get_dummy_value()

    def typed(context: Any, table: Any, row: Any, column: Any) -> Any:
        return types.void(table, types.intp, types.intp), write

    return intrinsic(typed)


_make_operators()
_N, _C = KINDS.numbers, KINDS.conditions
load, spread, prefetch = _loader(), _spreader(), _prefetcher()
splat = _made(_spread, KINDS.single, result=_N)
fma = _made(lambda b, x, y, z: _called(b, "fma", x, y, z), _N, _N, _N, result=_N)
root = _made(lambda b, x: _called(b, "sqrt", x), _N, result=_N)
size = _made(lambda b, x: _called(b, "fabs", x), _N, result=_N)
inverse = _made(_inverse, _N, result=_N)
shift_exponent = _made(_shifted, _N, _N, result=_N)
where = _made(lambda b, c, x, y: b.select(c, x, y), _C, _N, _N, result=_N)
either = _made(lambda b, x, y: b.or_(x, y), _C, _C, result=_C)
both = _made(lambda b, x, y: b.and_(x, y), _C, _C, result=_C)
other_than = _made(lambda b, x: b.not_(x), _C, result=_C)
some = _made(_is_some, _C, result=KINDS.truth)
