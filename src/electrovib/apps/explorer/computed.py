"""What is computed for a page when a parameter changes."""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.apps.explorer import key_figures
from electrovib.apps.explorer.runner import FINGERS, LARGEST_RUN, LONGEST_RUN, LONGEST_SHORT_RUN
from electrovib.core.budget import BudgetError, budget
from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.force import ForceLaw
from electrovib.physics.perception import Perception
from electrovib.solve.expanded import Expanded
from electrovib.solve.meter import measured
from electrovib.solve.simulate import Simulated, provenance
from electrovib.studies.widths import factor_of
from electrovib.view.style import pretty_quantity
from electrovib.view.summary import quantities_of_scenario

if TYPE_CHECKING:
    import xarray
    from numpy.typing import NDArray

    from electrovib.core.answer import Document
    from electrovib.core.diagnostics import Diagnostic
    from electrovib.scenario import Scenario
    from electrovib.studies.check.result import CheckResult
    from electrovib.studies.evidence import Measurement
    from electrovib.studies.perceive import Percept


@dataclass(frozen=True, eq=False)
class Computed:
    """A scenario as the page shows it, with its signals and their validity."""

    scenario: Scenario
    found: Simulated

    @functools.cached_property
    def trace(self) -> xarray.Dataset:
        """What `electrovib.simulate` returns for the scenario; made when it is first asked for."""
        return self.found.trace(provenance(self.scenario))

    @functools.cached_property
    def figures(self) -> dict[str, key_figures.KeyFigure]:
        """Key figures of the run: forces at the output times, and validity."""
        return key_figures.forces(self) | {key_figures.VALIDITY: key_figures.validity(self.diagnostics)}

    @property
    def diagnostics(self) -> list[Diagnostic]:
        """Statements on the validity."""
        return list(self.found.diagnostics)

    def has(self, name: str) -> bool:
        """Return whether there is a signal of this name."""
        return name in self.found.variables

    def dimensions(self, name: str) -> tuple[str, ...]:
        """Return the names of the dimensions of a signal."""
        return tuple(self.found.variables[name][0])

    def values(self, name: str, *, layer: str = "") -> NDArray[Any]:
        """Return the array of a signal, or of one of its dimensions, in SI, without a copy; `layer` picks one row."""
        if name in self.found.coordinates:
            return self.found.coordinates[name]
        dimensions, values = self.found.variables[name]
        if not layer:
            return np.asarray(values)
        row = list(self.found.coordinates["layer"]).index(layer)
        rows: NDArray[Any] = np.moveaxis(np.asarray(values), list(dimensions).index("layer"), 0)
        return np.asarray(rows[row])


def compute(scenario: Scenario, *, longest: float = LONGEST_RUN) -> Computed:
    """Simulate a scenario within the time and memory that a page allows; a run that takes more is refused or ended.

    `longest` is the largest computing time [s].
    """
    with budget(time=longest, memory=LARGEST_RUN), measured():
        return Computed(scenario, Simulated.of(Expanded(scenario)))


TIME, FADING, FREQUENCY, LAWS, FELT, SAFETY, RECORDING = TABS = (
    "Over time",
    "Why it fades",
    "Over frequency",
    "Force laws",
    "Felt",
    "Safety",
    "Recording",
)
POPULATION: Final = "fingers"
PEAK: Final = "peak electrostatic_force"
SEED: Final = 1
"""Of the draws from the population: the same fingers at every position of a slider, so that the band moves smoothly."""


@dataclass(frozen=True)
class Further:
    """Results beside the Trace; each is None, or empty, until it is computed.

    `band` has ``frequency`` [Hz], ``low``, ``middle`` and ``high`` [N], each (n,): 5, 50 and 95 % of the
    fingers of a `population`, which is what the study of it says. `measured` is what somebody measured in this set-up, `laws`
    are other force laws on the same finger and plate, and `left_out` those that cannot run here, with the reason.
    `percept` is what is felt, `check` the comparison with limits, and `forces` are exact key figures; `unanswered`
    is the name of a key figure to the reason why it is not known. `problems` says what could not be computed for
    the open tab.
    """

    band: Mapping[str, NDArray[Any]] | None = None
    population: Document | None = None
    measured: MeasuredForce | None = None
    laws: Mapping[str, Computed] = field(default_factory=dict)
    left_out: Mapping[str, str] = field(default_factory=dict)
    percept: Percept | None = None
    check: CheckResult | None = None
    forces: Mapping[str, key_figures.KeyFigure] = field(default_factory=dict)
    unanswered: Mapping[str, str] = field(default_factory=dict)
    problems: tuple[str, ...] = ()


Slice = Callable[[Further], Further]


def slices(tab: str, found: Computed) -> Iterator[Slice]:
    """Return the pieces of work that a tab needs beside the Trace, each short.

    Each takes what is known so far and returns it with one more result. A mistake becomes a sentence in
    `problems`.
    """
    works = {
        FREQUENCY: (_with_band, "The band of fingers"),
        FELT: (_with_percept, "What is felt"),
        SAFETY: (_with_check, "The comparison with limits"),
    }
    if tab in works:
        yield functools.partial(_guarded, *works[tab], found=found)
    for name in find_members(ForceLaw) if tab == LAWS else ():
        if name != type(found.scenario.force).__name__:
            yield functools.partial(_with_law, found=found, name=name)
    if tab == LAWS:
        yield functools.partial(_with_measured, found=found)


