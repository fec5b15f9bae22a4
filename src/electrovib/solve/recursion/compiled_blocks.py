"""The recursion on an even grid compiled: blocks of as many samples as a vector has, called by `blocks` for long records."""

from __future__ import annotations

import math
from typing import Any, Final

from electrovib.solve.recursion.vectors.jit import inlined, inner, outer
from electrovib.solve.recursion.vectors.operations import fma, load, splat, spread
from electrovib.solve.recursion.vectors.stores import store, store_at
from electrovib.solve.recursion.vectors.width import WIDTH

BLOCKS: Final = 128
"""Blocks whose states are in the cache together."""
COMPENSATED: Final = 512
"""Blocks after which the rounding of the decay in a block is compensated; a multiple of `BLOCKS`."""


@outer
def write_weights(
    z: Any, gains: Any, level: Any, later: Any, onto_output: Any, onto_state: Any, decays: Any
) -> Any:
    """Write the weights of samples and state of a block in its outputs and in the next state, as `block_weights`.

    The second row of `decays` is the correction of the first, the decay in a block, for `COMPENSATED` blocks: 1 - decay is
    exact, so that its difference from -expm1 is the error of the decay as rounded.
    """
    size = decays.shape[1]
    for mode in range(len(z)):
        for since in range(WIDTH):
            power = math.exp(since * z[mode])
            onto_state[(WIDTH - 1 - since) * size + mode] = later[mode] * power
            for output in range(len(gains)):
                onto_output[output, (WIDTH + mode) * WIDTH + since] = gains[output, mode] * power
        whole = WIDTH * z[mode]
        decay = math.exp(whole)
        error = (math.expm1(whole) + (1.0 - decay)) / decay if decay > 0.5 else 0.0
        decays[0, mode], decays[1, mode] = decay, 1.0 + COMPENSATED * error
    for output in range(len(gains)):
        for since in range(WIDTH):
            response = level[output] if since == 0 else 0.0
            for mode in range(len(z) if since > 0 else 0):
                response += gains[output, mode] * onto_state[(WIDTH - since) * size + mode]
            for sample in range(WIDTH - since):
                onto_output[output, sample * WIDTH + sample + since] = response


@outer
def write_end(
    signal: Any, z: Any, gains: Any, level: Any, later: Any, at_end: Any, state: Any, ends: Any
) -> Any:
    """Write the outputs at the last few samples and at the last point, and advance the state to it."""
    for sample in range(len(signal) + 1):
        value = signal[sample] if sample < len(signal) else at_end
        for output in range(len(gains)):
            total = level[output] * value
            for mode in range(len(z)):
                total += gains[output, mode] * state[mode]
            ends[output, sample] = total
        if sample < len(signal):
            for mode in range(len(z)):
                state[mode] = math.exp(z[mode]) * state[mode] + later[mode] * value


@outer
def follow_blocks(
    signal: Any,
    addresses: Any,
    onto_output: Any,
    onto_state: Any,
    decay: Any,
    correction: Any,
    state: Any,
    states: Any,
    from_block: Any,
    blocks: Any,
) -> Any:
    """Advance the states to the end of some blocks, and write the outputs from one of these blocks on.

    The outputs of a block are ``T v + P z`` and the next state is ``decay z + G v``, with the samples v and the state z
    before the block. Rows of `onto_output`, (outputs, (samples + modes) * samples), are columns of T and P; rows of
    `onto_state`, samples times modes, columns of G. Modes are filled up to whole vectors. `states` is for the states
    before `BLOCKS` blocks, and `addresses` are those of the outputs. `from_block` is a
    multiple of `BLOCKS`.
    """
    modes = len(state)
    for first in range(0, blocks, BLOCKS):
        count = min(BLOCKS, blocks - first)
        paired = modes // (2 * WIDTH) * 2 * WIDTH
        for mode in range(0, paired, 2 * WIDTH):
            _follow_two(signal, first * WIDTH, count, onto_state, decay, modes, mode, state, states)
        for mode in range(paired, modes, WIDTH):
            _follow(signal, first * WIDTH, 0, count, onto_state, decay, modes, mode, state, states)
        if (first + count) % COMPENSATED == 0:
            for mode in range(0, modes, WIDTH):
                store(state, mode, load(state, mode) * load(correction, mode))
        if first >= from_block:
            for output in range(len(addresses)):
                _put_out(signal, first * WIDTH, count, onto_output[output], modes, states, addresses[output])


