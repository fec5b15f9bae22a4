"""What this group measured on fingers: the change of the lateral force in 2014, its decay in 2013, and which laws reach them."""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.answer import Curve, Panel, Table
from electrovib.papers.vezzoli_2014 import compute
from electrovib.papers.vezzoli_2014.compute import panel, row
from electrovib.papers.vezzoli_2014.figures import span
from electrovib.papers.vezzoli_2014.values import FORCE_MEASURED
from electrovib.studies.evidence.standing import LEVEL, Score, judge
from electrovib.studies.reproduction import Row, overlap

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.studies.evidence import Measurement
    from electrovib.studies.evidence.predicted import ModelPrediction

OWN: Final = {"law_1": "Vezzoli2014Causal", "gap": "MaxwellStressInGap"}
"""Names in rows of the two laws that every number of the paper is compared under."""
PRINTED: Final = {"swing": FORCE_MEASURED, "decay": (0.34, 0.4)}
"""What is printed, in SI; 6 ms to one digit leave 34 to 40 % after 6 ms."""
SHORT: Final = {"swing": "change of the lateral force", "decay": "share of the force left after 6 ms"}
DRAWN: Final = 5
"""Laws that a figure shows, the best ones; its file has all."""


@functools.cache
def judged() -> dict[str, list[tuple[ModelPrediction, Score]]]:
    """Return what every law predicts of each measurement over what is not printed, the best first."""
    from electrovib.studies.evidence.predicted import predict

    found = {}
    for name, each in _measured().items():
        both = [(one, judge(name, each, one)) for one in predict(each)[0]]
        found[name] = sorted(both, key=lambda one: -one[1].score)
    return found


def _measured() -> Mapping[str, Measurement]:
    """Return what the publication measured."""
    from electrovib.studies.evidence.files import of_publication

    return of_publication("vezzoli_2014")


def rows() -> tuple[Row, ...]:
    """Compare both measured numbers with the intervals of two laws over what the paper does not print."""
    found = []
    for name, measured in _measured().items():
        laws = judged()[name]
        bands = {one.model: score.band[[0, -1], 0].tolist() for one, score in laws}
        reached = [one.model for one, _ in laws if overlap(PRINTED[name], ends(one))]
        words: dict[str, Any] = {
            "level": 100 * LEVEL,
            "count": len(laws),
            "reached": ", ".join(reached),
            "more": measured.note,
        }
        found += [row(f"measured_{name}_{short}", bands[law], **words) for short, law in OWN.items()]
    return tuple(found)


def ends(drawn: ModelPrediction) -> tuple[float, float]:
    """Return the least and the largest value of a law over all draws, which an end of a 90 % interval depends on less."""
    return float(drawn.values.min()), float(drawn.values.max())


def table() -> Table:
    """List every law on both measurements."""
    cells = [
        (
            SHORT[name],
            one.model,
            f"{score.band[1, 0]:.3g}",
            f"{score.band[0, 0]:.3g} to {score.band[-1, 0]:.3g}",
            f"{score.ratio:.2g}",
            "yes" if score.covered == 1 else "no",
        )
        for name, found in judged().items()
        for one, score in found
    ]
    return replace(compute.table("measured_by_law", cells), looks=dict.fromkeys(range(2, 5), "number"))


def panels() -> tuple[Panel, ...]:
    """Draw for each measurement the share of the draws below a value, for every law, beside the measured range."""
    laws, found = [one.model for one, _ in judged()["swing"]], []
    for name, printed in PRINTED.items():
        curves = [span("measured", np.array(printed), 0.0, 1.0)]
        for one, _ in judged()[name]:
            x, look = np.sort(one.values[:, 0]), laws.index(one.model)
            y = (np.arange(x.size) + 0.5) / x.size
            curves.append(Curve(label=one.model, x=x, y=y, look=look, drawn=look < DRAWN))
        found.append(panel(f"measured_{name}", *curves))
    return tuple(found)
