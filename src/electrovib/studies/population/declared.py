"""What a study is: scenario, space, number of fingers, seed and the statistics that are asked for."""

from __future__ import annotations

import json
import math
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Final

from electrovib.core.budget import amount_of_memory
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.own_models import use_models, used_files
from electrovib.core.samples import Samples
from electrovib.core.signals import SIGNALS, STUDY_FORMAT
from electrovib.core.units import parse_quantity
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.scenario.space import Space, SpaceSource, read_space
from electrovib.scenario.space.relations import checked_seed
from electrovib.scenario.space.writing import KEYS as ORIGIN_KEYS
from electrovib.scenario.toml import SCHEMA

FORMAT: Final = f"{STUDY_FORMAT} 3"
"""Value of the attribute ``format`` of a store and of a result."""
BLOCK: Final = 1024
"""Number of fingers whose signals are computed together, and that a chunk of a store holds."""
PERCENTILES: Final = (5.0, 50.0, 95.0)
PART_OF_MEMORY: Final = 0.25
"""Share of the memory allowed that the values from which percentiles are taken may have."""
_MOST_FINGERS: Final = 10**12


@dataclass(frozen=True, kw_only=True)
class DeclaredStudy:
    """A study before it is run.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that are common to all fingers.
    space : Space
        Parameters that differ between fingers, with their distributions.
    fingers : int
        Number of fingers drawn.
    seed : int
        Seed of the draws, 0 or above.
    signals : tuple of str
        Signals over time, or over frequency.
    percentiles : tuple of float
        Percentiles of the bands, above 0 and below 100 [%]; increasing.
    thresholds : dict of str to tuple of float
        Signal to the values whose exceedance is counted, in the SI unit of the signal; increasing.
    records : bool
        Whether the signals of every finger are kept.
    memory : float
        Memory for the values from which the percentiles are taken [bytes].
    """

    scenario: Scenario
    space: Space
    fingers: int
    seed: int
    signals: tuple[str, ...]
    percentiles: tuple[float, ...]
    thresholds: Mapping[str, tuple[float, ...]]
    records: bool
    memory: float

    @property
    def axis(self) -> str:
        """Dimension over which the signals run, ``time`` or ``frequency``."""
        return SIGNALS[self.signals[0]].dims[0]

    def identity(self) -> dict[str, Any]:
        """Return what distinguishes this study from another one whose results differ, as structured text."""
        return {
            "scenario": self.scenario.canonical(),
            "space": json.dumps(_without_origins(_plain(self.space.as_table())), sort_keys=True),
            "n": self.fingers,
            "seed": self.seed,
            "quantity": list(self.signals),
            "percentiles": list(self.percentiles),
            "exceed": {name: list(values) for name, values in self.thresholds.items()},
            "records": self.records,
        }

    def to_text(self) -> str:
        """Write the study as one text that `from_text` reads: scenario and space as TOML, never as objects."""
        numbers = {field.name: getattr(self, field.name) for field in fields(self)}
        texts = {"scenario": scenario_text(self.scenario), "space": self.space.to_toml()}
        return json.dumps(numbers | texts | {"own_models": used_files()})

    @classmethod
    def from_text(cls, text: str) -> DeclaredStudy:
        """Read a study from the text of `to_text`."""
        content = json.loads(text)
        for file in content.pop("own_models"):
            use_models(file)
        scenario = read_scenario(tomllib.loads(content["scenario"]))
        space = read_space(scenario, tomllib.loads(content["space"]))
        tuples = {name: tuple(content[name]) for name in ("signals", "percentiles")}
        thresholds = {name: tuple(values) for name, values in content["thresholds"].items()}
        return cls(**content | tuples | {"scenario": scenario, "space": space, "thresholds": thresholds})


