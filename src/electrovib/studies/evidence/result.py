"""The evidence as an answer: failures first, the table of laws, and a figure for each measurement."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Drawing, Panel, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.paths import words_at
from electrovib.data.marks import Form, csv_text
from electrovib.studies.evidence.measurement import HOW, Measurement
from electrovib.studies.evidence.score import IGNORANT, LEVEL, ODDS, Score, Standing, standings

WORST: Final = 5
"""Groups of people whose worst failure is stated."""
BEST: Final = 3
"""Laws of which a figure shows the bands."""
USUAL: Final = "EffectiveMedium"
"""The law that most texts use, which every figure shows where it can be computed."""
REMARK: Final = (
    "The score is the mean logarithm of the predictive density of the logarithm of a value; a prediction that knows nothing"
    f" within twelve decades has {IGNORANT:.1f}, and a higher score is better. The shape is scored with one common factor left"
    " free in each measurement. The odds are those against each rival on the measurements that both predict, at most"
    f" {ODDS:g} to 1, their geometric mean; beaten by counts the rivals with these odds against it. Every group of people who"
    " measured counts once."
)


@dataclass(frozen=True, kw_only=True, repr=False)
class Evidence(Answer):
    """Every candidate on every measurement that it can predict.

    - `measured`: the measurements by name.
    - `scores`: one for each candidate and measurement; `refused`: measurement to candidate to the reason why it
      cannot predict it.
    - `warned`: measurement to what its set-up exceeds, so that no law of the package may hold there.
    - `n`, `seed`: draws of what was not printed.
    """

    measured: Mapping[str, Measurement]
    scores: tuple[Score, ...]
    refused: Mapping[str, Mapping[str, str]]
    warned: Mapping[str, Sequence[Diagnostic]]
    n: int
    seed: int

    FILES: ClassVar = {"laws.csv": Form.TABLE, "measurements.csv": Form.TABLE}

    @property
    def document(self) -> Document:
        """Failures, laws, measurements, and a figure for each."""
        return Document(
            title=f"Evidence: {_several(len(self.measured), 'measurement')} of {_several(len(self._groups), 'group')}",
            sentences=self._sentences,
            numbers=[self._standings(place) for place in self._places],
            figures=[
                self._overview,
                *(figure(name, each, self.of(name)) for name, each in self.measured.items() if each.over),
            ],
            tables=[self._failures] if self.failures else [],
            remarks=[
                REMARK,
                f"{len(self.warned)} set-ups exceed a limit of validity, such as the voltage at which sweat saturates.",
                f"{self.n} draws of what was not printed, seed {self.seed}. Other draws move what lies near the end of an"
                " interval, and one group less may change the order of the laws.",
            ],
            pages=[*([self._causes] if self.failures else []), self._all, self._beyond, self._not_predicted],
            references=list(dict.fromkeys(each.source for each in self.measured.values())),
        )

    def of(self, name: str) -> list[Score]:
        """Return the scores of one measurement, the best first."""
        return sorted(
            (each for each in self.scores if each.measurement == name), key=lambda each: -each.score
        )

    @property
    def failures(self) -> list[Score]:
        """The best candidate of each measurement that no candidate covers whole, the worst first."""
        found = [each for name in self.measured if (each := self.of(name))]
        return sorted(
            (each[0] for each in found if all(one.covered < 1 for one in each)), key=lambda best: best.score
        )

    @property
    def _groups(self) -> set[str]:
        return {each.group for each in self.measured.values()}

    @property
    def _sentences(self) -> list[str]:
        points = sum(len(each.values) for each in self.measured.values())
        of = {how: sum(len(each.values) for each in self.measured.values() if each.how == how) for how in HOW}
        counts = ", ".join(f"{count} {how}" for how, count in of.items() if count)
        failed = self.failures
        unpredicted = [f"{name}: {nobody(why)}" for name, why in self.refused.items() if not self.of(name)]
        wholly = sum(all(not one.covered for one in self.of(each.measurement)) for each in failed)
        outside = {"wholly": wholly, "in part": len(failed) - wholly}
        how = " and ".join(f"{count} {extent}" for extent, count in outside.items() if count)
        said = [
            f"Outside the 90 % interval of every law or model: {how}, of {_several(len(self.measured), 'measurement')}."
            if failed
            else f"Every {'other ' * bool(unpredicted)}measurement lies in the 90 % interval of some law or model."
        ]
        worst = {self.measured[each.measurement].group: each for each in reversed(failed)}
        listed = sorted(worst.values(), key=failed.index)[:WORST]
        said += [self._failure(each) for each in listed]
        return [*unpredicted, *said, f"{points} numbers: {counts}."]

    def _failure(self, each: Score) -> str:
        of = self.measured[each.measurement]
        return (
            f"{each.measurement} ({of.title}): the best, {each.model}, gives {_rounded(each.ratio)} of what was measured"
            f" ({_rounded(each.low)} to {_rounded(each.high)}) and covers {100 * each.covered:.0f} %"
            f" of {_points(len(of.values))}."
            f"{' ' if of.cause else ''}{of.cause}"
        )

    @property
    def _places(self) -> list[str]:
        """Places of the models that are judged, the force laws first."""
        places = dict.fromkeys(each.judges for each in self.measured.values())
        return sorted(places, key=lambda place: place != "force")

    def judging(self, place: str) -> list[Score]:
        """Return the scores of the models of one place, such as ``force``."""
        return [each for each in self.scores if self.measured[each.measurement].judges == place]

    def _standings(self, place: str) -> Table:
        rows = tuple(
            (
                each.model,
                f"{each.groups}",
                f"{each.points}",
                f"{100 * each.covered:.0f} %",
                _rounded(each.ratio),
                _rounded(each.off, digits=3),
                _rounded(each.odds),
                f"{len(each.beaten_by)}",
                _number(each.score),
                _number(each.shape),
            )
            for each in standings(self.judging(place))
        )
        headings: tuple[str, ...] = (
            *("law or model", "groups", "numbers", f"within {100 * LEVEL:.0f} %", "predicted/measured"),
            *("typical factor", "odds", "beaten by", "score", "shape"),
        )
        return Table(
            "Force laws, the best first" if place == "force" else f"Models of {place}, the best first",
            headings,
            rows,
            looks=dict.fromkeys(range(1, len(headings)), "number"),
        )

    @property
    def _failures(self) -> Table:
        rows = tuple(
            (
                each.measurement,
                each.model,
                f"{100 * each.covered:.0f} %",
                _rounded(each.ratio),
                f"{_rounded(each.low)} to {_rounded(each.high)}",
            )
            for each in self.failures
        )
        headings = ("measurement", "best", "within 90 %", "predicted/measured", "90 % of the draws")
        return Table("Measurements that no law or model covers whole", headings, rows)

    @property
    def _causes(self) -> Table:
        """List the likely causes of the failures, each with its measurements."""
        found: dict[str, list[str]] = {}
        for each in self.failures:
            found.setdefault(self.measured[each.measurement].cause or "not known", []).append(
                each.measurement
            )
        rows = tuple(
            (", ".join(names), cause.removeprefix("Likely cause: ")) for cause, names in found.items()
        )
        headings = ("measurements", "likely cause, and what would decide")
        return Table("Why no law or model reaches them", headings, rows, looks={1: "words"})

    @property
    def _overview(self) -> Drawing:
        """Prediction over measured, for every measurement and the laws that are best over all, with their intervals."""
        names = [each.model for each in standings(self.judging(self._places[0]))]
        shown = dict.fromkeys([*names[:BEST], *([USUAL] if USUAL in names else [])])
        rows = {
            name: (
                f"{each.called}, {each.on}",
                f"{each.title} [{each.unit if each.unit != '1' else 'ratio'}]",
            )
            for name, each in self.measured.items()
            if each.judges == self._places[0]
        }
        return Drawing(
            id="overview",
            title="Prediction over measured: the best laws and the usual one",
            plot=functools.partial(_draw_ratios, scores=self.scores, models=list(shown), rows=rows),
            size=(5.2, 1.3 + 0.6 * len(rows)),
            caption="Points: medians; lines: 90 % of the draws of what was not printed, without the spread of the measurement."
            " A line that reaches 1 agrees.",
        )

    @property
    def _all(self) -> Table:
        rows = tuple(self._row(name, each) for name, each in self.measured.items())
        headings: tuple[str, ...] = (
            *("measurement", "what", "on", "group", "numbers", "how it came here", "largest spread", "best"),
            "note",
        )
        return Table("Measurements", headings, rows, folded=True)

    def _row(self, name: str, each: Measurement) -> tuple[str, ...]:
        found = self.of(name)
        best = f"{found[0].model} ({_number(found[0].score)})" if found else "none"
        how, spread = f"{each.how}, {each.status}", f"{100 * max(each.spread):.2g} %, {each.spread_of}"
        return (name, each.title, each.on, each.group, str(len(each.values)), how, spread, best, each.note)

    @property
    def _beyond(self) -> Table:
        rows = tuple((name, each.text) for name, told in self.warned.items() for each in told)
        return Table("Set-ups beyond a limit", ("measurement", "warning"), rows, folded=True)

    @property
    def _not_predicted(self) -> Table:
        rows = tuple(
            (model, name, why) for name, reasons in self.refused.items() for model, why in reasons.items()
        )
        return Table("Cannot predict", ("law or model", "measurement", "why"), rows, folded=True)

    def content(self, name: str) -> str | bytes:
        """Write the standings of the laws, or every score, as CSV."""
        if name not in self.FILES:
            return super().content(name)
        own = ["covered", "ratio", "score", "shape"]
        if name == "laws.csv":
            found = [each for place in self._places for each in standings(self.judging(place))]
            return _csv(["model", "groups", "points", "off", "odds", "beaten_by", *own], found)
        return _csv(["measurement", "group", "model", "low", "high", *own], self.scores)


def _csv(names: list[str], records: Sequence[Standing | Score]) -> str:
    def cell(value: Any) -> Any:
        return ", ".join(value) if isinstance(value, tuple) else value

    return csv_text(names, [[cell(getattr(each, name)) for name in names] for each in records])


def _draw_ratios(
    figure: Any, *, scores: Sequence[Score], models: list[str], rows: Mapping[str, tuple[str, str]]
) -> None:
    """Draw the ratio of each measurement under who measured what, with one colour for each law."""
    ax, names = figure.add_subplot(), list(rows)
    for place, model in enumerate(models):
        found = [each for each in scores if each.model == model and each.measurement in names]
        heights = [names.index(each.measurement) + 0.11 * place - 0.02 for each in found]
        middle = np.array([each.ratio for each in found])
        ends = np.array([[each.ratio - each.low, each.high - each.ratio] for each in found]).T
        ax.errorbar(middle, heights, xerr=ends, fmt="o", markersize=4, linewidth=1.2, label=_words(model))
    ax.axvline(1.0, color="0.3", linewidth=1.2)
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter("{x:g}")
    for height, (who, what) in enumerate(rows.values()):
        at: Any = {"xycoords": ("axes fraction", "data"), "va": "bottom"}
        at["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
        ax.annotate(who, (0.01, height - 0.38), **at, weight="bold")
        ax.annotate(what, (0.01, height - 0.16), **at, fontsize="small")
        ax.axhline(height - 0.58, color="0.8", linewidth=0.6)
    ax.set_yticks([])
    ax.set_ylim(len(names) - 0.58, -0.58)
    ax.set_xlabel("predicted over measured: 1 agrees")
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=2, frameon=False, fontsize="small")


def _words(model: str) -> str:
    """Write the name of a model in words."""
    return re.sub(r"(?<=[a-z])(?=[A-Z\d])|(?<=\d)(?=[A-Z])", " ", model).capitalize()


def nobody(refused: Mapping[str, str]) -> str:
    """Say that no candidate predicts a measurement, with the reason that most of them have."""
    reasons = list(refused.values())
    return (
        f"no law or model can predict it: {max(reasons, key=reasons.count) if reasons else 'there is none'}"
    )


def _rounded(value: float, *, digits: int = 2) -> str:
    """Write 160 and not 1.6e+02."""
    return f"{float(f'{value:.{digits}g}'):g}"


def _several(count: int, what: str) -> str:
    return f"{count} {what}{'s' if count != 1 else ''}"


def _points(count: int) -> str:
    return "its value" if count == 1 else f"its {count} values"


def _number(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def figure(name: str, measured: Measurement, scores: list[Score]) -> Panel:
    """Draw the measured points, and the bands of the best candidates and of the usual law."""
    shown = [*scores[:BEST], *(each for each in scores[BEST:] if each.model == USUAL)]
    x = measured.points
    curves = []
    for look, each in enumerate(shown):
        low, middle, high = each.band
        curves.append(Curve(label=f"{each.model}, 90 %", x=x, y=low, upper=high, kind="band", look=look))
        curves.append(Curve(label=each.model, x=x, y=middle, look=look))
    values, widths = np.array(measured.values), np.exp(np.array(measured.spread))
    grey: dict[str, Any] = {"x": x, "look": REFERENCE}
    curves += [
        Curve(
            label="spread of the measurement", y=values / widths, upper=values * widths, kind="band", **grey
        ),
        Curve(label="measured", y=values, kind="points", **grey),
    ]
    origin = f"{measured.how.capitalize()}, {measured.status}: {measured.source}."
    spread = f"Grey: measured, with its spread ({measured.spread_of})."
    laws = "Lines and areas: medians and 90 % of the draws of what was not printed." if shown else ""
    return Panel(
        id=name.replace("/", "_"),
        title=f"{measured.title} ({measured.group})",
        caption=" ".join(filter(None, (spread, laws, origin, measured.note))),
        x=measured.axis,
        y=(words_at(None, measured.named), measured.unit),
        curves=tuple(curves),
        log_x=bool(np.min(x) > 0 and np.max(x) / np.min(x) > 20),
        log_y=True,
        folded=True,
    )
