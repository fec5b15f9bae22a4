"""Sensitivity of a quantity to the parameters of a space: Sobol indices with intervals, elasticities, and the answer in words."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import ClassVar, Final

import numpy as np

from electrovib.core.answer import Answer, Document, Drawing, Table
from electrovib.core.arrays import Real
from electrovib.core.deprecation import former_attribute
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text, unsigned
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.scenario.space import Space, SpaceSource, read_space
from electrovib.scenario.space.relations import checked_seed
from electrovib.solve.meter import Meter, measured
from electrovib.solve.prepare import Prepared
from electrovib.solve.quantities.answer import validity
from electrovib.solve.quantities.names import read_name

STEP: Final = 1e-2
"""Relative change of a parameter; the error of the difference is of the order of its fourth power."""
_WEIGHTS: Final = {1: 2 / 3, 2: -1 / 12}
"""Weights of the differences over one and over two steps on both sides, which make it of that order."""


@dataclass(frozen=True, kw_only=True)
class Elasticity:
    """Relative change of a number for a small relative change of a parameter, at one point.

    `at` is the value of the parameter in `unit`; `value` is d ln number / d ln parameter, NaN where the
    parameter or the number is 0, or the range of the parameter ends there.
    """

    path: str
    at: float
    unit: str
    value: float

    @property
    def shown(self) -> str:
        """The value of the parameter with its unit."""
        return format_quantity(self.at, self.unit, digits=4)


def slope(quantity: Callable[[Mapping[str, float]], float], at: Mapping[str, float], path: str) -> float:
    """Return dq / d ln p of a quantity q by one parameter p, in the unit of q; NaN where it cannot be computed."""
    if at[path] == 0:
        return math.nan

    def ahead(steps: int) -> float:
        return quantity({**at, path: at[path] * math.exp(steps * STEP)})

    try:
        return sum(weight * (ahead(steps) - ahead(-steps)) for steps, weight in _WEIGHTS.items()) / STEP
    except ElectrovibError:  # the range of the parameter ends here
        return math.nan


def elasticities(
    scenario: Scenario,
    quantity: Callable[[Mapping[str, float]], float],
    at: Mapping[str, float],
    paths: Iterable[str],
    *,
    per: float,
) -> list[Elasticity]:
    """Return the slope of a quantity by the logarithm of each parameter, over a slope or value `per`."""
    return [
        Elasticity(
            path=path,
            at=at[path],
            unit=quantity_at(scenario, path).unit,
            value=slope(quantity, at, path) / per + 0.0 if per else math.nan,
        )
        for path in paths
    ]


_HELD: Final = 8
"""Numbers that are held for each evaluation."""


@measured()
def sensitivity(
    scenario: Source,
    space: SpaceSource,
    *,
    quantity: str,
    n: int,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> Sensitivity:
    """Compute which parameters of a space a quantity depends on: Sobol indices with intervals, and local elasticities.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario with the values that stay fixed, as for `electrovib.load`.
    space : str, Path, mapping or Space
        Distributions of the others, as for `electrovib.read_space`: ``"fingers"``.
    quantity : str
        Name as for `electrovib.sweep`: ``"mean electrostatic_force"``.
    n : int
        Number of base draws, a power of 2; the scenario is evaluated n (inputs + 2) times.
    seed : int
        Seed of the draws, from 0 to 2**64 - 1.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    sensitivity : Sensitivity
        Indices, elasticities, the sample of the quantity, and ``headline``, which names what to measure first. `electrovib.save`
        writes it into a folder, as ``report.html``, ``indices.csv``, ``elasticities.csv`` and ``space.toml``.

    Raises
    ------
    InputError
        For every mistake in scenario, space and quantity.

    Examples
    --------
    >>> found = ev.sensitivity("bau_2010/sine", "fingers", quantity="mean electrostatic_force", n=64, seed=1)
    >>> found.document.sentences[0].partition(":")[0]
    'Measure stack.gap.thickness first'
    """
    base = read_scenario(scenario)
    found = read_space(base, space)
    named = read_name(" ".join(quantity.split()), tuple(base.stack.layers))
    seed = checked_seed(seed)
    check_power(n)
    prepared = Prepared(base, free=found.paths, quantity=[named.name])
    count = n * (len(found.inputs) + 2)
    meter = Meter.of_cases(
        "this sensitivity analysis",
        f"{count} evaluations",
        count,
        numbers=_HELD,
        remedy="choose a smaller n",
    )
    report = meter.reporting(progress)
    indices = sobol(found, lambda draws: prepared(draws, progress=report)[named.name], n=n, seed=seed)
    return Sensitivity(
        scenario=base,
        space=found,
        quantity=named.name,
        unit=named.unit,
        n=n,
        seed=seed,
        method=prepared.method,
        indices=_ordered(found, indices),
        elasticities=tuple(_elasticities(prepared, found, named.name)),
        sample=indices.sample,
    )


def _ordered(space: Space, indices: Indices) -> tuple[InputIndices, ...]:
    found = [
        InputIndices(
            name=name,
            paths=tuple(each for each in streams if each in space.paths),
            first=float(indices.first[place]),
            first_interval=tuple(indices.first_interval[:, place].tolist()),
            total=float(indices.total[place]),
            total_interval=tuple(indices.total_interval[:, place].tolist()),
        )
        for place, (name, streams) in enumerate(space.inputs.items())
    ]
    return tuple(sorted(found, key=lambda each: -each.total))


def _elasticities(prepared: Prepared, space: Space, quantity: str) -> list[Elasticity]:
    """Differentiate the quantity at the medians."""
    middle = space.values({stream: np.array([0.5]) for stream in space.streams})
    medians = {path: float(value[0]) for path, value in middle.items()}

    def compute(point: Mapping[str, float]) -> float:
        return float(prepared(point)[quantity])

    return elasticities(prepared.base, compute, medians, space.paths, per=compute(medians))


REFERENCES: Final = (
    "I. M. Sobol, Global sensitivity indices for nonlinear mathematical models and their Monte Carlo estimates, Math."
    " Comput. Simul. 55, 271 (2001)",
    "A. Saltelli et al., Variance based sensitivity analysis of model output, Comput. Phys. Commun. 181, 259 (2010)",
)
_NEGLIGIBLE: Final = 0.01
"""Total index below which an input is called without influence."""


@dataclass(frozen=True, kw_only=True)
class InputIndices:
    """Sobol indices of one independent input, with the ends of their 95 % intervals.

    - `name`: a dotted path, a division into groups, or several that depend on each other; `paths`: those of
      its parameters.
    - `first`: part of the variance that would be gone on average if the input were known.
    - `total`: part of the variance that is left on average if all other inputs are known.
    """

    name: str
    paths: tuple[str, ...]
    first: float
    first_interval: tuple[float, float]
    total: float
    total_interval: tuple[float, float]


@dataclass(frozen=True, kw_only=True, repr=False)
class Sensitivity(Answer):
    """Sensitivity of a quantity to the parameters of a space.

    - `scenario`, `space`: values that stay fixed, and distributions of the others.
    - `quantity`, `unit`: name of the quantity and its SI unit.
    - `n`, `seed`: number of base draws, and seed.
    - `method`: how the scenario was evaluated, together or one by one, and why.
    - `indices`: from the largest total index to the smallest.
    - `elasticities`: at the medians of the distributions, in the order of the space.
    - `sample`, shape (2 n,): values of the quantity at independent draws.
    """

    FILES: ClassVar = {"indices.csv": Form.TABLE, "elasticities.csv": Form.TABLE, "space.toml": Form.SPACE}
    scenario: Scenario
    space: Space
    quantity: str
    unit: str
    n: int
    seed: int
    method: str
    indices: tuple[InputIndices, ...]
    elasticities: tuple[Elasticity, ...]
    sample: Real
    answer = former_attribute("answer", "headline", lambda self: self.headline)

    @property
    def document(self) -> Document:
        """The answer, the indices as bars and in tables, and what the space leaves unverified."""
        figure = Drawing(
            id="indices",
            title="Share of each input in the variance",
            caption="The largest total index on top.",
            plot="indices",
            of=self,
        )
        return Document(
            title=f"Sensitivity of {self.quantity}: {self.scenario.titled() or 'a scenario'}",
            sentences=[self.headline],
            diagnostics=self.diagnostics,
            figures=[figure],
            tables=self.tables,
            remarks=self.space.remarks,
            references=REFERENCES,
        )

    def content(self, name: str) -> str:
        """Write the indices or the elasticities as CSV, or the space."""
        if name == "space.toml":
            return f"# {unsigned(Form.SPACE)}\n{self.space.to_toml()}"
        if name == "elasticities.csv":
            local = ((each.path, each.unit, each.at, each.value) for each in self.elasticities)
            return csv_text(("parameter", "unit", "at", "elasticity"), local, diagnostics=self.diagnostics)
        rows = (
            (one.name, " ".join(one.paths), one.first, *one.first_interval, one.total, *one.total_interval)
            for one in self.indices
        )
        ends = (f"{index}{end}" for index in ("first", "total") for end in ("", "_low", "_high"))
        return csv_text(("input", "parameters", *ends), rows, diagnostics=self.diagnostics)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with its own values, not of every draw."""
        return validity(self.scenario)

    @property
    def mean(self) -> float:
        """Mean of the quantity over the space."""
        return float(self.sample.mean())

    @property
    def deviation(self) -> float:
        """Standard deviation of the quantity over the space."""
        return float(self.sample.std())

    @property
    def evaluations(self) -> int:
        """Number of scenarios that were evaluated for the indices."""
        return self.n * (len(self.indices) + 2)

    @property
    def headline(self) -> str:
        """Sentences that name what to measure first, and by how much the prediction would become narrower."""
        first = self.indices[0]
        low, high = first.total_interval
        fall, least, most = (f"{100 * _narrowing(each):.0f}" for each in (first.first, *first.first_interval))
        text = (
            f"Measure {_named(first)} first: of the variance of {self.quantity} it has the largest total index,"
            f" {first.total:.2f} (95 % interval {low:.2f} to {high:.2f}). If it were known exactly, the standard deviation,"
            f" now {self._shown(self.deviation)} at a mean of {self._shown(self.mean)}, would fall by"
            f" {fall} % on average ({least} to {most} %, root mean square; first-order index {first.first:.2f})."
        )
        near = [each.name for each in self.indices[1:] if each.total_interval[1] >= low]
        if near:
            text += f" With n = {self.n} its index is not distinguishable from that of {', '.join(near)}."
        return text + self._between() + self._idle()

    @property
    def tables(self) -> tuple[Table, ...]:
        """Indices and elasticities in words."""
        rows = tuple(
            (
                each.name,
                ", ".join(path for path in each.paths if path != each.name),
                f"{each.first:z.3f}",
                _interval(each.first_interval),
                f"{each.total:z.3f}",
                _interval(each.total_interval),
            )
            for each in self.indices
        )
        headings = ("First-order index", "95 % interval", "Total index", "95 % interval")
        how = self.method.partition(" (")[0]
        caption = (
            f"{self.evaluations} evaluations (n = {self.n}, seed {self.seed}), {how}. Parameters that depend on each other are"
            " one input. The first-order index is the part of the variance that would be gone on average if the input were"
            " known, the total index the part that is left on average if all others are known."
        )
        named = "Parameter", "At", "d ln quantity / d ln parameter"
        local = tuple(
            (each.path, each.shown, f"{each.value:.4g}" if math.isfinite(each.value) else "not defined")
            for each in self.elasticities
        )
        where = "At the medians of the distributions, of groups at those of the group at half of all fingers."
        return (
            Table("Sobol indices", ("Input", "Its parameters", *headings), rows, caption=caption),
            Table("Local elasticities", named, local, caption=where),
        )

    def _shown(self, value: float) -> str:
        return format_quantity(value, self.unit, digits=3)

    def _between(self) -> str:
        """State the part of the variance that is due to inputs together."""
        rest = 1 - sum(each.first for each in self.indices)
        if rest <= _NEGLIGIBLE:
            return ""
        return f" Interactions of the inputs hold {100 * rest:.0f} % of the variance."

    def _idle(self) -> str:
        idle = [each.name for each in self.indices if each.total_interval[1] < _NEGLIGIBLE]
        if not idle:
            return ""
        return f" Without influence (total index below {_NEGLIGIBLE:g}): {', '.join(idle)}."


