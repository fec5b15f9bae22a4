"""The evidence as an answer: failures first, the table of laws, and a figure for each measurement."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Panel, Table
from electrovib.data.marks import Form, csv_text
from electrovib.studies.evidence.measurement import HOW, Measurement
from electrovib.studies.evidence.score import IGNORANT, LEVEL, Score, standings

WORST: Final = 5
"""Failures that are listed."""
BEST: Final = 3
"""Laws of which a figure shows the bands."""
USUAL: Final = "EffectiveMedium"
"""The law that most texts use, which every figure shows where it can be computed."""
REMARK: Final = (
    "The score is the mean logarithm of the predictive density of the logarithm of a value; a prediction that knows nothing"
    f" within twelve decades has {IGNORANT:.1f}, and a higher score is better. The shape is scored with one common factor left"
    " free in each measurement. Every group of people who measured counts once."
)


@dataclass(frozen=True, kw_only=True, repr=False)
class Evidence(Answer):
    """Every candidate on every measurement that it can predict.

    - `measured`: the measurements by name.
    - `scores`: one for each candidate and measurement; `refused`: measurement to candidate to the reason why it
      cannot predict it.
    - `n`, `seed`: draws of what was not printed.
    """

    measured: Mapping[str, Measurement]
    scores: tuple[Score, ...]
    refused: Mapping[str, Mapping[str, str]]
    n: int
    seed: int

    FILES: ClassVar = {"laws.csv": Form.TABLE, "measurements.csv": Form.TABLE}

    @property
    def document(self) -> Document:
        """Failures, laws, measurements, and a figure for each."""
        return Document(
            title=f"Evidence: {len(self.measured)} measurements of {len(self._groups)} groups",
            sentences=self._sentences,
            numbers=[self._laws],
            figures=[figure(name, each, self.of(name)) for name, each in self.measured.items()],
            tables=[self._failures, self._all, self._not_predicted],
            remarks=[REMARK, f"{self.n} draws of what was not printed, seed {self.seed}."],
            references=list(dict.fromkeys(each.source for each in self.measured.values())),
        )

    def of(self, name: str) -> list[Score]:
        """Return the scores of one measurement, the best first."""
        return sorted((each for each in self.scores if each.measurement == name), key=lambda each: -each.score)

    @property
    def failures(self) -> list[Score]:
        """The best candidate of each measurement that does not cover it, the worst first."""
        best = [found[0] for name in self.measured if (found := self.of(name))]
        return sorted((each for each in best if each.covered < 1), key=lambda each: each.score)

    @property
    def _groups(self) -> set[str]:
        return {each.group for each in self.measured.values()}

    @property
    def _sentences(self) -> list[str]:
        points = sum(len(each.values) for each in self.measured.values())
        of = {
            how: sum(len(each.values) for each in self.measured.values() if each.how == how) for how in HOW
        }
        counts = ", ".join(f"{count} {how}" for how, count in of.items() if count)
        failed = self.failures
        said = [
            f"No law reaches {len(failed)} of the {len(self.measured)} measurements in all of their points."
            if failed
            else "Every measurement is reached by some law."
        ]
        said += [self._failure(each) for each in failed[:WORST]]
        return [*said, f"{points} numbers: {counts}."]

    def _failure(self, each: Score) -> str:
        of = self.measured[each.measurement]
        return (
            f"{each.measurement} ({of.title}): the best, {each.model}, gives {each.ratio:.2g} of what was measured"
            f" ({each.low:.2g} to {each.high:.2g}) and covers {100 * each.covered:.0f} % of {_points(len(of.values))}."
        )

    @property
    def _laws(self) -> Table:
        rows = tuple(
            (
                each.model,
                f"{each.groups}",
                f"{each.points}",
                f"{100 * each.covered:.0f} %",
                f"{each.ratio:.2g}",
                f"{each.off:.3g}",
                _number(each.score),
                _number(each.shape),
            )
            for each in standings(self.scores)
        )
        headings = (
            *("law or model", "groups", "numbers", f"within {100 * LEVEL:.0f} %", "predicted/measured"),
            *("typical factor", "score", "shape"),
        )
        return Table(
            "Laws and models, the best first",
            headings,
            rows,
            looks=dict.fromkeys(range(1, len(headings)), "number"),
        )

    @property
    def _failures(self) -> Table:
        rows = tuple((each.measurement, each.model, self._failure(each)) for each in self.failures)
        return Table("Measurements that the best candidate does not cover", ("measurement", "best", ""), rows)

    @property
    def _all(self) -> Table:
        rows = []
        for name, each in self.measured.items():
            found = self.of(name)
            best = f"{found[0].model} ({_number(found[0].score)})" if found else "none"
            rows.append(
                (
                    name,
                    each.title,
                    each.on,
                    each.group,
                    str(len(each.values)),
                    f"{each.how}, {each.status}",
                    f"{100 * max(each.spread):.2g} %, {each.spread_of}",
                    best,
                    each.note,
                )
            )
        headings = (
            *("measurement", "what", "on", "group", "numbers", "how it came here", "largest spread", "best"),
            "note",
        )
        return Table("Measurements", headings, tuple(rows))

    @property
    def _not_predicted(self) -> Table:
        rows = tuple(
            (model, name, why) for name, reasons in self.refused.items() for model, why in reasons.items()
        )
        return Table("Cannot predict", ("law or model", "measurement", "why"), rows, folded=True)

    def content(self, name: str) -> str:
        """Write the standings of the laws, or every score, as CSV."""
        if name == "laws.csv":
            numbers = ("groups", "points", "covered", "ratio", "off", "score", "shape")
            rows = [[each.model, *(getattr(each, of) for of in numbers)] for each in standings(self.scores)]
            return csv_text(["model", *numbers], rows)
        if name == "measurements.csv":
            numbers = ("ratio", "low", "high", "covered", "score", "shape")
            rows = [
                [each.measurement, each.group, each.model, *(getattr(each, of) for of in numbers)]
                for each in self.scores
            ]
            return csv_text(["measurement", "group", "model", *numbers], rows)
        return super().content(name)  # type: ignore[return-value]


def _quantity(measured: Measurement) -> str:
    if callable(measured.quantity):
        return "value"
    return f"{measured.quantity} / {measured.per}" if measured.per else measured.quantity


def _points(count: int) -> str:
    return "its value" if count == 1 else f"its {count} values"


def _number(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def figure(name: str, measured: Measurement, scores: list[Score]) -> Panel:
    """Draw the measured points, and the bands of the best candidates and of the usual law."""
    shown = [*scores[:BEST], *(each for each in scores[BEST:] if each.model == USUAL)]
    x = measured.points if measured.over else np.arange(1.0, len(measured.values) + 1)
    wide = len(x) > 1
    curves = []
    for look, each in enumerate(shown):
        low, middle, high = each.band
        if wide:
            curves.append(Curve(label=f"{each.model}, 90 %", x=x, y=low, upper=high, kind="band", look=look))
        curves.append(
            Curve(label=each.model, x=x, y=middle, look=look, kind="line" if wide else "points")
        )
    values, spread = np.array(measured.values), np.array(measured.spread)
    curves += [
        Curve(label="measured", x=x, y=values, kind="points", look=REFERENCE),
        Curve(label="measured, plus and minus the spread", x=x, y=values * np.exp(spread), kind="points", look=REFERENCE, drawn=False),
        Curve(label="", x=x, y=values * np.exp(-spread), kind="points", look=REFERENCE, drawn=False),
    ]  # fmt: skip
    over, unit = measured.axis
    return Panel(
        id=name.replace("/", "_"),
        title=f"{measured.title} ({measured.group})",
        caption=" ".join(
            filter(None, (f"{measured.how.capitalize()}, {measured.status}: {measured.source}.", measured.note))
        ),
        x=(over or "number", unit),
        y=(_quantity(measured), measured.unit),
        curves=tuple(curves),
        log_x=bool(wide and x[0] > 0 and x[-1] / x[0] > 20),
        log_y=True,
    )