def read_study(
    scenario: Source,
    space: SpaceSource,
    *,
    n: int,
    seed: int,
    quantity: str | Sequence[str],
    percentiles: Sequence[float | str],
    exceed: Sequence[str | float] | str | float,
    records: bool,
    budget_memory: float | str,
) -> DeclaredStudy:
    """Read the arguments of `electrovib.study`, and report all mistakes at once."""
    problems: list[str] = []
    names = tuple(dict.fromkeys([quantity] if isinstance(quantity, str) else quantity))
    problems += _signal_problems(names)
    if isinstance(n, bool) or not isinstance(n, int) or not 1 <= n <= _MOST_FINGERS:
        problems.append(
            f"n = {n}: expected a number of fingers, a whole number from 1 to {_MOST_FINGERS:.0e}"
        )
    with gathered(problems):
        checked_seed(seed)
    with gathered(problems):
        shares = _percentiles(percentiles)
    with gathered(problems):
        thresholds = {} if _signal_problems(names) else _thresholds(names, exceed)
    with gathered(problems):
        memory = amount_of_memory("budget_memory", budget_memory)
    with gathered(problems):
        found = read_scenario(scenario)
        described = read_space(found, space)
    refuse(problems)
    return DeclaredStudy(
        scenario=found,
        space=described,
        fingers=n,
        seed=seed,
        signals=names,
        percentiles=shares,
        thresholds=thresholds,
        records=bool(records),
        memory=memory,
    )


def _signal_problems(names: Sequence[str]) -> list[str]:
    """List the names that are no signal over time or frequency, and signals over different axes."""
    known = {name: each.dims[0] for name, each in SIGNALS.items() if len(each.dims) == 1}
    problems = [
        f"quantity = {name}: not a signal of a study.{nearest(name, known)}"
        for name in names
        if name not in known
    ]
    if not names:
        problems.append("quantity: name at least one, for instance electrostatic_force")
    if not problems and len({known[name] for name in names}) > 1:
        listed = ", ".join(f"{name} over {known[name]}" for name in names)
        problems.append(f"quantity: {listed}; expected signals over the same axis, run two studies")
    return problems


def _percentiles(given: Sequence[float | str]) -> tuple[float, ...]:
    try:
        found = sorted({float(each) for each in given})
    except (TypeError, ValueError):
        raise InputError(f"percentiles = {given!r}: expected numbers, for instance 5, 50, 95") from None
    wrong = [each for each in found if not 0 < each < 100]
    if wrong:
        raise InputError(f"percentiles = {wrong[0]:g}: expected numbers above 0 and below 100")
    if found and found[-1] < 1:
        meant = ", ".join(f"{100 * each:g}" for each in found)
        raise InputError(f"percentiles = {given!r}: they are in per cent; write {meant}")
    return tuple(found)


def _thresholds(
    names: Sequence[str], exceed: Sequence[str | float] | str | float
) -> dict[str, tuple[float, ...]]:
    """Read each threshold in the unit of the signals that have this unit; a bare number is one of the first signal."""
    given = [exceed] if isinstance(exceed, (str, float, int)) else list(exceed)
    found = {name: set[float]() for name in names}
    problems = []
    for each in given:
        read = {name: value for name in names if (value := _in_unit(each, SIGNALS[name].unit)) is not None}
        if not read:
            units = ", ".join(dict.fromkeys(SIGNALS[name].unit for name in names))
            problems.append(f"exceed = {each}: expected a value in {units}, for instance '5 m{units[:1]}'")
        for name, value in read.items() if isinstance(each, str) else list(read.items())[:1]:
            found[name].add(value)
    refuse(problems)
    return {name: tuple(sorted(values)) for name, values in found.items() if values}


def _in_unit(given: str | float, unit: str) -> float | None:
    try:
        value = parse_quantity(given, unit) if isinstance(given, str) else float(given)
    except (TypeError, ValueError):
        return None
    return value if math.isfinite(value) else None


def scenario_text(scenario: Scenario) -> str:
    """Write a scenario as TOML, with the samples of measured series in the text."""
    import tomlkit

    content = {"schema": SCHEMA} | scenario.to_dict()
    return tomlkit.dumps(_plain(content))


def _without_origins(content: Any) -> Any:
    """Omit titles and sources, on which no draw depends."""
    if not isinstance(content, Mapping):
        return content
    return {
        key: _without_origins(each) for key, each in content.items() if key not in {"title", *ORIGIN_KEYS}
    }


def _plain(content: Any) -> Any:
    """Return tables, lists, texts and numbers alone; a value that is absent is omitted, which is how TOML writes it."""
    if isinstance(content, Samples):
        return _plain(content.packed())
    if isinstance(content, Mapping):
        return {str(key): _plain(value) for key, value in content.items() if value is not None}
    if isinstance(content, (list, tuple)):
        return [_plain(each) for each in content]
    return content