def _named(each: InputIndices) -> str:
    return each.name if each.name in each.paths else f"{' and '.join(each.paths)} (input '{each.name}')"


def _narrowing(first: float) -> float:
    """Return the part of the standard deviation that goes with the part of the variance of a first-order index."""
    return 1 - math.sqrt(1 - min(max(first, 0.0), 1.0))


def _interval(ends: tuple[float, float]) -> str:
    return f"{ends[0]:z.3f} to {ends[1]:z.3f}"


LEVEL: Final = 0.95
"""Probability of the intervals."""
_RESAMPLES: Final = 999
_BLOCK: Final = 100
"""Resamples that are computed together; it bounds the memory."""
_SMALLEST: Final = 2.0**-53


@dataclass(frozen=True, kw_only=True)
class Indices:
    """Sobol indices of all inputs, ends (2, inputs) of 95 % intervals, and the function at 2 n independent draws."""

    first: Real
    total: Real
    first_interval: Real
    total_interval: Real
    sample: Real


def sobol(space: Space, function: Callable[[Mapping[str, Real]], Real], *, n: int, seed: int) -> Indices:
    """Compute the Sobol indices of a function of the parameters of a space, in the order of ``space.inputs``.

    The function takes arrays (m,) by path and returns values (m,); with n base draws, a power of 2, it is
    evaluated n (inputs + 2) times. Parameters that depend on each other are one input. The estimators are
    those of Saltelli et al. 2010, as in `scipy.stats.sobol_indices` (which fails for a single input), on
    scrambled Sobol points; inputs with relations are random draws, because a draw that breaks a relation is
    repeated. The intervals are percentiles of a bootstrap over the draws.
    """
    check_power(n)
    first, second = _draws(space, n, seed)
    mixtures = (
        first | {path: second[path] for path in streams if path in second}
        for streams in space.inputs.values()
    )
    columns = [first, second, *mixtures]
    joined = {path: np.concatenate([each[path] for each in columns]) for path in first}
    values = np.asarray(function(joined)).reshape(len(columns), n)
    _check_values(values, joined)
    a, b, mixed = values[0], values[1], values[2:]
    terms = _terms(a, b, mixed)
    first_order, total_order = _estimates(np.full((1, n), 1 / n), terms)[0]
    low, high = _bootstrap(terms, np.random.default_rng(seed))
    return Indices(
        first=first_order,
        total=total_order,
        first_interval=np.stack([low[0], high[0]]),
        total_interval=np.stack([low[1], high[1]]),
        sample=np.concatenate([a, b]),
    )


