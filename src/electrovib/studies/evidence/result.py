"""The evidence as an answer: what decides, the skill of the laws, failures, and a figure for each measurement."""

from __future__ import annotations

import functools
import math
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple, dataclass, fields
from typing import Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Drawing, Panel, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.paths import words_at
from electrovib.data.atomic import Form, csv_text
from electrovib.studies.evidence import challenge, standing
from electrovib.studies.evidence.calibrated import Calibrated, csv_of, sentence, table
from electrovib.studies.evidence.challenge import Submission
from electrovib.studies.evidence.measurement import HOW, Measurement, numbers_of
from electrovib.studies.evidence.predicted import NULLS
from electrovib.studies.evidence.standing import CommonSet, Score, Standing, several

WORST: Final = 5
"""Groups of people whose worst failure is stated."""
BEST: Final = 3
"""Laws of which a figure shows the bands."""
USUAL: Final = "EffectiveMedium"
"""The law that most texts use, which every figure shows where it can be computed."""
REMARK: Final = (
    "Laws are compared on the measurements that all of them predict; every group of people who measured counts once, and"
    " points of one fitted line or figure count as one number. The score is the mean logarithm of the predictive density of"
    " the logarithm of a value, of a bound that of the probability to keep it; the skill is what it is above that of the"
    " best null model, with the 90 % interval by the jackknife over groups, and a law whose interval does not lie above 0"
    " has none. Beside it stand the skill and the rank with one group less, and the skill with every range of what was not"
    " printed half and twice as wide. The width is that of the 90 % interval in decades; a law can miss a number where it is"
    " below one. The shape is scored with one common factor left free in each measurement."
)