@inner
def _follow(
    signal: Any,
    begin: Any,
    done: Any,
    count: Any,
    onto_state: Any,
    decay: Any,
    modes: Any,
    mode: Any,
    state: Any,
    states: Any,
) -> Any:
    """Write the states of a vector of modes before some blocks."""
    z, by = load(state, mode), load(decay, mode)
    for block in range(done, count):
        pushed = splat(0.0)
        for sample in range(WIDTH):
            value = spread(signal, begin + block * WIDTH + sample)
            pushed = fma(load(onto_state, sample * modes + mode), value, pushed)
        store(states, block * modes + mode, z)
        z = fma(by, z, pushed)
    store(state, mode, z)


@inner
def _follow_two(
    signal: Any,
    begin: Any,
    count: Any,
    onto_state: Any,
    decay: Any,
    modes: Any,
    mode: Any,
    state: Any,
    states: Any,
) -> Any:
    """Write the states of two vectors of modes before some blocks; four blocks at a time share the weights."""
    more, whole = mode + WIDTH, count // 4 * 4
    z, by, w, of = load(state, mode), load(decay, mode), load(state, more), load(decay, more)
    for block in range(0, whole, 4):
        at = begin + block * WIDTH
        p0, p1, p2, p3 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        q0, q1, q2, q3 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for sample in range(WIDTH):
            one, two = load(onto_state, sample * modes + mode), load(onto_state, sample * modes + more)
            v0, v1 = spread(signal, at + sample), spread(signal, at + WIDTH + sample)
            v2, v3 = spread(signal, at + 2 * WIDTH + sample), spread(signal, at + 3 * WIDTH + sample)
            p0, p1, p2, p3 = fma(one, v0, p0), fma(one, v1, p1), fma(one, v2, p2), fma(one, v3, p3)
            q0, q1, q2, q3 = fma(two, v0, q0), fma(two, v1, q1), fma(two, v2, q2), fma(two, v3, q3)
        z = _four(states, block * modes + mode, modes, by, z, p0, p1, p2, p3)
        w = _four(states, block * modes + more, modes, of, w, q0, q1, q2, q3)
    store(state, mode, z)
    store(state, more, w)
    if whole < count:
        _follow(signal, begin, whole, count, onto_state, decay, modes, mode, state, states)
        _follow(signal, begin, whole, count, onto_state, decay, modes, more, state, states)


@inlined
def _four(states: Any, to: Any, modes: Any, by: Any, z: Any, p0: Any, p1: Any, p2: Any, p3: Any) -> Any:
    """Write the states before four blocks, and return those after them."""
    store(states, to, z)
    z = fma(by, z, p0)
    store(states, to + modes, z)
    z = fma(by, z, p1)
    store(states, to + 2 * modes, z)
    z = fma(by, z, p2)
    store(states, to + 3 * modes, z)
    return fma(by, z, p3)


@inner
def _put_out(signal: Any, begin: Any, count: Any, weights: Any, modes: Any, states: Any, address: Any) -> Any:
    """Write one output of some blocks; four blocks at a time share the weights."""
    whole = count // 4 * 4
    for block in range(0, whole, 4):
        at, of = begin + block * WIDTH, block * modes
        y0, y1, y2, y3 = splat(0.0), splat(0.0), splat(0.0), splat(0.0)
        for sample in range(WIDTH):
            share = load(weights, sample * WIDTH)
            y0 = fma(share, spread(signal, at + sample), y0)
            y1 = fma(share, spread(signal, at + WIDTH + sample), y1)
            y2 = fma(share, spread(signal, at + 2 * WIDTH + sample), y2)
            y3 = fma(share, spread(signal, at + 3 * WIDTH + sample), y3)
        for mode in range(len(weights) // WIDTH - WIDTH):
            share = load(weights, (WIDTH + mode) * WIDTH)
            y0 = fma(share, spread(states, of + mode), y0)
            y1 = fma(share, spread(states, of + modes + mode), y1)
            y2 = fma(share, spread(states, of + 2 * modes + mode), y2)
            y3 = fma(share, spread(states, of + 3 * modes + mode), y3)
        store_at(address, at, y0)
        store_at(address, at + WIDTH, y1)
        store_at(address, at + 2 * WIDTH, y2)
        store_at(address, at + 3 * WIDTH, y3)
    for block in range(whole, count):
        y = splat(0.0)
        for sample in range(WIDTH):
            y = fma(load(weights, sample * WIDTH), spread(signal, begin + block * WIDTH + sample), y)
        for mode in range(len(weights) // WIDTH - WIDTH):
            y = fma(load(weights, (WIDTH + mode) * WIDTH), spread(states, block * modes + mode), y)
        store_at(address, begin + block * WIDTH, y)
