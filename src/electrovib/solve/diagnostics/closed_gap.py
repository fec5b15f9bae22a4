"""Films while a ridge or sweat closes the gap: the voltage of the plate is then across the films alone.

A ridge or sweat closes the gap at a spot, and wet skin conducts: the films there have the voltage that the plate has elsewhere.
A film on the finger shares it with those of the plate.

Where a law declares the local gaps, a film beyond its strength is told with how much of the contact is so. The films at a place
and its gap are plates in series, across which the whole voltage is; a spot that touches has the field of the closed gap. The
limit of the closed gap stays the bound: this share allows nothing.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.contact.attraction import RoughAttraction
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.roughness import REACH, GaussianGaps, PullingSpots
from electrovib.physics.safety import BARE_ELECTRODE, film_diagnostic
from electrovib.physics.stack import Layer, in_one_piece, pieces
from electrovib.solve.rough_contact.solved import solved_contact
from electrovib.solve.stack.expand import reductions
from electrovib.solve.stack.modes import Slab, stack_modes

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.contact import Surface
    from electrovib.scenario import Scenario

CLOSE: Final = 1e-6
"""Relative change of the gap at which the contact under load and attraction is found."""
MOST_STEPS: Final = 1000
NARROW: Final = 1e-12
"""Gap [m] that counts as closed."""


def area_beyond(
    scenario: Scenario,
    field: Callable[[float], float],
    *,
    strength: float,
    voltage: float,
    electrical_thickness: float,
) -> tuple[float, str] | None:
    """Return the share of the contact area with a field above a strength [V/m], and by which law; None where none is declared.

    `field` [V/m] of the film at a local gap [m], falling with it; `voltage` [V] and `electrical_thickness` [m] of the films,
    from which the attraction follows that presses the surface closer.
    """
    if (found := _solved(scenario, voltage)) is not None:
        widest = float(found[-1])
        reach = _gap_at(field, strength, widest) if field(widest) <= strength else widest
        share = float(np.searchsorted(found, reach, side="right")) / found.size
        return share, "contact.surface, which is solved under load and attraction"
    gaps = scenario.force.gaps()
    law = f"{type(scenario.force).__name__}, whose gaps are declared and follow no attraction"
    if gaps is None:
        surface, load = scenario.contact.surface, scenario.load.normal_force
        if surface is None or not (surface.is_rough and load > 0):
            return None
        pressure = float(scenario.contact.mean_pressure(np.asarray(load)))
        attraction = RoughAttraction(
            voltage=voltage,
            electrical_thickness=electrical_thickness,
            surface=surface,
            spots=PullingSpots(),
        )
        gaps, may_shut = pressed_gaps(surface, attraction, pressure)
        law = f"{type(surface).__name__}, {surface.standing}, under load and attraction"
        if gaps is None:
            return 1.0, f"{law}, where the contact falls shut"
        if may_shut:
            law += " of a voltage that rises, and on all of it once the contact has fallen shut"
    widest = float(gaps.rms * (gaps.mean / gaps.rms + REACH) ** gaps.power)
    if not field(widest) <= strength:
        return 1.0, f"{law}; no gap keeps the voltage off the film"
    return float(gaps.share_up_to(_gap_at(field, strength, widest))), law


def _solved(scenario: Scenario, voltage: float) -> Real | None:
    """Return the gaps [m] in rising order of a contact that is solved; None where there is none, or it is not known so far."""
    try:
        known = solved_contact(scenario)
        return None if known is None else known.gaps(voltage)
    except ElectrovibError:
        return None


def pressed_gaps(
    surface: Surface, attraction: RoughAttraction, pressure: float
) -> tuple[GaussianGaps | None, bool]:
    """Return the gaps that a rising voltage reaches under a load [Pa], None if it shuts them, and whether they could be shut."""
    try:
        least = attraction.smallest_gap
        may_shut = pressure + attraction.pressure(least) > float(surface.pressure(np.asarray(least)))
        gap = float(surface.gap(np.asarray(pressure)))
        for _ in range(MOST_STEPS):
            if gap <= least:
                return None, may_shut
            borne = pressure + attraction.pressure(gap)
            before, gap = gap, float(surface.gap(np.asarray(borne)))
            if least < gap and before - gap <= CLOSE * before:
                return surface.gaps(borne), may_shut
    except (
        InputError
    ):  # a surface so soft that no distribution bears it counts as shut: a check does not end here
        return None, True
    return None, may_shut


def _gap_at(field: Callable[[float], float], strength: float, widest: float) -> float:
    """Return the gap [m] at which the field falls to a strength; 0 where that gap counts as closed."""
    from scipy.optimize import brentq

    if field(NARROW) <= strength:
        return 0.0
    return float(brentq(lambda gap: field(gap) - strength, NARROW, widest, rtol=1e-9))


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