@dataclass(frozen=True, kw_only=True, repr=False)
class Evidence(Answer):
    """Every candidate on every measurement that it can predict.

    - `measured`: the measurements by name.
    - `scores`: one for each candidate and measurement; `nulls`: the same of the null models.
    - `refused`: measurement to candidate to the reason why it
      cannot predict it.
    - `warned`: measurement to what its set-up exceeds, so that no law of the package may hold there.
    - `calibrated`: each candidate on what declares a calibration, without and with it.
    - `n`, `seed`: draws of what was not printed.
    - `submissions`: what was entered in the challenge, each among the candidates under its name.
    """

    measured: Mapping[str, Measurement]
    scores: tuple[Score, ...]
    nulls: tuple[Score, ...]
    refused: Mapping[str, Mapping[str, str]]
    warned: Mapping[str, Sequence[Diagnostic]]
    n: int
    seed: int
    calibrated: tuple[Calibrated, ...] = ()
    submissions: tuple[Submission, ...] = ()

    FILES: ClassVar = {
        "laws.csv": Form.TABLE,
        "measurements.csv": Form.TABLE,
        "nulls.csv": Form.TABLE,
        "calibrated.csv": Form.TABLE,
    }

    @property
    def document(self) -> Document:
        """Failures, laws, measurements, and a figure for each."""
        entered = [challenge.table(each, self.sides(each)) for each in self.submissions]
        return Document(
            title=f"Evidence: {several(len(self.measured), 'measurement')} of {several(len(self._groups), 'group')}",
            sentences=self._sentences,
            numbers=[*entered, *(_standings(each) for each in self.comparisons)],
            figures=[
                self._overview,
                *(
                    figure(name, each, self.of(name), self.nulls)
                    for name, each in self.measured.items()
                    if each.over
                ),
            ],
            tables=[self._failures] if self.failures else [],
            remarks=[
                REMARK,
                *(f"Null model '{null}': {what}." for null, what in NULLS.items()),
                f"{len(self.warned)} set-ups exceed a limit of validity, such as the voltage at which sweat saturates.",
                f"{self.n} draws of what was not printed, seed {self.seed}. Other draws move what lies near the end of an"
                " interval.",
            ],
            pages=[
                *([table(self.calibrated)] if self.calibrated else []),
                *([self._causes] if self.failures else []),
                *(self._undecided, self._all, self._beyond, self._not_predicted),
            ],
            references=list(dict.fromkeys(each.source for each in self.measured.values())),
        )

    @functools.cached_property
    def _by_measurement(self) -> dict[str, list[Score]]:
        found: dict[str, list[Score]] = {name: [] for name in self.measured}
        for each in sorted(self.scores, key=lambda each: -each.score):
            found[each.measurement].append(each)
        return found

    def of(self, name: str) -> list[Score]:
        """Return the scores of one measurement, the best first."""
        return self._by_measurement[name]

    @property
    def failures(self) -> list[Score]:
        """The best candidate of each measurement that no candidate covers whole, the worst first."""
        known = [each for each in self._by_measurement.values() if each]
        best = (each[0] for each in known if all(one.covered < 1 for one in each))
        return sorted(best, key=lambda best: best.score)

    @functools.cached_property
    def comparisons(self) -> tuple[CommonSet, ...]:
        """Candidates of each place on the measurements that all of them predict, force laws first."""
        return tuple(
            each
            for place in self._places
            for each in standing.comparisons(place, self.judging(place), self.nulls)
        )

    def sides(self, entered: Submission) -> dict[str, list[CommonSet]]:
        """Return, for each side of the split, the common sets on which a submission stands."""
        return challenge.sets_of(entered, self.scores, self.nulls)

    @property
    def decides(self) -> list[str]:
        """Measurements that a candidate covers with an interval below one decade, while another one misses."""
        return [
            name
            for name, each in self._by_measurement.items()
            if any(one.covered == 1 and one.width < standing.NARROW for one in each)
            and any(one.covered < 1 for one in each)
        ]

    @property
    def decides_nothing(self) -> list[str]:
        """Measurements that every candidate covers."""
        known = self._by_measurement.items()
        return [name for name, each in known if each and all(one.covered == 1 for one in each)]

    @property
    def numbers(self) -> frozenset[tuple[str, ...]]:
        """What counts as one number each."""
        return frozenset(key for name, each in self.measured.items() for key in numbers_of(name, each))

    @property
    def can_be_missed(self) -> frozenset[tuple[str, ...]]:
        """Numbers for which the interval of some candidate spans less than a decade."""
        return frozenset(key for each in self.scores if each.width < standing.NARROW for key in each.numbers)

    @property
    def _groups(self) -> set[str]:
        return {each.group for each in self.measured.values()}

    @property
    def _sentences(self) -> list[str]:
        of = {how: sum(len(each.values) for each in self.measured.values() if each.how == how) for how in HOW}
        counts = ", ".join(f"{count} {how}" for how, count in of.items() if count)
        unpredicted = [f"{name}: {nobody(why)}" for name, why in self.refused.items() if not self.of(name)]
        worst = {self.measured[each.measurement].group: each for each in reversed(self.failures)}
        listed = sorted(worst.values(), key=self.failures.index)[:WORST]
        missed = [each.measurement for each in self.failures]
        wholly = sum(all(not one.covered for one in self.of(name)) for name in missed)
        return [
            *(said for each in self.submissions for said in challenge.sentences(each, self.sides(each))),
            *unpredicted,
            f"A law or model can miss {len(self.can_be_missed)} of {several(len(self.numbers), 'number')}: its 90 % interval"
            " spans less than a decade.",
            f"Of {several(len(self.measured), 'measurement')}, {len(self.decides)} decide between such a law and another that"
            f" misses; {len(self.decides_nothing)} decide nothing, because every candidate covers them; {len(missed)} lie"
            f" outside the interval of every candidate, {wholly} of them wholly.",
            *map(_skills, self.comparisons),
            *([sentence(self.calibrated)] if self.calibrated else []),
            *(self._failure(each) for each in listed),
            f"{sum(of.values())} values: {counts}.",
        ]

    def _failure(self, each: Score) -> str:
        of = self.measured[each.measurement]
        return (
            f"{each.measurement} ({of.title}): the best, {each.model}, gives {_rounded(each.ratio)} of what was measured"
            f" ({_rounded(each.low)} to {_rounded(each.high)}) and covers {100 * each.covered:.0f} %"
            f" of {'its value' if len(of.values) == 1 else f'its {len(of.values)} values'}."
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

    @property
    def _failures(self) -> Table:
        columns: dict[str, Callable[[Score], str]] = {
            "measurement": lambda each: each.measurement,
            "best": lambda each: each.model,
            "within 90 %": lambda each: f"{100 * each.covered:.0f} %",
            "predicted/measured": lambda each: _rounded(each.ratio),
            "90 % of the draws": lambda each: f"{_rounded(each.low)} to {_rounded(each.high)}",
        }
        return Table.of("Measurements that no law or model covers whole", self.failures, columns)

    @property
    def _causes(self) -> Table:
        """List the likely causes of the failures, each with its measurements."""
        found: dict[str, list[str]] = {}
        for each in self.failures:
            cause = self.measured[each.measurement].cause or "not known"
            found.setdefault(cause.removeprefix("Likely cause: "), []).append(each.measurement)
        rows = tuple((", ".join(names), cause) for cause, names in found.items())
        headings = ("measurements", "likely cause, and what would decide")
        return Table("Why no law or model reaches them", headings, rows, looks={1: "words"})

    @property
    def _undecided(self) -> Table:
        rows = tuple(
            (name, ", ".join(f"{each.model} ({each.width:.1f})" for each in self.of(name)))
            for name in self.decides_nothing
        )
        headings = ("measurement", "candidates, all of which cover it, with the width in decades")
        return Table("Decide nothing", headings, rows, looks={1: "words"}, folded=True)

    @property
    def _overview(self) -> Drawing:
        """Prediction over measured, for every measurement, the best laws and the best null model, with their intervals."""
        found = standing.shown_first(self.comparisons)
        names = [each.model for each in found.standings]
        shown = dict.fromkeys([*names[:BEST], *([USUAL] if USUAL in names else []), found.null])
        rows = {
            name: (
                f"{each.called}, {each.on}",
                f"{each.title}{f', {each.bound}' * bool(each.bound)} [{each.unit if each.unit != '1' else 'ratio'}]",
            )
            for name, each in self.measured.items()
            if each.judges == self._places[0]
        }
        return Drawing(
            id="overview",
            title="Prediction over measured: the best laws, the usual one and the best null model",
            plot=functools.partial(
                _draw_ratios, scores=[*self.scores, *self.nulls], models=list(shown), rows=rows
            ),
            size=(5.2, 1.3 + 0.2 * len(shown) + 0.7 * len(rows)),
            caption="Points: medians; lines: 90 % of the draws of what was not printed, without the spread of the measurement."
            " A line that reaches 1 agrees; of a bound, one that lies on the side that its row names.",
        )

    @property
    def _all(self) -> Table:
        def best(name: str) -> str:
            found = self.of(name)
            return f"{found[0].model} ({_number(found[0].score)})" if found else "none"

        of = self.measured
        columns: dict[str, Callable[[str], str]] = {
            "measurement": lambda name: name,
            "what": lambda name: of[name].title,
            "on": lambda name: of[name].on,
            "group": lambda name: of[name].group,
            "values": lambda name: f"{of[name].bound} {len(of[name].values)}".strip(),
            "numbers": lambda name: str(len(numbers_of(name, of[name]))),
            "how it came here": lambda name: f"{of[name].how}, {of[name].status}",
            "largest spread": lambda name: f"{100 * max(of[name].spread):.2g} %, {of[name].spread_of}",
            "best": best,
            "note": lambda name: of[name].note,
        }
        return Table.of("Measurements", of, columns, folded=True)

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
        """Write the standings of the laws, or every score of these or of the null models, as CSV."""
        if name not in self.FILES:
            return super().content(name)
        if name == "calibrated.csv":
            return csv_of(self.calibrated)
        if name == "laws.csv":
            own = [field.name for field in fields(Standing)]
            rows = [
                [each.place, len(each.names), each.numbers, each.groups, each.null, *astuple(one)]
                for each in self.comparisons
                for one in each.standings
            ]
            return csv_text(["judges", "measurements", "numbers", "groups", "null", *own], rows)
        own = ["low", "high", "covered", "width", "ratio", "score", "narrow", "wide", "shape"]
        head = ["measurement", "group", "model", *own]
        scores = self.nulls if name == "nulls.csv" else self.scores
        return csv_text(head, [[getattr(each, one) for one in head] for each in scores])


def _standings(found: CommonSet) -> Table:
    columns: dict[str, Callable[[Standing], str]] = {
        "law or model": lambda each: each.model,
        "skill": lambda each: f"{'' if each.has_skill else 'none: '}{_number(each.skill)}",
        f"{100 * standing.LEVEL:.0f} % of it": lambda each: _from_to(each.low, each.high),
        "one group less": lambda each: _from_to(each.least, each.most),
        "rank there": lambda each: f"{each.first} to {each.last}",
        "half as wide": lambda each: _number(each.narrow),
        "twice as wide": lambda each: _number(each.wide),
        "can miss": lambda each: f"{each.can_miss}",
        "width": lambda each: f"{each.width:.1f}",
        f"within {100 * standing.LEVEL:.0f} %": lambda each: f"{100 * each.covered:.0f} %",
        "predicted/measured": lambda each: _rounded(each.ratio),
        "typical factor": lambda each: _rounded(each.off, digits=3),
        "shape": lambda each: _number(each.shape),
    }
    title = f"{_of_place(found)}: {_common_set(found)}; skill over '{found.null}'"
    looks = dict.fromkeys(range(1, len(columns)), "number")
    return Table.of(title, found.standings, columns, looks=looks)


def _skills(found: CommonSet) -> str:
    """Say which candidates have skill on a common set, and which have none."""
    known = [
        f"{each.model} {_number(each.skill)} ({_from_to(each.low, each.high)})"
        for each in found.standings
        if each.has_skill
    ]
    none = [each.model for each in found.standings if not each.has_skill]
    over = f"over the best null model, '{found.null}'"
    said = [f"skill {over}: {', '.join(known)}"] if known else []
    if none:
        said.append(f"no skill{'' if known else f' {over}'}: {', '.join(none)}")
    why = ", of one group, which gives no interval" if found.groups == 1 else ""
    return f"{_of_place(found)}, {_common_set(found)}{why}: {'; '.join(said)}."


def _of_place(found: CommonSet) -> str:
    return "Force laws" if found.place == "force" else f"Models of {found.place}"


def _common_set(found: CommonSet) -> str:
    counts = f"{several(found.numbers, 'number')} of {several(found.groups, 'group')}"
    return f"{counts} that {several(len(found.standings), 'candidate')} predict{'s' * (len(found.standings) == 1)}"


def _from_to(low: float, high: float) -> str:
    return f"{low:.2f} to {high:.2f}" if math.isfinite(low) else "–"


def _draw_ratios(
    figure: Any, *, scores: Sequence[Score], models: list[str], rows: Mapping[str, tuple[str, str]]
) -> None:
    """Draw the ratio of each measurement under who measured what, with one colour for each law."""
    ax, names = figure.add_subplot(), list(rows)
    for place, model in enumerate(models):
        found = [each for each in scores if each.model == model and each.measurement in names]
        heights = [names.index(each.measurement) + 0.09 * place - 0.02 for each in found]
        middle = np.array([each.ratio for each in found])
        ends = np.array([[each.ratio - each.low, each.high - each.ratio] for each in found]).T
        ax.errorbar(middle, heights, xerr=ends, fmt="o", markersize=4, linewidth=1.2, label=_words(model))
    ax.axvline(1.0, color="0.3", linewidth=1.2)
    ax.set_xscale("log")
    ax.xaxis.set_major_formatter("{x:g}")
    for height, (who, what) in enumerate(rows.values()):
        at: Any = {"xycoords": ("axes fraction", "data"), "va": "top"}
        at["bbox"] = {"facecolor": "white", "edgecolor": "none", "pad": 0.5}
        for text in (
            ax.annotate(who, (0.01, height - 0.55), **at, weight="bold"),
            ax.annotate(what, (0.01, height - 0.33), **at, fontsize="small"),
        ):
            text.set_in_layout(False)  # a long one would leave no room for the axes of a narrow figure
        ax.axhline(height - 0.58, color="0.8", linewidth=0.6)
    ax.set_yticks([])
    ax.set_ylim(len(names) - 0.58, -0.58)
    ax.set_xlabel("predicted over measured: 1 agrees")
    ax.legend(loc="lower left", bbox_to_anchor=(0, 1), frameon=False, fontsize="small")


def _words(model: str) -> str:
    """Write the name of a model in words; that of a null model is in words."""
    if " " in model:
        return model[0].upper() + model[1:]
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


def _number(value: float) -> str:
    return f"{value:.2f}" if math.isfinite(value) else "–"


def figure(name: str, measured: Measurement, scores: list[Score], nulls: Sequence[Score]) -> Panel:
    """Draw the measured points, and the bands of the best candidates, of the usual law and of the best null model."""
    shown = [*scores[:BEST], *(each for each in scores[BEST:] if each.model == USUAL)]
    shown += sorted((each for each in nulls if each.measurement == name), key=lambda each: -each.score)[:1]
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
    spread = f"Grey: measured{f', {measured.bound} this' * bool(measured.bound)}, with its spread ({measured.spread_of})."
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
