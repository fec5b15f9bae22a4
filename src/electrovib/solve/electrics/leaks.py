"""One layer with non-ohmic conduction: linear modes and one scalar nonlinear branch.

All linear parts keep their modes and their exact response to the drive. The leak is a current density J(E) in parallel
with one layer. Within a step it is taken as linear in time and the modes respond to it exactly; the field at the end of
the step follows from one scalar equation E + weight J(E) = known, which has one root because J never decreases. The
error is of second order in the step; it is measured by halving all steps, and reported. The returned response is
extrapolated from the last two step sizes, which makes it a hundred times better where the field crosses no kink of J.
"""

from __future__ import annotations

import functools
import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Linear
from electrovib.physics.stack import pieces
from electrovib.solve.electrics.solution import LEAK, Solution
from electrovib.solve.electrics.steps import halved, jump_heights, step_grid
from electrovib.solve.electrics.transient import (
    Response,
    amplified,
    refuse_behind_amplifier,
    refuse_gaps_of_a_law,
    transient,
)
from electrovib.solve.meter import Meter
from electrovib.solve.recursion import hold_weights
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import FieldOf
from electrovib.solve.stack.modes import StackModes, bound_residues, slab_impedance
from electrovib.solve.stack.section import ModalSection, section_of, slabs_of
from electrovib.solve.stack.transfer import INTEGRATING, Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.conduction import Conduction
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.stack import Layer
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key

TOLERANCE = 2e-5
"""Error of the layer's field over its largest value, before extrapolation, at which the steps are fine enough."""
HELD = 14
"""Numbers that are held for each step."""
_CHUNK = 1 << 12
_ROUNDING = 16 * float(np.finfo(float).eps)
_ROOT = float(np.sqrt(np.finfo(float).eps)) / 4


def leaking_slab(layers: Mapping[str, Layer], *, second: float) -> tuple[str, ...]:
    """Return the names of the layers with a leak, which are pieces of one slab."""
    slabs = leaking_slabs(layers)
    if len(slabs) > 1:
        listed = " and ".join(f"stack.{slab[0]}.leak" for slab in slabs)
        raise InputError(
            f"{listed}: only one layer of a stack may have a leak; give the others a material that conducts"
        )
    if slabs and second:
        raise InputError(
            f"stack.{slabs[0][0]}.leak: with a second electrode two layers would leak; use Grounded or Floating"
        )
    return slabs[0] if slabs else ()


def leaking_slabs(layers: Mapping[str, Layer]) -> list[tuple[str, ...]]:
    """Return the layers with a leak, pieces of one slab together."""
    leaking = {name for name, layer in layers.items() if layer.leak is not None}
    return [slab for slab in pieces(layers) if slab[0] in leaking] if leaking else []


def leaks(scenario: Scenario) -> bool:
    """Return whether a layer has a non-ohmic leak."""
    return any(layer.leak is not None for layer in scenario.stack.layers.values())


