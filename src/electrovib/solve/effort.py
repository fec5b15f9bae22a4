"""Estimated computing time and memory of a run: output times, corners and cycles of the drive, steps, readings."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import Work, refuse_beyond
from electrovib.physics.drive.parts import Chirped, Smooth
from electrovib.physics.force import EffectiveMedium
from electrovib.solve.choice import chosen
from electrovib.solve.costs import (
    AMPLITUDE_OF_MODE,
    BRISTLE_STEP,
    CORNER,
    FEWER_SAMPLES,
    PIECE,
    SAMPLE,
    SAMPLE_OF_MODE,
    SHORTER,
    SMOOTH_STEP,
)
from electrovib.solve.diagnostics.evaluation_times import count_evaluation_times
from electrovib.solve.electrics.formulas import RADIANS_PER_STEP
from electrovib.solve.mechanics.between import KNOTS
from electrovib.solve.mechanics.mechanical import slowest_rates
from electrovib.solve.mechanics.response import FORGOTTEN, MOST

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part
    from electrovib.scenario import Scenario

BYTES: Final = 8
SIGNALS: Final = 24
"""Numbers stored for each output time, apart from those of the layers."""
SIGNALS_OF_LAYER: Final = 14
NUMBERS_AT_CORNER: Final = 14
NUMBERS_AT_PIECE: Final = 30
PIECES_IN_CYCLE: Final = 120
PIECES_AT_CORNER: Final = 150
MODES_OF_LAYER: Final = 2
MODES_OF_DISPERSION: Final = 16
NODES_OF_ROOT: Final = 100
"""Relaxations that represent the root of an effective permittivity, for each relaxation of the material."""
PASSES: Final = 4
"""Evaluations of a drive that is a formula: response, times between outputs, error of the materials, current."""
PLACES: Final = 120
"""Places of the film under a sliding finger, each of which takes as long as a stack."""


def refuse_large(scenario: Scenario, times: Real | None = None) -> None:
    """Refuse a run that would exceed the budget, before anything is computed.

    `times` (n,) [s].
    """
    refuse_beyond(works(scenario, times))


def last_time(scenario: Scenario, times: Real | None = None) -> float:
    """Return the last output time.

    `times` (n,) [s].
    """
    return (scenario.time.duration or scenario.drive.duration) if times is None else float(times[-1])


def works(scenario: Scenario, times: Real | None = None) -> list[Work]:
    """Return estimates of the parts of a run.

    `times` (n,) [s].
    """
    grid, drive = scenario.time, scenario.drive
    samples = grid.count(drive) if times is None else len(times)
    end = last_time(scenario, times)
    corners = drive.count_corners(end)
    between = count_evaluation_times(drive, end=end, settled=scenario.time.settled)
    time = samples * (SAMPLE + SAMPLE_OF_MODE * _modes(scenario))
    time += samples * AMPLITUDE_OF_MODE * _modes_of_law(scenario)
    time += between * (SAMPLE + SAMPLE_OF_MODE * _modes(scenario))
    held: float = (samples + between) * BYTES * (SIGNALS + SIGNALS_OF_LAYER * len(scenario.stack.layers))
    if scenario.motion.renews_film:
        asked_again = 4 * KNOTS / (samples + between) if _is_followed(scenario) else 0.0
        time, held = PLACES * time * (1 + asked_again), PLACES * held * (1 + asked_again) / 2
    found = [
        Work(
            what=f"{samples:.3g} output times and {between:.3g} evaluation times between them",
            time=time,
            memory=held,
            remedy=FEWER_SAMPLES if samples > between else SHORTER,
        ),
        Work(
            what=f"{corners:.3g} corners of the drive up to {end:.6g} s",
            time=corners * CORNER,
            memory=corners * BYTES * NUMBERS_AT_CORNER,
            remedy=_less(scenario),
        ),
    ]
    marched = _marched(scenario, end, samples, corners)
    return [*found, *marched, *_formulas(scenario, end), *_mechanics(scenario, end, samples, corners)]


def _less(scenario: Scenario) -> str:
    """Return the remedy for a drive with too many corners."""
    period = scenario.drive.period
    if period is None or scenario.time.settled or chosen(scenario).method.is_marched:
        return SHORTER
    return (
        f"{SHORTER}, or compute one period of the periodic state: time.duration = {period:.6g} with"
        ' time.initial_state = { model = "PeriodicState" }'
    )


def _modes(scenario: Scenario) -> int:
    """Return the approximate number of relaxations of the stack."""
    materials = [layer.material for layer in scenario.stack.layers.values()]
    dispersive = sum(material.debye() is None for material in materials)
    return MODES_OF_LAYER * len(materials) + MODES_OF_DISPERSION * dispersive


def _modes_of_law(scenario: Scenario) -> int:
    """Return the approximate number of further relaxations of the force law."""
    filters = scenario.force.evaluation_surface == EffectiveMedium.evaluation_surface
    disperses = any(layer.material.debye() is None for layer in scenario.stack.layers.values())
    return _modes(scenario) * NODES_OF_ROOT if filters and disperses else 0


def _marched(scenario: Scenario, end: float, samples: int, corners: int) -> list[Work]:
    """Return the estimated work of a time-stepping solver."""
    march = chosen(scenario).method.march
    if march is None:
        return []
    steps = (
        march.at_corner * (corners + 1) + march.in_cycle * _cycles(scenario, end) + march.for_sample * samples
    )
    what = f"steps of {march.name} up to {end:.6g} s"
    return [_stepped(what, steps, each=march.step(_modes(scenario)), numbers=march.numbers)]


def _stepped(what: str, steps: float, *, each: float, numbers: int) -> Work:
    """Return the work of so many steps, with the time [s] and the stored numbers of each."""
    time, memory = steps * each, steps * BYTES * numbers
    return Work(what=f"about {steps:.2g} {what}", time=time, memory=memory, remedy=SHORTER)


def _formulas(scenario: Scenario, end: float) -> list[Work]:
    """Return the estimated work of drives that are formulas, whose cycles are all stepped through."""
    found = []
    for part in scenario.drive.parts():
        if isinstance(part, Smooth) and not isinstance(part, Chirped):
            steps = _on(part, end) * part.highest_frequency * 2 * math.pi / RADIANS_PER_STEP
            what = f"steps through the formula of the drive up to {end:.6g} s"
            found.append(_stepped(what, steps, each=PASSES * SMOOTH_STEP, numbers=PASSES))
    return found


def _on(part: Part, end: float) -> float:
    """Return the duration of a part of a drive up to an end [s]."""
    return max(min(part.stop, end) - max(part.start, 0.0), 0.0)


def _is_followed(scenario: Scenario) -> bool:
    """Return whether a mechanical element with memory follows the attraction."""
    slides = scenario.friction.deflects
    return slides or scenario.rig is not None or bool(slowest_rates(scenario))


def _mechanics(scenario: Scenario, end: float, samples: int, corners: int) -> list[Work]:
    """Return the estimated work of friction, skin and sensors behind the attraction."""
    if not _is_followed(scenario):
        return []
    slides, share, modes = scenario.friction.deflects, 1.0, _modes(scenario)
    if not slides and scenario.rig is None:
        share = min(1.0, samples * FORGOTTEN / (min(slowest_rates(scenario)) * end)) if end else 1.0
    cycles = end * scenario.drive.highest_frequency  # also where a fast part of the drive is off
    pieces = share * (PIECES_IN_CYCLE * cycles + PIECES_AT_CORNER * corners) + samples
    each = PIECE + SAMPLE_OF_MODE / 4 * modes + AMPLITUDE_OF_MODE * _modes_of_law(scenario)
    each += BRISTLE_STEP if slides else 0.0
    what = f"pieces of time in which the friction is computed up to {end:.6g} s"
    whole = _stepped(what, pieces, each=each, numbers=NUMBERS_AT_PIECE)
    return [replace(whole, memory=min(pieces, MOST) * BYTES * NUMBERS_AT_PIECE)]


def _cycles(scenario: Scenario, end: float) -> float:
    """Return the number of cycles of everything that oscillates, up to an end [s]."""
    found = sum(_on(part, end) * part.highest_frequency for part in scenario.drive.parts())
    moved = scenario.motion.moved_gap
    return found + (end * moved.fastest if moved is not None else 0.0)