def check_power(n: int) -> None:
    """Refuse a number of draws that is no power of 2."""
    if isinstance(n, bool) or not isinstance(n, (int, np.integer)) or n < 2 or n & (n - 1):
        near = 2 ** max(1, round(float(np.log2(max(float(n), 2.0))))) if isinstance(n, (int, float)) else 4096
        raise InputError(f"n = {n!r}: expected a power of 2, for instance {near}")


def _check_values(values: Real, at: Mapping[str, Real]) -> None:
    flat = values.ravel()
    wrong = ~np.isfinite(flat)
    if wrong.any():
        where = int(np.argmax(wrong))
        point = ", ".join(f"{path} = {each[where]:.4g}" for path, each in at.items())
        raise InputError(
            f"the quantity is not a finite number for a share of {wrong.mean():.2g} of the draws, for instance at {point} (SI)."
            " Truncate the distributions, or choose another quantity"
        )
    if np.ptp(values[:2]) == 0:
        raise InputError(
            "the quantity has the same value for every draw: it does not depend on these parameters"
        )


def _draws(space: Space, n: int, seed: int) -> tuple[dict[str, Real], dict[str, Real]]:
    """Return the values of the parameters in two independent samples of n draws."""
    from scipy.stats import qmc

    related = {path for pair in space.relations for path in pair}
    repeated = [streams for streams in space.inputs.values() if related & set(streams)]
    drawn = {path for streams in repeated for path in streams if path in space.paths}
    streams = [each for each in space.streams if not any(each in other for other in repeated)]
    found: tuple[dict[str, Real], dict[str, Real]] = ({}, {})
    if streams:
        points = qmc.Sobol(2 * len(streams), seed=np.random.default_rng(seed)).random(n)
        points = np.clip(points, _SMALLEST, 1 - _SMALLEST)
        for half, columns in zip(found, np.split(points, 2, axis=1), strict=True):
            shares = dict(zip(streams, np.ascontiguousarray(columns.T), strict=True))
            half.update(space.values(shares))
    if drawn:
        both = space.draw(seed, 0, 2 * n)
        for half, part in zip(found, (slice(0, n), slice(n, 2 * n)), strict=True):
            half.update({path: both[path][part] for path in drawn})
    return found


