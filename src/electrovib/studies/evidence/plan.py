"""Which experiment would tell laws apart: the points of a set-up, within its limits, that need the fewest repeats."""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, computed_or_refused, refuse
from electrovib.core.mistakes import near_members
from electrovib.core.units import format_quantity, parse_quantity
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.force import ForceLaw
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.scenario.space.reading import SpaceSource, read_space
from electrovib.scenario.space.relations import checked_draws, checked_seed
from electrovib.solve.meter import Meter
from electrovib.solve.prepare import prepare
from electrovib.solve.quantities.names import read_name
from electrovib.studies.check import check
from electrovib.studies.evidence.predicted import NUMBERS
from electrovib.studies.sweep import parse_over, point_words

REPEATS: Final = tuple(2**power for power in range(13))
"""Numbers of repeats at each point that are tried, up to 4096."""
ODDS: Final = 20.0
"""Odds at which one law counts as told apart from another."""
OWN: Final = "the scenario"
MOST_POINTS: Final = 200
"""Points of the grid of an experiment, which are compared in pairs."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Points at which a quantity is measured, each as often as the others.

    - `points`: dotted path to value, for each point.
    - `repeats`: measurements in all for expected odds of `ODDS`, whichever of two laws is true; infinite where 4096 at
      each point do not suffice.
    - `log_odds`: the expected logarithm of the odds for the true law, over `REPEATS` at each point.
    """

    points: tuple[Mapping[str, float], ...]
    repeats: float
    log_odds: Real


@dataclass(frozen=True, kw_only=True, repr=False)
class ExperimentPlan(Answer):
    """The experiment that tells laws apart with the fewest repeats, beside the one that the scenario is.

    - `best`, `own`: the best experiment, and the scenario as it stands.
    - `others`: further experiments, from the fewest repeats on.
    - `left_out`: points that a limit forbids, or that a law cannot predict, with the reason.
    """

    scenario: Scenario
    laws: tuple[str, ...]
    quantity: str
    noise: tuple[float, float]
    best: Experiment
    own: Experiment
    others: tuple[Experiment, ...]
    left_out: Mapping[str, str]
    diagnostics: tuple[Diagnostic, ...]

    FILES: ClassVar = {"experiments.csv": Form.TABLE}

    @property
    def document(self) -> Document:
        """The best experiment, the others, and the odds over the repeats."""
        unit = read_name(self.quantity, tuple(self.scenario.stack.layers)).unit
        left_out = Table("Left out", ("point", "why"), tuple(self.left_out.items()), folded=True)
        return Document(
            title=f"Which experiment tells {' from '.join(self.laws)}",
            sentences=self._sentences,
            numbers=[self._table],
            diagnostics=self.diagnostics,
            figures=[self._figure],
            remarks=[
                f"Measured: {self.quantity}, with a deviation of {100 * self.noise[0]:.3g} % and"
                f" {format_quantity(self.noise[1], unit, digits=3)} in each repeat. What the space leaves open is the same"
                " in all repeats. Odds are expected over the space and the noise, for the law that needs more."
            ],
            pages=[left_out] if self.left_out else [],
        )

    @property
    def _sentences(self) -> list[str]:
        apart, needed, own = (
            f"{' from '.join(self.laws)} with odds of {ODDS:g}",
            self.best.repeats,
            self.own.repeats,
        )
        if not math.isfinite(needed):
            return [f"No experiment of this grid tells {apart}."]
        beside = f"needs {own:.0f}, {own / needed:.3g} times as many"
        if not math.isfinite(own):
            most = math.exp(min(self.own.log_odds[-1], 50.0))
            beside = f"does not reach them: {most:.3g} after {REPEATS[-1]} repeats"
        return [
            f"Measure {self._told(self.best)}: {needed:.0f} measurements in all tell {apart}.",
            f"The scenario as it stands {beside}.",
        ]

    def _told(self, experiment: Experiment) -> str:
        return " and ".join(self._at(point) for point in experiment.points)

    def _at(self, point: Mapping[str, float]) -> str:
        return f"at {point_words(self.scenario, point)}" if point else "the scenario as it stands"

    @property
    def _table(self) -> Table:
        rows = [(self._told(each), _number(each.repeats)) for each in (self.best, *self.others)]
        rows.append(("the scenario as it stands", _number(self.own.repeats)))
        return Table("Experiments", ("measure", "repeats in all"), tuple(rows), looks={1: "number"})

    @property
    def _figure(self) -> Panel:
        curves = [
            Curve(
                label=label,
                x=np.array(REPEATS, dtype=float) * len(each.points),
                y=each.log_odds / math.log(10),
            )
            for label, each in (("best", self.best), ("the scenario as it stands", self.own))
        ]
        ends = np.array([1.0, 2.0 * REPEATS[-1]])
        level = Curve(
            label=f"odds of {ODDS:g}", x=ends, y=np.full(2, math.log10(ODDS)), kind="dashed", look=-1
        )
        return Panel(
            id="odds",
            title="Odds for the true law over the number of measurements",
            caption="Decimal logarithm, expected over what the space leaves open and the noise.",
            x=("measurements in all", "1"),
            y=("log10 of the odds", "1"),
            curves=(*curves, level),
            log_x=True,
        )

    def content(self, name: str) -> str | bytes:
        """Write every experiment as CSV."""
        if name not in self.FILES:
            return super().content(name)
        rows = [(self._told(each), each.repeats) for each in (self.best, *self.others, self.own)]
        return csv_text(["measure", "repeats in all"], rows, diagnostics=self.diagnostics)