def with_answers(known: Further, found: Computed) -> Further:
    """Add what the key figures state beside the run, where it is short and not known yet."""
    if not known.forces:
        known = replace(known, forces=key_figures.exact_forces(found))
    for name, tab, work in (
        (key_figures.FELT, FELT, _with_percept),
        (key_figures.LIMIT, SAFETY, _with_check),
    ):
        if name in key_figures.answers(known):
            continue
        try:
            with budget(time=LONGEST_SHORT_RUN, memory=LARGEST_RUN):
                known = work(known, found)
        except BudgetError:
            why = f"takes longer: open the tab '{tab}'"
            known = replace(known, unanswered={**known.unanswered, name: why})
        except ElectrovibError as error:
            known = replace(known, unanswered={**known.unanswered, name: str(error)})
    return known


def _with_percept(known: Further, found: Computed) -> Further:
    from electrovib.studies.perceive import perceived

    person = found.scenario.perception or Perception()
    return replace(known, percept=perceived(found.scenario, person, diagnostics=tuple(found.diagnostics)))


def _with_check(known: Further, found: Computed) -> Further:
    from electrovib.studies.check import check

    return replace(known, check=check(found.scenario))


def _guarded(
    work: Callable[[Further, Computed], Further], what: str, known: Further, *, found: Computed
) -> Further:
    try:
        return work(known, found)
    except ElectrovibError as error:
        problem = f"{what} is not shown: {error}"
        return replace(known, band=None, population=None, problems=(*known.problems, problem))


def _with_band(known: Further, found: Computed) -> Further:
    """Add the band of a population; parameters that the scenario lacks are not drawn."""
    from electrovib.studies.population import study

    scenario = found.scenario
    if "stratum_corneum" not in scenario.stack.layers and scenario.load.normal_force == 0:
        raise InputError(
            "the contact has neither skin nor load, so it is not that of a finger, and no population of fingers describes it"
        )
    bands = study(scenario, _population(), n=FINGERS, seed=SEED, quantity="mean_force")
    low, middle, high = (bands["mean_force_percentile"].sel(percentile=each).values for each in (5, 50, 95))
    band = {"frequency": bands["frequency"].values, "low": low, "middle": middle, "high": high}
    return replace(known, band=band, population=bands.document)


@functools.cache
def _population() -> dict[str, Any]:
    """Return the population with every entry optional: a parameter that a scenario lacks is then not drawn."""
    from electrovib.scenario.space.shipped import read_shipped

    tables = read_shipped(POPULATION)
    for space in _spaces(tables):
        for entry in space.values():
            entry["optional"] = True
    return tables


def _spaces(tables: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return the tables of distributions of a population: that of all fingers, and those of its groups."""
    groups = [group for each in tables.get("groups", {}).values() for group in each.values()]
    return [each["space"] for each in (tables, *groups) if "space" in each]


@dataclass(frozen=True)
class MeasuredForce:
    """What somebody measured in the set-up of the page, and the interval of the largest attraction that gives it [N]."""

    name: str
    words: str
    interval: tuple[float, float]


@functools.cache
def _measured_forces() -> list[Measurement]:
    from electrovib.studies.evidence.files import measurements

    return [
        each
        for each in measurements().values()
        if each.judges == "force" and isinstance(each.quantity, str) and not each.per and not each.over
    ]


_SET_UP: Final = ("drive", "friction", "contact", "load", "motion", "circuit", "stack")
"""What an experiment consists of; a gap belongs to the law rather than to what was measured."""


def _printed(scenario: Scenario, unknown: Iterable[str]) -> dict[str, Any]:
    """Return the drive and the numbers of an experiment, but those that a publication leaves open."""
    left_out = ("stack.gap.", *unknown)
    numbers = {path: value for path, value, _ in scenario.parameters() if path.startswith(_SET_UP)}
    kept = {path: value for path, value in numbers.items() if not path.startswith(left_out)}
    return kept | {"drive": type(scenario.drive)}


def _with_measured(known: Further, *, found: Computed) -> Further:
    """Add the first measurement of the set-up whose quantity is proportional to the attraction."""
    scenario = found.scenario
    for each in _measured_forces():
        quantity = str(each.quantity)
        is_other = _printed(scenario, each.unknown) != _printed(each.scenario, each.unknown)
        if is_other or factor_of(scenario, quantity) is None:
            continue
        computed = quantities_of_scenario(scenario, (quantity, PEAK), quick=True)
        if not computed.get(quantity):
            continue
        (value,), (spread,) = each.values, each.spread
        largest = computed[PEAK] * value / (each.scale * computed[quantity])
        words = (
            f"Measured in this set-up: {each.title}, {pretty_quantity(value, each.unit, digits=3)} ({each.source}; standard"
            f" deviation {100 * spread:.0f} % between {each.spread_of}). With the friction of this scenario this takes a largest"
            f" attraction of {pretty_quantity(largest, 'N', digits=3)}."
        )
        interval = largest / (1 + spread), largest * (1 + spread)
        return replace(known, measured=MeasuredForce(f"measured: {each.source}", words, interval))
    return replace(known, measured=None)


def _with_law(known: Further, *, found: Computed, name: str) -> Further:
    try:
        case = compute(found.scenario.replace({"force": {"model": name}}))
    except ElectrovibError as error:
        return replace(known, left_out={**known.left_out, name: _reason(error, name)})
    return replace(known, laws={**known.laws, name: case})


def _reason(error: ElectrovibError, name: str) -> str:
    """Return why a law cannot run, and for one with parameters of its own how it can be shown."""
    problems = getattr(error, "problems", ())
    missing = [each.path for each in problems if each.reason.startswith("missing")]
    if not missing:
        return str(error)
    return f"it needs {' and '.join(missing)}: choose {name} as the force law, which then begins with example values"
