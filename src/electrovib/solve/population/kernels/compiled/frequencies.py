"""Transfer functions over frequency, one frequency for each number of a vector."""

from __future__ import annotations

from typing import Any

from electrovib.solve.population.kernels.compiled.vector_math import exponential
from electrovib.solve.recursion.vectors.jit import inlined, inner, outer
from electrovib.solve.recursion.vectors.lanes import fma, inverse, load, splat, store
from electrovib.solve.recursion.vectors.width import WIDTH

# Two modes have one denominator: A/(a + x) + B/(b + x) = ((A + B) x + A b + B a)/((a + x)(b + x)), x = w^2; of three
# divisions one is left for four sums. `pairs`, (pairs, 6), are: a + b, a b, and both coefficients for each part.


@inner
def _write_pairs(rates: Any, residues: Any, finger: Any, pairs: Any) -> Any:
    """Write the coefficients of the pairs of modes of a finger; the last may have a second mode of residue 0."""
    modes = rates.shape[1]
    for pair in range((modes + 1) // 2):
        first, second = rates[finger, 2 * pair], 1.0
        one, two = residues[finger, 2 * pair], 0.0
        if 2 * pair + 1 < modes:
            second, two = rates[finger, 2 * pair + 1], residues[finger, 2 * pair + 1]
        a, b = first * first, second * second
        pairs[pair, 0], pairs[pair, 1] = a + b, a * b
        pairs[pair, 2], pairs[pair, 3] = first * one + second * two, first * one * b + second * two * a
        pairs[pair, 4], pairs[pair, 5] = one + two, one * b + two * a


@inlined
def _evaluate(pairs: Any, direct: Any, angular: Any) -> Any:
    """Return real part, and imaginary part, of the sum of modes at angular frequencies."""
    x, real, imaginary = angular * angular, splat(direct), splat(0.0)
    for pair in range(len(pairs)):
        below = fma(x + splat(pairs[pair, 0]), x, splat(pairs[pair, 1]))
        over = inverse(below)
        real = fma(fma(splat(pairs[pair, 2]), x, splat(pairs[pair, 3])), over, real)
        imaginary = fma(fma(splat(pairs[pair, 4]), x, splat(pairs[pair, 5])), over, imaginary)
    return real, -angular * imaginary


@outer
def transfers(
    rates: Any,
    residues: Any,
    direct: Any,
    angular: Any,
    begin: Any,
    end: Any,
    work: Any,
    pairs: Any,
    out: Any,
) -> Any:
    """Write the transfer functions of some fingers, (fingers, frequencies, 2); `angular` is filled up to whole vectors."""
    count = out.shape[1]
    for finger in range(begin, end):
        _write_pairs(rates, residues, finger, pairs)
        for place in range(0, len(angular), WIDTH):
            real, imaginary = _evaluate(pairs, direct[finger], load(angular, place))
            store(work, place, real)
            store(work, len(angular) + place, imaginary)
        for place in range(count):
            out[finger, place, 0], out[finger, place, 1] = work[place], work[len(angular) + place]


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
    pairs: Any,
    out: Any,
) -> Any:
    """Write a factor times the squared magnitude for some fingers, (fingers, frequencies)."""
    count = out.shape[1]
    for finger in range(begin, end):
        _write_pairs(rates, residues, finger, pairs)
        factor = splat(half[finger])
        for place in range(0, len(angular), WIDTH):
            real, imaginary = _evaluate(pairs, direct[finger], load(angular, place))
            store(work, place, factor * fma(real, real, imaginary * imaginary))
        for place in range(count):
            out[finger, place] = work[place]


@outer
def permittivities(
    level: Any, terms: Any, leak: Any, angular: Any, logarithm: Any, begin: Any, end: Any, work: Any, out: Any
) -> Any:
    """Write the permittivities of some fingers, (fingers, frequencies, 2); `angular` are inverse angular frequencies.

    `terms`, (fingers, terms, 5), are: strength, exponent, exponent times the logarithm of the time, and cosine and sine
    of exponent times pi/2.
    """
    count, size, one = out.shape[1], len(angular), splat(1.0)
    for finger in range(begin, end):
        for place in range(0, size, WIDTH):
            real, imaginary = splat(level[finger]), splat(-leak[finger]) * load(angular, place)
            at = load(logarithm, place)
            for term in range(terms.shape[1]):
                power = exponential(fma(splat(terms[finger, term, 1]), at, splat(terms[finger, term, 2])))
                along = fma(power, splat(terms[finger, term, 3]), one)
                across = power * splat(terms[finger, term, 4])
                share = splat(terms[finger, term, 0]) * inverse(fma(along, along, across * across))
                real, imaginary = fma(share, along, real), fma(-share, across, imaginary)
            store(work, place, real)
            store(work, size + place, imaginary)
        for place in range(count):
            out[finger, place, 0], out[finger, place, 1] = work[place], work[size + place]