def refuse_leak(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a leaking layer."""
    layers = scenario.stack.layers
    name = next(iter(leaking_slab(layers, second=Surroundings.of(scenario).second)), None)
    refuse_gaps_of_a_law(scenario, name)
    refuse_behind_amplifier(scenario)
    if name is not None and scenario.time.settled:
        raise InputError(
            f"time.initial_state = PeriodicState: layer '{name}' leaks by {type(layers[name].leak).__name__}, which is"
            " non-ohmic, so its periodic state is not known beforehand. Start AtRest and evaluate a late period"
        )


def answer_with_leak(question: Question) -> Solution:
    """Compute the response of a stack with one leaking layer to a voltage or a current."""
    scenario, section = question.scenario, question.section
    layers, around = scenario.stack.layers, Surroundings.of(scenario)
    slab = leaking_slab(layers, second=around.second)
    leak = layers[slab[0]].leak
    assert leak is not None
    beside: dict[Key, Transfer] = {}
    for name in slab:  # one current density flows through all pieces
        if scenario.drive.quantity == "current":
            own = leak_alone(section, layers, name, area=around.area)
        else:
            own = leak_section(section, layers, name, area=around.area, element=around.element)
        for key, transfer in question.wanted(own).items():
            beside[key] = beside[key] + transfer if key in beside else transfer
    driven, control = question.wanted(section), FieldOf(slab[0])
    amplifier = scenario.circuit.amplifier
    if amplifier is not None:  # without limits it prescribes the plate's voltage, whatever leaks
        driven, beside["amplifier_current"] = amplified(driven, amplifier), beside["current"]
    return leaky_response(driven, beside, scenario.drive, question.times, leak=leak, control=control)


def leak_section(
    section: ModalSection, layers: dict[str, Layer], name: str, *, area: float, element: SeriesElement
) -> ModalSection:
    """Expand the response of a stack under voltage drive to a leak in parallel with one of its layers in modes.

    E_j T_j = z_j z_k/Z - [j = k] z_k for a leak in parallel with layer k. The poles are the zeros of Z and
    the nodes that several parts share; a pole at 0 is an interface that the leak charges. The response of
    layer k itself has residues of one sign: it is minus the impedance of layer k in parallel with all the
    others.
    """
    modes, place = section.modes, list(layers).index(name)
    driven, shared = modes.rates[: modes.driven], modes.rates[modes.driven :]
    rates = np.where(modes.rates == 0, INTEGRATING, modes.rates)
    into = _residues(modes.fields[place], driven) * layers[name].thickness  # of z_k/Z
    drops = into / _residues(modes.current_density, driven)  # z_k where Z is 0
    slabs = slabs_of(layers, section.debye)
    expanded = [slab_impedance(slab) for slab in slabs]
    own = np.array([_at(shared, *each) for each in expanded])
    others = np.delete(own, place, axis=0).sum(axis=0) + area * element.elastance * (shared == element.rate)
    fields, displacements = [], []
    for j, (slab, (nodes, residues)) in enumerate(zip(slabs, expanded, strict=True)):
        share = (-others if j == place else own[place]) / (own[place] + others)
        field = np.append(_residues(modes.fields[j], driven) * drops, own[j] * share / slab.thickness)
        fields.append(Transfer(rates=rates, gains=field / rates))
        bound = _at(shared, nodes, bound_residues(slab, nodes, residues)) * share
        displacement = np.append(_residues(modes.displacements[j], driven) * drops, bound)
        displacements.append(Transfer(rates=rates, gains=displacement / rates))
    sums = [float(np.sum(residues)) for _, residues in expanded]
    instantaneous = sums[place] / (sum(sums) + area * element.elastance) if element.resistance == 0 else 0.0
    current = Transfer(rates=rates, gains=np.append(into, 0 * shared) / rates, direct=instantaneous)
    nothing = np.zeros(len(slabs) + 1)
    answer = StackModes(rates, tuple(fields), tuple(displacements), current, modes.driven, nothing)
    return section_of(layers, section.debye, answer)


def _residues(transfer: Transfer, driven: Real) -> Real:
    return transfer.gains[: len(driven)] * driven


def _at(nodes: Real, rates: Real, residues: Real) -> Real:
    """Return the residues of a layer at some nodes, 0 where it has none."""
    return np.array([float(np.sum(residues[rates == node])) for node in nodes.tolist()])


def leak_alone(section: ModalSection, layers: dict[str, Layer], name: str, *, area: float) -> ModalSection:
    """Expand the response of a stack under current drive to a leak in parallel with one of its layers in modes."""
    modes, rates = section.modes, section.modes.rates
    fields, displacements = (
        tuple(
            Transfer(rates=rates, gains=each.gains * (-area if other == name else 0.0))
            for other, each in zip(layers, transfers, strict=True)
        )
        for transfers in (modes.fields, modes.displacements)
    )
    nothing = Transfer(rates=rates, gains=np.zeros(len(rates)))
    answer = StackModes(rates, fields, displacements, nothing, modes.driven, np.zeros(len(layers) + 1))
    return section_of(layers, section.debye, answer)


def leaky_response(
    driven: Mapping[Key, Transfer],
    leaking: Mapping[Key, Transfer],
    drive: Drive,
    time: Real,
    *,
    leak: Conduction,
    control: FieldOf,
) -> Solution:
    """Compute the response from rest of quantities that are linear in a drive and in one leak.

    `time` (n,) [s].

    Steps are halved until the error is below `TOLERANCE`.
    """
    field = driven[control], leaking[control]
    grid = step_grid(drive, time, *field, leak=leak)
    march = functools.partial(follow, *field, drive, leak=leak)
    grid, fine, coarse, error = halved(grid, march, LeakMarch.fields, order=2, tolerance=TOLERANCE)
    found = transient(driven, drive, time)
    finer, coarser = (Response(leaking, [march.flow]).at(time) for march in (fine, coarse))
    for name in leaking:
        found[name] = found[name] + finer[name] + (finer[name] - coarser[name]) / 3
    why = (
        f"layer '{control.layer}' leaks by {type(leak).__name__}, which is non-ohmic: linear modes and one nonlinear branch"
        f" from rest, {len(grid) - 1} steps; by halving them, the error of its field before extrapolation is {error:.1e} of"
        " its largest value"
    )
    return Solution(found=found, method=LEAK, reason=why, errors={"step_error": error}, steps=len(grid) - 1)


class LeakMarch(NamedTuple):
    """Field [V/m] and current density [A/m2] of the leaking layer, straight within each step."""

    field: Linear
    flow: Linear

    def fields(self) -> Real:
        """Return the field just before and just after the ends of the steps, shape (2, n) [V/m]."""
        return np.array([self.field.before, self.field.after])


def follow(driven: Transfer, leaking: Transfer, drive: Drive, grid: Real, *, leak: Conduction) -> LeakMarch:
    """Integrate the field of a leaking layer over given steps.

    `grid` (n,) [s].
    """
    free = transient({"field": driven}, drive, grid)["field"]
    jumps = driven.direct * jump_heights(drive, grid)
    active = leaking.gains != 0
    rates, gains = leaking.rates[active], leaking.gains[active]
    before, after = np.zeros((2, len(grid), 2))  # field and current density at the end of each step
    field, trend, state = float(free[0]), 0.0, np.zeros(len(rates))
    density = float(leak.current_density(field))
    after[0] = field, density
    repeats = drive.period or math.inf
    meter = Meter("the leaking layer", end=float(grid[-1]), repeats=repeats, held=HELD * len(grid))
    for begin in range(0, len(grid) - 1, _CHUNK):
        meter.count(float(grid[begin]))
        steps = np.diff(grid[begin : begin + _CHUNK + 1])
        decays, firsts, lasts = hold_weights(-np.outer(steps, rates))
        weights = -(lasts @ gains)
        for index, weight in enumerate(weights.tolist()):
            now = begin + index + 1
            state = decays[index] * state + firsts[index] * density
            known = float(free[now] - jumps[now] + gains @ state)
            last, size = field, float(steps[index])
            field = field_under_leak(leak, known=known, weight=weight, guess=last + trend * size)
            trend, density = (field - last) / size, float(leak.current_density(field))
            state = state + lasts[index] * density
            before[now] = field, density
            if jumps[now]:
                field = field + float(jumps[now])
                density = float(leak.current_density(field))
            after[now] = field, density
    return LeakMarch(*(Linear(grid, *each) for each in zip(before.T, after.T, strict=True)))


def field_under_leak(leak: Conduction, *, known: float, weight: float, guess: float | None = None) -> float:
    """Solve E + weight J(E) = known for the field E.

    Newton's method within a shrinking bracket.
    """
    low, high = sorted((0.0, known))
    field = known if guess is None else min(max(guess, low), high)
    for _ in range(200):
        excess = field + weight * float(leak.current_density(field)) - known
        low, high = (low, min(high, field)) if excess > 0 else (max(low, field), high)
        step = excess / (1 + weight * float(leak.slope(field)))
        if low == high:
            break
        inside = low <= field - step <= high
        field = field - step if inside else (low + high) / 2
        if abs(step) <= (_ROOT if inside else _ROUNDING) * abs(field):  # the next step is its square
            break
    return field
