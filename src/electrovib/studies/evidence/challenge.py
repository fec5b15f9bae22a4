"""What the challenge says of a submission: skill, interval, width and rank beside the shipped laws, on each side of the split."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import TYPE_CHECKING

from electrovib.core.answer import Table
from electrovib.core.errors import ElectrovibError, refuse
from electrovib.studies.evidence.predicted import ModelPrediction, prediction, reason_of
from electrovib.studies.evidence.score import LEVEL
from electrovib.studies.evidence.split import HELD_OUT, SIDES, split
from electrovib.studies.evidence.standing import CommonSet, comparisons, several, shown_first

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.studies.evidence.measurement import Measurement
    from electrovib.studies.evidence.score import Score
    from electrovib.studies.evidence.submission import Submission


def submitted(
    found: Submission, name: str, measured: Measurement, *, n: int, seed: int
) -> tuple[ModelPrediction | None, str]:
    """Compute what a submission predicts of a measurement, or the reason why it cannot."""
    if measured.group in found.stated.made_from or found.model in measured.made:
        return None, "it was made from these numbers"
    try:
        own = found.applied(name, measured)
        one = prediction(own, found.model, dict(found.stated.law), n=n, seed=seed)
    except ElectrovibError as error:
        return None, reason_of(error)
    return ModelPrediction(found.name, one.values, one.narrow, one.wide), ""


def refuse_idle(
    entered: Sequence[Submission], scores: Sequence[Score], refused: Mapping[str, Mapping[str, str]]
) -> None:
    """Refuse submissions that predict no measurement, with every reason once."""
    known = {each.model for each in scores}
    problems = {
        f"{law.name} predicts no measurement: {why[law.name]}": None
        for law in entered
        for why in refused.values()
        if law.name not in known and law.name in why
    }
    refuse([*problems])


def sets_of(found: Submission, scores: Sequence[Score], nulls: Sequence[Score]) -> dict[str, list[CommonSet]]:
    """Return, for each side, the common sets on which the submission stands, the one with the most laws first."""
    sides: dict[str, list[CommonSet]] = {}
    for side in SIDES:
        own = [each for each in scores if split().side_of(each.group) == side]
        known = comparisons(found.stated.judges, own, nulls) if own else ()
        sides[side] = [each for each in known if found.name in {one.model for one in each.standings}]
    return sides


def sentences(found: Submission, sides: Mapping[str, list[CommonSet]]) -> list[str]:
    """Say how a submission stands on one common set of each side, that of `shown_first`."""
    said = []
    for side, sets in sides.items():
        which = f"{found.name} on groups that are {side}"
        if not sets:
            said.append(f"{which}: it predicts none of them{' and has no rank' * (side == HELD_OUT)}.")
            continue
        shown = shown_first(sets)
        row = dict(zip(HEADINGS, _row(found, side, shown), strict=True))
        said.append(
            f"{which}, {several(shown.numbers, 'number')} of {several(shown.groups, 'group')}: skill {row['skill']}"
            f" ({row[INTERVAL]}) over '{row['null model']}', width {row['width']} decades, rank {row['rank']}."
        )
    return said


INTERVAL = f"{100 * LEVEL:.0f} % of it"
HEADINGS = (
    "side",
    "numbers",
    "groups",
    "skill",
    INTERVAL,
    "null model",
    "width",
    "within 90 %",
    "rank",
    "the best",
)


def table(found: Submission, sides: Mapping[str, list[CommonSet]]) -> Table:
    """List how a submission stands on every common set of each side."""
    rows = tuple(_row(found, side, each) for side, sets in sides.items() for each in sets)
    title = f"Challenge {split().version}: {found.name}, {found.stated.title} ({found.stated.authors})"
    return Table(title, HEADINGS, rows, looks=dict.fromkeys((1, 2, 3, 4, 6, 7, 8), "number"))


def _row(found: Submission, side: str, each: CommonSet) -> tuple[str, ...]:
    (own,) = (one for one in each.standings if one.model == found.name)
    rank = 1 + sum(one.skill > own.skill for one in each.standings)
    interval = f"{own.low:.2f} to {own.high:.2f}" if math.isfinite(own.low) else "no interval from one group"
    return (
        side,
        str(each.numbers),
        str(each.groups),
        f"{own.skill:.2f}",
        interval,
        each.null,
        f"{own.width:.2f}",
        f"{100 * own.covered:.0f} %",
        f"{rank} of {len(each.standings)}",
        each.standings[0].model,
    )
