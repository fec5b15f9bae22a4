"""Transfer functions over frequency, one frequency for each number of a vector."""

from __future__ import annotations

from typing import Any, Final

from electrovib.solve.population.kernels.compiled.vector_math import exponential
from electrovib.solve.recursion.vectors.jit import inlined, inner, outer
from electrovib.solve.recursion.vectors.lanes import (
    drain,
    fma,
    inverse,
    load,
    splat,
    spread,
    store,
    store_pairs,
    store_row,
    stream_row,
)
from electrovib.solve.recursion.vectors.width import WIDTH

# Modes with a common denominator need one division: A/(a + x) + B/(b + x) = ((A + B) x + A b + B a)/((a + x)(b + x)) with
# x = w^2, and likewise for two such pairs. Of a group of four, `groups` has twelve numbers: the denominator without its
# leading 1, and the numerators of both parts, the coefficient of the highest power first.

LARGEST: Final = 1e35
"""Largest rate and angular frequency, and inverse of the smallest, for which products of eight are formed."""


@inner
def _write_groups(rates: Any, residues: Any, first: Any, end: Any, modes: Any, groups: Any) -> Any:
    """Write the coefficients of the groups of modes of a tile of fingers, (coefficients, fingers)."""
    rate, residue = len(groups) - 8 * WIDTH, len(groups) - 4 * WIDTH
    for group in range((modes + 3) // 4):
        gather_group(rates, 4 * group, first, end, 1.0, groups, rate)
        gather_group(residues, 4 * group, first, end, 0.0, groups, residue)
        at = 12 * group * WIDTH
        s, q, n, m, u, v = _pair(groups, rate, residue)
        t, r, o, k, w, z = _pair(groups, rate + 2 * WIDTH, residue + 2 * WIDTH)
        _write_four(groups, at, s + t, q + r + s * t, s * r + t * q, q * r)
        at += 4 * WIDTH
        _write_four(groups, at, n + o, m + k + n * t + o * s, n * r + m * t + o * q + k * s, m * r + k * q)
        at += 4 * WIDTH
        _write_four(groups, at, u + w, v + z + u * t + w * s, u * r + v * t + w * q + z * s, v * r + z * q)


@inlined
def gather_group(values: Any, mode: Any, first: Any, end: Any, fill: Any, work: Any, at: Any) -> Any:
    """Write four modes of a tile of fingers, (modes, fingers), and another number for those that do not exist."""
    for lane in range(WIDTH):
        for each in range(4):
            exists = first + lane < end and mode + each < values.shape[1]
            work[at + each * WIDTH + lane] = values[first + lane, mode + each] if exists else fill


@inlined
def _write_four(work: Any, at: Any, first: Any, second: Any, third: Any, fourth: Any) -> Any:
    store(work, at, first)
    store(work, at + WIDTH, second)
    store(work, at + 2 * WIDTH, third)
    store(work, at + 3 * WIDTH, fourth)


@inlined
def _pair(work: Any, rate: Any, residue: Any) -> Any:
    """Return a + b, a b, and the coefficients of both numerators, of two modes."""
    first, second = load(work, rate), load(work, rate + WIDTH)
    one, two = load(work, residue), load(work, residue + WIDTH)
    a, b, real, imaginary = first * first, second * second, first * one, second * two
    return a + b, a * b, real + imaginary, real * b + imaginary * a, one + two, one * b + two * a


@inlined
def _evaluate(groups: Any, lane: Any, direct: Any, angular: Any) -> Any:
    """Return the real and imaginary parts of the sum of modes of a finger at angular frequencies."""
    x, real, imaginary = angular * angular, splat(direct), splat(0.0)
    for at in range(lane, len(groups) - 8 * WIDTH, 12 * WIDTH):
        below = fma(x + spread(groups, at), x, spread(groups, at + WIDTH))
        over = inverse(fma(fma(below, x, spread(groups, at + 2 * WIDTH)), x, spread(groups, at + 3 * WIDTH)))
        along = fma(spread(groups, at + 4 * WIDTH), x, spread(groups, at + 5 * WIDTH))
        across = fma(spread(groups, at + 8 * WIDTH), x, spread(groups, at + 9 * WIDTH))
        along = fma(along, x, spread(groups, at + 6 * WIDTH))
        across = fma(across, x, spread(groups, at + 10 * WIDTH))
        real = fma(fma(along, x, spread(groups, at + 7 * WIDTH)), over, real)
        imaginary = fma(fma(across, x, spread(groups, at + 11 * WIDTH)), over, imaginary)
    return real, -angular * imaginary


@inner
def _write_modes(rates: Any, residues: Any, finger: Any, direct: Any, angular: Any, work: Any) -> Any:
    """Write real and imaginary parts in turn, mode by mode, without products of rates."""
    for place in range(0, len(angular), WIDTH):
        w = load(angular, place)
        real, imaginary = splat(direct), splat(0.0)
        for mode in range(rates.shape[1]):
            rate = splat(rates[finger, mode])
            share = splat(residues[finger, mode]) / fma(rate, rate, w * w)
            real, imaginary = fma(rate, share, real), imaginary + share
        store_pairs(work, 2 * place, real, -w * imaginary)


@inner
def _is_wide(numbers: Any) -> Any:
    """Return whether products of eight of these numbers may overflow or vanish."""
    found = False
    for each in numbers:
        found |= each > LARGEST or (each > 0.0 and each * LARGEST < 1.0)
    return found


@inner
def _put_out(work: Any, out: Any, finger: Any, first: Any, past: Any) -> Any:
    """Write one row of a table; past the caches from column `first` on, where a line of them begins, if asked for."""
    count = out.shape[1]
    begin = min(first, count) if past else 0
    end = begin + (count - begin) // WIDTH * WIDTH
    for place in range(begin):
        out[finger, place] = work[place]
    if past:
        for place in range(begin, end, WIDTH):
            stream_row(out, finger, place, load(work, place))
    else:
        for place in range(0, end, WIDTH):
            store_row(out, finger, place, load(work, place))
    for place in range(end, count):
        out[finger, place] = work[place]


@inlined
def _aligned_column(address: Any, numbers: Any) -> Any:
    """Return the first column of a row at which a vector is aligned; `numbers` are those of the table before the row."""
    return -(address // 8 + numbers) % WIDTH


@outer
def transfers(
    rates: Any,
    residues: Any,
    direct: Any,
    angular: Any,
    begin: Any,
    end: Any,
    work: Any,
    groups: Any,
    out: Any,
    address: Any,
    past: Any,
) -> Any:
    """Write the transfer functions of some fingers, (fingers, 2 frequencies); `angular` is filled up to whole vectors.

    Real and imaginary parts alternate. The table begins at `address`, and is written past the caches if asked for.
    """
    count, large = out.shape[1], _is_wide(angular)
    for finger in range(begin, end):
        lane = (finger - begin) % WIDTH
        if lane == 0:
            _write_groups(rates, residues, finger, end, rates.shape[1], groups)
        if large or _is_wide(rates[finger]):
            _write_modes(rates, residues, finger, direct[finger], angular, work)
        else:
            for place in range(0, len(angular), WIDTH):
                real, imaginary = _evaluate(groups, lane, direct[finger], load(angular, place))
                store_pairs(work, 2 * place, real, imaginary)
        _put_out(work, out, finger, _aligned_column(address, finger * count), past)
    drain()


@outer
def mean_squares(
    rates: Any,
    residues: Any,
    direct: Any,
    angular: Any,
    half: Any,
    begin: Any,
    end: Any,
    work: Any,
    groups: Any,
    out: Any,
    address: Any,
    past: Any,
) -> Any:
    """Write a factor times the squared magnitude for some fingers, (fingers, frequencies); as `transfers`."""
    count, large = out.shape[1], _is_wide(angular)
    for finger in range(begin, end):
        lane, factor = (finger - begin) % WIDTH, splat(half[finger])
        if lane == 0:
            _write_groups(rates, residues, finger, end, rates.shape[1], groups)
        if large or _is_wide(rates[finger]):
            _write_modes(rates, residues, finger, direct[finger], angular, work)
            for place in range(count):
                work[place] = half[finger] * (work[2 * place] ** 2 + work[2 * place + 1] ** 2)
        else:
            for place in range(0, len(angular), WIDTH):
                real, imaginary = _evaluate(groups, lane, direct[finger], load(angular, place))
                store(work, place, factor * fma(real, real, imaginary * imaginary))
        _put_out(work, out, finger, _aligned_column(address, finger * count), past)
    drain()


@outer
def permittivities(
    level: Any,
    terms: Any,
    leak: Any,
    angular: Any,
    logarithm: Any,
    begin: Any,
    end: Any,
    work: Any,
    out: Any,
    address: Any,
    past: Any,
) -> Any:
    """Write the permittivities of some fingers as `transfers`; `angular` are inverse angular frequencies.

    `terms`, (fingers * terms * 5,), are: strength, exponent, exponent times the logarithm of the time, and cosine and sine
    of exponent times pi/2.
    """
    count, size, one, each = out.shape[1], len(angular), splat(1.0), len(terms) // len(level)
    for finger in range(begin, end):
        for place in range(0, size, WIDTH):
            real, imaginary = splat(level[finger]), splat(-leak[finger]) * load(angular, place)
            at = load(logarithm, place)
            for term in range(finger * each, (finger + 1) * each, 5):
                power = exponential(fma(spread(terms, term + 1), at, spread(terms, term + 2)))
                along = fma(power, spread(terms, term + 3), one)
                across = power * spread(terms, term + 4)
                share = spread(terms, term) * inverse(fma(along, along, across * across))
                real, imaginary = fma(share, along, real), fma(-share, across, imaginary)
            store_pairs(work, 2 * place, real, imaginary)
        _put_out(work, out, finger, _aligned_column(address, finger * count), past)
    drain()
