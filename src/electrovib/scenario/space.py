"""A space of parameters: dotted paths with probability distributions, and relations between them."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError, nearest
from electrovib.core.paths import quantity_at
from electrovib.core.units import parse_quantity
from electrovib.scenario.distributions import Distribution

if TYPE_CHECKING:
    from electrovib.core.quantity import Quantity
    from electrovib.scenario.experiment import Scenario

_WITHOUT_UNIT = frozenset({"factor"})


@dataclass(frozen=True, kw_only=True)
class Space:
    """Parameters of a scenario, each with a probability distribution.

    Parameters
    ----------
    distributions : mapping of str to Distribution
        Dotted path to the distribution of its values, in SI.
    relations : tuple of (str, str)
        Pairs of paths; the value of the first is always less than that of the second.
    """

    distributions: Mapping[str, Distribution]
    relations: tuple[tuple[str, str], ...] = field(default=())

    @property
    def paths(self) -> tuple[str, ...]:
        """Dotted paths of the parameters, in the order in which they were declared."""
        return tuple(self.distributions)

    def values(self, shares: Real) -> dict[str, Real]:
        """Return the values of the parameters at given cumulative probabilities.

        Parameters
        ----------
        shares : ndarray, shape (parameters, n)
            Cumulative probabilities, dimensionless, above 0 and below 1; one row for each of `paths`.

        Returns
        -------
        values : dict of str to ndarray, shape (n,)
            Path to values in SI; they need not fulfil the relations, see `allowed`.
        """
        return {
            path: each.value(row)
            for (path, each), row in zip(self.distributions.items(), np.atleast_2d(shares), strict=True)
        }

    def allowed(self, values: Mapping[str, Real]) -> Any:
        """Return which points fulfil the relations.

        Parameters
        ----------
        values : mapping of str to ndarray, shape (n,)
            Path to values in SI.

        Returns
        -------
        allowed : ndarray of bool, shape (n,)
            True where the first value of every relation is less than its second.
        """
        first = np.asarray(next(iter(values.values())))
        kept = np.ones(first.shape, bool)
        for less, more in self.relations:
            kept &= np.asarray(values[less]) < np.asarray(values[more])
        return kept


def read_space(
    scenario: Scenario, table: Mapping[str, Any], *, relations: tuple[str, ...] | list[str] = ()
) -> Space:
    """Read a space of the parameters of a scenario from a table of a TOML file.

    Parameters
    ----------
    scenario : Scenario
        Scenario that has the parameters.
    table : mapping of str to mapping
        Dotted path to ``{ model = "Normal", mean = "5 um", deviation = "1 um" }``; numbers in SI, texts with a unit.
    relations : sequence of str
        ``"PATH < PATH"``.

    Returns
    -------
    space : Space
        Distributions in SI.

    Raises
    ------
    InputError
        Every mistake at once.
    """
    problems: list[str] = []
    found: dict[str, Distribution] = {}
    for path, content in table.items():
        try:
            found[path] = _read_distribution(path, content, quantity_at(scenario, path))
        except InputError as error:
            problems += error.problems
    pairs = []
    for text in relations:
        less, sign, more = (part.strip() for part in text.partition("<"))
        unknown = [path for path in (less, more) if path not in table]
        if not sign or unknown:
            why = f"'{unknown[0]}' is not in the space" if sign else "expected PATH < PATH"
            problems.append(f"relations: {text}: {why}")
        pairs.append((less, more))
    if problems:
        raise InputError(problems)
    return Space(distributions=found, relations=tuple(pairs))


def _read_distribution(path: str, content: Any, quantity: Quantity) -> Distribution:
    """Read one table in the unit of its parameter, and check its ends against the range of the parameter."""
    known = {kind.__name__: kind for kind in Distribution.__subclasses__()}
    if not isinstance(content, Mapping) or content.get("model") not in known:
        name = content.get("model") if isinstance(content, Mapping) else content
        raise InputError(
            f"{path}: expected a table with the model of a distribution.{nearest(str(name), known)}"
        )
    kind = known[str(content["model"])]
    names = [each.name for each in dataclasses.fields(kind)]  # type: ignore[arg-type]
    foreign = [name for name in content if name not in {"model", *names}]
    if foreign:
        raise InputError(
            f"{path}.{foreign[0]}: unknown parameter of {kind.__name__}.{nearest(foreign[0], names)}"
        )
    numbers = {
        name: _number(f"{path}.{name}", value, "1" if name in _WITHOUT_UNIT else quantity.unit)
        for name, value in content.items()
        if name != "model"
    }
    try:
        found = kind(**numbers)
    except TypeError:
        missing = [name for name in names if name not in numbers]
        raise InputError(f"{path}.{missing[0]}: missing parameter of {kind.__name__}") from None
    except InputError as error:
        raise InputError(f"{path}: {problem}" for problem in error.problems) from None
    _hold_within(path, found, quantity)
    return found


def _hold_within(path: str, found: Distribution, quantity: Quantity) -> None:
    """Refuse ends beyond the range of a parameter; a distribution without ends is limited by the scenario, value by value."""
    for end in found.ends:
        if math.isfinite(end) and end and not quantity.low <= end <= quantity.high:
            raise InputError(f"{path}: values up to {end:g} {quantity.unit}, allowed is {quantity.range()}")


def _number(path: str, value: Any, unit: str) -> Any:
    if isinstance(value, (list, tuple)):
        return tuple(_number(path, each, unit) for each in value)
    if isinstance(value, str):
        try:
            return parse_quantity(value, unit)
        except ValueError as error:
            raise InputError(f"{path} = {value}: {error}") from None
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        raise InputError(f"{path} = {value!r}: expected a number, or a text with a unit")
    return float(value)