def _terms(a: Real, b: Real, mixed: Real) -> Real:
    """Return the quantities whose means over the draws give all indices, shape (n, 2 + 2 inputs)."""
    middle = 0.5 * (a.mean() + b.mean())
    a, b, mixed = a - middle, b - middle, mixed - middle
    return np.concatenate([[a + b, a * a + b * b], b * (mixed - a), 0.5 * (a - mixed) ** 2]).T


def _estimates(weights: Real, terms: Real) -> Real:
    """Return first-order and total indices for each row of weights of the draws, shape (rows, 2, inputs)."""
    means = weights @ terms
    variance = means[:, 1] / 2 - (means[:, 0] / 2) ** 2
    found: Real = (means[:, 2:] / variance[:, None]).reshape(len(weights), 2, -1)
    return found


def _bootstrap(terms: Real, generator: np.random.Generator) -> tuple[Real, Real]:
    """Return the ends of percentile intervals of first-order and total indices, each of shape (2, inputs).

    The bootstrap of scipy forms all jackknife samples of its corrected intervals at once, which takes n**2 numbers.
    """
    count, found = len(terms), []
    for start in range(0, _RESAMPLES, _BLOCK):
        size = min(_BLOCK, _RESAMPLES - start)
        weights = generator.multinomial(count, np.full(count, 1 / count), size=size) / count
        found.append(_estimates(weights, terms))
    tail = (1 - LEVEL) / 2
    low, high = np.quantile(np.concatenate(found), [tail, 1 - tail], axis=0)
    return np.asarray(low), np.asarray(high)
