"""Results of a sensitivity analysis."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar, Final

from electrovib.core.answer import Answer, Document, Drawing, Table
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.units import format_quantity
from electrovib.data.csv_text import csv_text
from electrovib.data.marks import Form, unsigned
from electrovib.solve.quantities.answer import validity

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.scenario.space import Space
    from electrovib.studies.elasticity import Elasticity

INDICES: Final = (
    "Input",
    "Its parameters",
    "First-order index",
    "95 % interval",
    "Total index",
    "95 % interval",
)
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
            title=f"Sensitivity of {self.quantity}: {self.scenario.title or 'a scenario'}",
            sentences=[self.answer],
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
        rows: list[tuple[object, ...]] = [
            (
                each.name,
                " ".join(each.paths),
                each.first,
                *each.first_interval,
                each.total,
                *each.total_interval,
            )
            for each in self.indices
        ]
        headings: tuple[str, ...] = (
            "input",
            "parameters",
            "first",
            "first_low",
            "first_high",
            "total",
            "total_low",
            "total_high",
        )
        if name == "elasticities.csv":
            rows = [(each.path, each.unit, each.at, each.value) for each in self.elasticities]
            headings = ("parameter", "unit", "at", "elasticity")
        return csv_text(headings, rows, diagnostics=self.diagnostics)

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
    def answer(self) -> str:
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
        how = self.method.partition(" (")[0]
        caption = (
            f"{self.evaluations} evaluations (n = {self.n}, seed {self.seed}), {how}. Parameters that depend on each other are"
            " one input. The first-order index is the part of the variance that would be gone on average if the input were"
            " known, the total index the part that is left on average if all others are known."
        )
        local = tuple(
            (each.path, format_quantity(each.at, each.unit, digits=4), _number(each.value))
            for each in self.elasticities
        )
        return (
            Table("Sobol indices", INDICES, rows, caption=caption),
            Table(
                "Local elasticities",
                ("Parameter", "At", "d ln quantity / d ln parameter"),
                local,
                caption="At the medians of the distributions, of groups at those of the group at half of all fingers.",
            ),
        )

    def _shown(self, value: float) -> str:
        return format_quantity(value, self.unit, digits=3)

    def _between(self) -> str:
        """State the part of the variance that is due to inputs together."""
        rest = 1 - sum(each.first for each in self.indices)
        return (
            f" Interactions of the inputs hold {100 * rest:.0f} % of the variance."
            if rest > _NEGLIGIBLE
            else ""
        )

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


def _number(value: float) -> str:
    return f"{value:.4g}" if math.isfinite(value) else "not defined"