def _number(repeats: float) -> str:
    return f"{repeats:.0f}" if math.isfinite(repeats) else f"more than {REPEATS[-1]}"


def plan_experiment(
    scenario: Source,
    models: Sequence[str],
    *,
    over: Sequence[str] | Mapping[str, Sequence[float] | Real],
    space: SpaceSource,
    quantity: str = "swing lateral_force",
    noise: tuple[float | str, float | str] = (0.1, 1e-3),
    set: Mapping[str, Any] | None = None,  # noqa: A002 - the name of the option
    limits: Any = None,
    n: int = 64,
    seed: int = 0,
) -> ExperimentPlan:
    """Find the experiment that separates force laws with the fewest repeats.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        The set-up, as for `electrovib.load`.
    models : sequence of str
        Names of two or more force laws.
    over : sequence of str, or mapping of str to sequence of float
        ``"path=from:to:n"`` or ``"path=from:to:nlog"``, or dotted path to values in SI: what can be chosen, for instance
        ``drive.frequency``. All combinations are points, at most 200, and an experiment measures at one point or at two.
    space : str, Path, mapping or Space
        What is not known of the finger and the plate, as for `electrovib.read_space`.
    quantity : str
        What is measured.
    noise : (float or str, float or str)
        Standard deviation of one repeat: relative to the value [1], and of the sensor, in the unit of the quantity; or texts,
        ``("10 %", "20 mN")``.
    set : mapping of str to value, optional
        Dotted path to value, put into the scenario.
    limits : optional
        Limits besides those of the scenario, as for `electrovib.check`.
    n, seed : int
        Draws of the space, and their seed.

    Returns
    -------
    ExperimentPlan
        The best experiment, how many repeats it needs, and how many the scenario as it stands would need.

    Raises
    ------
    InputError
        For an unknown law, a single one, too many points, or if limits or laws leave no point.

    Notes
    -----
    The density p(y|A) of what is measured under law A is that of its values over the space, smoothed by the noise of a mean
    over the repeats and by the distance between the draws, so that a finer experiment cannot see what the draws do not
    show. The odds are p(y|A)/p(y|B) for y from law A, their logarithm expected over draws and noise, and those for y from B;
    the smaller one counts.

    Examples
    --------
    >>> laws = ["MaxwellStressInGap", "MaxwellStressInInsulator"]
    >>> asked = {"quantity": "mean electrostatic_force", "space": "fingers", "n": 8}
    >>> found = ev.plan_experiment("bau_2010/sine", laws, over={"drive.amplitude": [10.0, 20.0]}, **asked)
    >>> found.document.sentences[0]
    'No experiment of this grid tells MaxwellStressInGap from MaxwellStressInInsulator with odds of 20.'
    """
    base = read_scenario(scenario, changes=set)
    _check_laws(models)
    checked_seed(seed)
    points = _grid(parse_over(base, over))
    deviation = _noise(noise, unit=read_name(quantity, tuple(base.stack.layers)).unit)
    of, count = f"{checked_draws(n):.6g} draws for each law and point", n * len(models) * len(points)
    Meter.of_cases("this plan", of, count, numbers=NUMBERS, remedy="draw fewer (-n), or compare fewer points")
    cases = [base.replace({"force": {"model": law}}) for law in models]

    def values(_: str, point: dict[str, float]) -> list[Real]:
        if point and check(base.replace(point), limits=limits).forbidding:
            raise InputError("a limit forbids it")
        return [_values(case.replace(point), space, quantity, n=n, seed=seed) for case in cases]

    named = {
        ", ".join(f"{path} = {value:.6g}" for path, value in point.items()) or OWN: point for point in points
    }
    known, left_out = computed_or_refused(named, values, reason=lambda error: str(error.problems[0]))
    if OWN not in known:
        raise InputError(f"the scenario as it stands cannot be predicted: {left_out[OWN]}")
    if len(known) < 2:
        raise InputError([f"over: {point}: {why}" for point, why in left_out.items()])
    kept, found = [named[name] for name in known], np.array([*known.values()])  # points, laws, draws
    sets = [(i,) for i in range(1, len(kept))] + list(itertools.combinations(range(1, len(kept)), 2))
    experiments = [_experiment(kept, found, which, deviation) for which in sets]
    experiments.sort(key=lambda each: (each.repeats, -float(each.log_odds[-1])))
    return ExperimentPlan(
        scenario=base,
        laws=tuple(models),
        quantity=quantity,
        noise=deviation,
        best=experiments[0],
        own=_experiment(kept, found, (0,), deviation),
        others=tuple(experiments[1:6]),
        left_out=left_out,
        diagnostics=check(base, limits=limits).diagnostics,
    )


