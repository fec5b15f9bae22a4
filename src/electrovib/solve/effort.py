"""What a run computes and holds, as far as it is counted before it begins: times, corners and cycles of the drive."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import Work, refuse_beyond
from electrovib.physics.drive.parts import Chirped, Smooth
from electrovib.solve.choice import chosen
from electrovib.solve.diagnostics.peaks import count_evaluation_times, frequency_beside
from electrovib.solve.electrics.formulas import RADIANS_PER_STEP
from electrovib.solve.mechanics.mechanical import slowest_rates
from electrovib.solve.mechanics.response import FORGOTTEN, MOST
from electrovib.solve.meter import SHORTER

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part
    from electrovib.scenario import Scenario

SIGNALS: Final = 24
"""Numbers for each output time, apart from those of the layers."""
SIGNALS_OF_LAYER: Final = 14
PLACES: Final = 120
"""Numbers for each of them under a finger that slides over fresh film, whose places are computed one by one."""
NUMBERS_AT_CORNER: Final = 14
NUMBERS_IN_STEP: Final = 4
"""Numbers for each step through a drive that is a formula."""
NUMBERS_AT_PIECE: Final = 30
PIECES_IN_CYCLE: Final = 120
PIECES_AT_CORNER: Final = 150
"""Pieces of time of the mechanics in a cycle of the drive and after a corner of it."""


def refuse_large(scenario: Scenario, times: Real | None = None) -> None:
    """Refuse a run whose counted parts exceed the budget, before anything is computed.

    `times` (n,) [s].
    """
    refuse_beyond(counted(scenario, times))


def last_time(scenario: Scenario, times: Real | None = None) -> float:
    """Return the last output time.

    `times` (n,) [s].
    """
    return (scenario.time.duration or scenario.drive.duration) if times is None else float(times[-1])


def counted(scenario: Scenario, times: Real | None = None) -> list[Work]:
    """Return the parts of a run that are counted before it.

    `times` (n,) [s].
    """
    grid, drive = scenario.time, scenario.drive
    samples = grid.count(drive) if times is None else len(times)
    end = last_time(scenario, times)
    parts, moved = drive.parts(), scenario.motion.moved_gap
    corners, cycles = drive.count_corners(end), _cycles(parts, end)
    cycles += end * moved.fastest if moved is not None else 0.0
    between = count_evaluation_times(drive, end=end, settled=grid.settled, beside=frequency_beside(scenario))
    held = (samples + between) * (SIGNALS + SIGNALS_OF_LAYER * len(scenario.stack.layers))
    what = f"{samples:.3g} output times and {between:.3g} evaluation times between them"
    remedy = "ask for fewer time.samples" if samples > between else SHORTER
    places = PLACES if scenario.motion.renews_film else 1
    found = [Work.counted(what, places * held, held=held, remedy=remedy)]
    what = f"{corners:.3g} corners of the drive up to {end:.6g} s"
    found.append(Work.counted(what, corners * NUMBERS_AT_CORNER, remedy=_less(scenario)))
    if (method := chosen(scenario).method).is_marched:
        what = f"the steps of the solver '{method.name}' in {corners + cycles:.2g} corners and cycles up to {end:.6g} s"
        numbers = method.numbers * (corners + cycles + 1)
        found.append(Work.counted(what, numbers, held=numbers if method.holds_steps else 0, remedy=SHORTER))
    formulas = [part for part in parts if isinstance(part, Smooth) and not isinstance(part, Chirped)]
    if steps := _cycles(formulas, end) * 2 * math.pi / RADIANS_PER_STEP:
        what = f"{steps:.2g} steps through the formula of the drive up to {end:.6g} s"
        found.append(Work.counted(what, NUMBERS_IN_STEP * steps, remedy=SHORTER))
    return [*found, *_mechanics(scenario, end, samples, corners)]


def _less(scenario: Scenario) -> str:
    """Return the remedy for a drive with too many corners."""
    period = scenario.drive.period
    if period is None or scenario.time.settled or chosen(scenario).method.is_marched:
        return SHORTER
    return (
        f"{SHORTER}, or compute one period of the periodic state: time.duration = {period:.6g} with"
        ' time.initial_state = { model = "PeriodicState" }'
    )


def _mechanics(scenario: Scenario, end: float, samples: int, corners: int) -> list[Work]:
    """Return the work of friction, skin and sensors that follow the attraction with a memory."""
    slides, rates = scenario.friction.deflects, slowest_rates(scenario)
    if not (slides or scenario.rig is not None or rates):
        return []
    share = 1.0
    if rates and end and not slides and scenario.rig is None:
        share = min(1.0, samples * FORGOTTEN / (min(rates) * end))
    cycles = end * scenario.drive.highest_frequency  # also where a fast part of the drive is off
    pieces = share * (PIECES_IN_CYCLE * cycles + PIECES_AT_CORNER * corners) + samples
    what = f"about {pieces:.2g} pieces of time in which the friction is computed up to {end:.6g} s"
    held = NUMBERS_AT_PIECE * min(pieces, MOST)
    return [Work.counted(what, NUMBERS_AT_PIECE * pieces, held=held, remedy=SHORTER)]


def _cycles(parts: Iterable[Part], end: float) -> float:
    """Return the number of cycles of oscillations, up to an end [s]."""
    on = ((max(min(part.stop, end) - max(part.start, 0.0), 0.0), part.highest_frequency) for part in parts)
    return sum(length * frequency for length, frequency in on)
