"""Films while a ridge or sweat closes the gap: the voltage of the plate is then across the films alone.

A ridge or sweat closes the gap at a spot, and wet skin conducts: the films there have the voltage that the plate has elsewhere.
A film on the finger shares it with those of the plate.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.safety import BARE_ELECTRODE, film_diagnostic
from electrovib.physics.stack import Layer, in_one_piece, pieces
from electrovib.solve.diagnostics.area_beyond import area_beyond
from electrovib.solve.stack.expand import reductions
from electrovib.solve.stack.modes import Slab, stack_modes

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from electrovib.scenario import Scenario

AIR: Final = Layer(thickness=1e-6)
"""The gap where a stack has none."""
PERMITTIVITY_AT: Final = 1e3
"""Frequency [Hz] of the permittivities from which the attraction of a rough contact follows."""


def with_closed_gap(
    scenario: Scenario, films: Collection[str], supplied: tuple[float, float]
) -> list[Diagnostic]:
    """Return the diagnostics of films with the gap closed, as far as a strength is known to compare with.

    `supplied`: lowest and highest voltage between plate and finger [V].
    """
    roles, layers = scenario.stack.roles, scenario.stack.layers
    closed = "with the finger a conductor"
    if scenario.stack.gap_name is not None:
        closed = "with the gap closed by a ridge or by sweat"
    if "plate" not in roles.values():
        text = f"the plate has no film: {closed} only resistances limit the current through the finger"
        return [Diagnostic(BARE_ELECTRODE, "unknown", text)]
    found: list[Diagnostic] = []
    for role in ("plate", "finger"):
        series = {name: layers[name] for name in layers if roles[name] == "plate" or name in films}
        series = {name: layer for name, layer in series.items() if roles[name] in {"plate", role}}
        slabs, whole = pieces(series), in_one_piece(series)
        last = {slab[-1]: whole[slab[-1]] for slab in slabs}
        debye = {}
        if len(last) > 1:
            debye = {name: each.debye for name, each in reductions(scenario).items()}
        fields = largest_fields(last, debye, lowest=supplied[0], highest=supplied[1])
        found += [
            _with_area(
                scenario,
                film_diagnostic(name, whole[name], field=fields[slab[-1]], closed=closed),
                slab[-1],
                last,
                supplied,
            )
            for slab in slabs
            for name in slab
            if roles[name] == role and name in films
        ]
    return [each for each in found if each.limit is not None]


def _with_area(
    scenario: Scenario,
    judged: Diagnostic,
    film: str,
    series: Mapping[str, Layer],
    supplied: tuple[float, float],
) -> Diagnostic:
    """Add to a `film` of a `series` that is beyond its strength how much of the contact is so by its declared roughness."""
    strength, reached = judged.limit, judged.value
    if strength is None or reached is None or not reached > strength:
        return judged
    name = scenario.stack.gap_name or "gap"
    gap = scenario.stack.layers.get(name, AIR)
    debye = {name: DebyeSum(1.0, (), ())} | {
        each: found.debye for each, found in reductions(scenario).items()
    }

    def field(width: float) -> float:
        layers = {**series, name: gap.model_copy(update={"thickness": width})}
        return largest_fields(layers, debye, lowest=supplied[0], highest=supplied[1])[film]

    over = {each: layer.thickness / _permittivity(layer) for each, layer in series.items()}
    found = area_beyond(
        scenario,
        field,
        strength=strength,
        voltage=max(-supplied[0], supplied[1]),
        electrical_thickness=_permittivity(gap) * sum(over.values()),
    )
    if found is None:
        return judged
    area, law = found
    text = f"{judged.text}; above it on {100 * area:.3g} % of the contact area by {law}"
    return replace(judged, text=text, area=area)


def _permittivity(layer: Layer) -> float:
    return float(layer.material.bound_permittivity(np.array(PERMITTIVITY_AT)).real)


def largest_fields(
    films: Mapping[str, Layer], debye: Mapping[str, DebyeSum], *, lowest: float, highest: float
) -> dict[str, float]:
    """Bound the absolute fields of films in series, from the plate to the finger, under any voltage of a range with 0 in it.

    Parameters
    ----------
    films : mapping of str to Layer
        The films by name.
    debye : mapping of str to DebyeSum
        Bound permittivity of each; of a single film it is not needed.
    lowest, highest : float
        Range of the voltage [V].

    Returns
    -------
    fields : dict of str to float
        Of each film [V/m]; NaN where no bound is known: of a film that leaks, beside several, charge or relaxation.

    Notes
    -----
    A single film has V/T, whatever it is made of. The field of one of several is direct V(t) plus, for each relaxation mode,
    its gain times a mean of earlier voltages, which lies in the same range: each term is bounded by the end of the range that
    its sign selects. Where one of them conducts, each has the whole voltage at least: how far another one holds it depends on
    conductivities that are hardly known. Of two, a leak moves the voltage of one towards a value between 0 and V, so that it
    never exceeds the larger of max |V| and its share of highest - lowest by capacitance. Initial charge between films adds at
    most the sum of the amplitudes that it excites; that towards the conducting finger is neutralised.
    """
    peak = max(-lowest, highest)
    if len(films) == 1:
        return {name: peak / each.thickness for name, each in films.items()}
    leaks = any(each.leak is not None for each in films.values())
    conducts = leaks or any(each.material.conductivity for each in films.values())
    slabs = [
        Slab(each.thickness, debye[name], each.material.conductivity, each.initial_charge)
        for name, each in films.items()
    ]
    if leaks and (len(slabs) > 2 or any(each.charge or each.debye.strengths for each in slabs)):
        return dict.fromkeys(films, math.nan)
    found = {}
    for name, field in zip(films, stack_modes(slabs, area=1.0, element=SeriesElement()).fields, strict=True):
        terms = np.append(field.gains, field.direct)
        low, high = np.minimum(terms * lowest, terms * highest), np.maximum(terms * lowest, terms * highest)
        free = float(np.sum(np.abs(field.free)))
        reached = max(-float(np.sum(low)), float(np.sum(high))) + free
        if leaks:
            reached = float(np.sum(field.direct)) * (highest - lowest)
        found[name] = max(reached, peak / films[name].thickness) if conducts else reached
    return found