def _check_laws(laws: Sequence[str]) -> None:
    known = find_members(ForceLaw)
    problems = [
        f"models: '{name}' is not a force law.{near_members(ForceLaw, name)}"
        for name in laws
        if name not in known
    ]
    if len(dict.fromkeys(laws)) < 2:
        problems.append("models: name two different ones at least")
    refuse(problems)


def _noise(given: tuple[float | str, float | str], *, unit: str) -> tuple[float, float]:
    """Read the relative and the absolute deviation of a repeat."""
    relative, absolute = given
    try:
        share = float(relative.removesuffix("%")) / 100 if isinstance(relative, str) else float(relative)
        value = parse_quantity(absolute, unit) if isinstance(absolute, str) else float(absolute)
    except ValueError as error:
        raise InputError(
            f"noise = {given}: expected a share and a value, such as '10 %, 20 mN': {error}"
        ) from None
    if not (share >= 0 and value >= 0 and share + value > 0):
        raise InputError(f"noise = {given}: expected deviations that are not negative, one of them above 0")
    return share, value


def _grid(over: Mapping[str, Sequence[float] | Real]) -> list[dict[str, float]]:
    """Return the scenario as it stands, and all combinations of the values."""
    count = math.prod(len(values) for values in over.values())
    if not over or not 1 <= count <= MOST_POINTS:
        raise InputError(
            f"over: {count} points; expected 1 to {MOST_POINTS}, because they are compared in pairs"
        )
    combinations = itertools.product(*over.values())
    return [{}, *(dict(zip(over, map(float, each), strict=True)) for each in combinations)]


def _values(scenario: Scenario, space: SpaceSource, quantity: str, *, n: int, seed: int) -> Real:
    """Compute the quantity of every draw (n,)."""
    found = read_space(scenario, space)
    values: Real = prepare(scenario, free=found.paths, quantity=[quantity])(found.draw(seed, 0, n))[quantity]
    if not np.all(np.isfinite(values)):
        raise InputError(f"{quantity}: {type(scenario.force).__name__} gives no number for some of the draws")
    return values


def _experiment(
    points: Sequence[Mapping[str, float]], values: Real, which: tuple[int, ...], noise: tuple[float, float]
) -> Experiment:
    """Compute the expected odds of an experiment at some of the points, over the repeats."""
    shown = values[list(which)]
    odds = np.array([_worst(shown, repeats, noise) for repeats in REPEATS])
    enough = np.flatnonzero(odds >= math.log(ODDS))
    repeats = REPEATS[enough[0]] * len(which) if enough.size else math.inf
    return Experiment(points=tuple(points[i] for i in which), repeats=repeats, log_odds=odds)


def _worst(values: Real, repeats: int, noise: tuple[float, float]) -> float:
    """Return the smallest expected logarithm of the odds over pairs of a true and another law, for means over repeats.

    `values` are (points, laws, draws). On the scale asinh(value/absolute noise) the deviation of a repeat changes little:
    it is 1 below the absolute noise and the relative one above.
    """
    relative, absolute = noise
    unit = absolute or float(np.min(np.abs(values[values != 0]), initial=np.inf)) * relative
    scaled = np.arcsinh(values / unit)
    deviation = np.hypot(relative * values, absolute or relative * unit)
    widths = deviation / np.hypot(values, unit) / math.sqrt(repeats)
    steps = np.random.default_rng(0).standard_normal((len(values), values.shape[2]))
    laws = range(values.shape[1])
    expected = []
    for true in laws:
        seen = scaled[:, true] + widths[:, true] * steps
        own = _log_density(seen, scaled[:, true], widths[:, true], own=True)
        others = (_log_density(seen, scaled[:, each], widths[:, each]) for each in laws if each != true)
        expected += [float(np.mean(own - other)) for other in others]
    return min(expected)


def _log_density(seen: Real, draws: Real, widths: Real, *, own: bool = False) -> Real:
    """Return the logarithm of the density of what was seen (points, m) under a law with draws (points, k), shape (m,).

    A Gaussian kernel around each draw, as wide as the noise and the distance between the draws of Scott's rule; of what was
    seen of these draws themselves (`own`) each leaves its own draw out, because it would find itself.
    """
    from scipy.special import logsumexp

    points, count = draws.shape
    spread = np.atleast_2d(np.cov(draws)) * count ** (-2 / (points + 4))
    covariance = spread + np.eye(points) * (widths.T**2)[:, None, :]  # draws, points, points
    inverse, determinant = np.linalg.inv(covariance), np.linalg.slogdet(covariance)[1]
    off = seen.T[:, None, :] - draws.T  # m, draws, points
    logs = -0.5 * (np.einsum("mki,kij,mkj->mk", off, inverse, off) + determinant)
    if own:
        np.fill_diagonal(logs, -np.inf)
    found: Real = logsumexp(logs, axis=1) - math.log(count - own)
    return found
