"""A space of parameters: dotted paths with probability distributions, correlations, relations and groups."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.errors import InputError
from electrovib.scenario.space.relations import checked_seed, connected, fulfil, uniform_shares
from electrovib.scenario.space.writing import space_lines, space_table

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping

    from numpy.typing import NDArray

    from electrovib.scenario.distributions import Distribution
    from electrovib.scenario.space.relations import Grouping
    from electrovib.scenario.space.writing import Origin

_OF_GROUP: Final = "groups of "
"""Begin of the name of the stream that chooses the group."""
_BLOCK: Final = 16384
"""Draws that are computed together."""


@dataclass(frozen=True, kw_only=True, repr=False)
class Space:
    """Parameters of a scenario, each with a probability distribution.

    Parameters
    ----------
    distributions : mapping of str to Distribution
        Dotted path to the distribution of its values, in SI.
    correlations : mapping of (str, str) to float
        Pair of paths to the correlation coefficient of their normal variables (Gaussian copula); other pairs have 0.
    relations : tuple of (str, str)
        Pairs of paths; the value of the first is always less than that of the second.
    groupings : mapping of str to Grouping
        Name to a division of the population into groups with distributions of their own, which replace those in
        `distributions`.
    title : str
        What the population is.
    units : mapping of str to str
        Dotted path to the SI unit of its values, for texts.
    origins : mapping of str to Origin
        Dotted path to the source of its distribution; ``groups.NAME.GROUP`` to that of a share, with a path behind it to
        that of a distribution of the group.
    omitted : mapping of str to str
        Dotted path of an optional entry that the scenario cannot take, to the reason.

    Notes
    -----
    Draw i of a parameter depends on the seed, the path and i alone: another parameter in the space, and other draws in the
    same call, change nothing.
    """

    distributions: Mapping[str, Distribution] = field(default_factory=dict)
    correlations: Mapping[tuple[str, str], float] = field(default_factory=dict)
    relations: tuple[tuple[str, str], ...] = ()
    groupings: Mapping[str, Grouping] = field(default_factory=dict)
    title: str = ""
    units: Mapping[str, str] = field(default_factory=dict)
    origins: Mapping[str, Origin] = field(default_factory=dict)
    omitted: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Refuse what does not fit together: every mistake at once."""
        problems = [*wrong_groups(self), *wrong_pairs(self)]
        if problems:
            raise InputError(problems)
        self._copula  # noqa: B018  # refuses correlations that contradict each other

    def __repr__(self) -> str:
        """Write title, distributions, correlations, relations and groups, a line each."""
        return "\n  ".join([f"Space: {self.title or 'without a title'}", *space_lines(self)])

    @functools.cached_property
    def paths(self) -> tuple[str, ...]:
        """Dotted paths of the parameters, in the order in which they were declared."""
        own = (path for grouping in self.groupings.values() for path in grouping.paths)
        return tuple(dict.fromkeys([*self.distributions, *own]))

    @functools.cached_property
    def streams(self) -> tuple[str, ...]:
        """Names of the independent random numbers of a draw: the paths, and one for each division into groups."""
        return (*self.paths, *(f"{_OF_GROUP}{name}" for name in self.groupings))

    @functools.cached_property
    def inputs(self) -> dict[str, tuple[str, ...]]:
        """Name to the streams of each independent input: parameters that depend on each other are one input."""
        groups = [(f"{_OF_GROUP}{name}", *each.paths) for name, each in self.groupings.items()]
        sets = connected(self.streams, [*self.correlations, *self.relations, *groups])
        return {" + ".join(self._names_of(each)): each for each in sets}

    def values(self, shares: Mapping[str, Real]) -> dict[str, Real]:
        """Return the values of parameters at given independent cumulative probabilities.

        Parameters
        ----------
        shares : mapping of str to ndarray, shape (n,)
            Stream, as in `streams`, to cumulative probabilities, dimensionless, above 0 and below 1. Of parameters that
            depend on each other all streams are needed.

        Returns
        -------
        values : dict of str to ndarray, shape (n,)
            Path to values in SI, correlated and of their groups; they need not fulfil the relations, see `allowed`.
        """
        coupled = self._copula.applied(shares)
        found = {}
        for path in (each for each in self.paths if each in shares):
            name = self._grouping_of.get(path)
            default = self.distributions.get(path)
            if name is not None:
                grouping = self.groupings[name]
                chosen = grouping.chosen(shares[f"{_OF_GROUP}{name}"])
                found[path] = grouping.values(path, coupled[path], chosen, default)
            elif default is not None:
                found[path] = default.value(coupled[path])
        return found

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
            if less in values and more in values:
                kept &= np.asarray(values[less]) < np.asarray(values[more])
        return kept

    def draw(self, seed: int, start: int, stop: int) -> dict[str, Real]:
        """Draw the values of consecutive fingers.

        Parameters
        ----------
        seed : int
            0 or more, below 2**64.
        start, stop : int
            Number of the first draw, and of the one after the last.

        Returns
        -------
        values : dict of str to ndarray, shape (stop - start,)
            Path to values in SI, which fulfil the relations. Draw i is the same, bit for bit, for any `start` and `stop`.

        Raises
        ------
        InputError
            If a seed or a range is not possible, or a relation is hardly ever fulfilled.

        Notes
        -----
        A draw that does not fulfil a relation is repeated, with the parameters that depend on it; its group is kept, so
        that the groups have the shares that are declared.
        """
        seed = checked_seed(seed)
        if not 0 <= start <= stop:
            raise InputError(f"draws {start} to {stop}: expected 0 <= start <= stop")
        found = {path: np.empty(stop - start) for path in self.paths}
        for first in range(start, stop, _BLOCK):  # whose arrays stay in the cache
            last = min(first + _BLOCK, stop)
            values = self.values(self.shares_of(self.paths, seed=seed, start=first, stop=last, attempt=0))
            if self.relations:
                fulfil(self, values, seed=seed, start=first)
            for path, each in values.items():
                found[path][first - start : last - start] = each
        return found

    def draw_groups(self, seed: int, start: int, stop: int) -> dict[str, NDArray[np.str_]]:
        """Return the groups of consecutive fingers, those of `draw`.

        Parameters
        ----------
        seed : int
            0 or more, below 2**64.
        start, stop : int
            Number of the first draw, and of the one after the last.

        Returns
        -------
        groups : dict of str to ndarray of str, shape (stop - start,)
            Name of a division of the population to the name of the group of each draw.
        """
        seed, found = checked_seed(seed), {}
        for name, grouping in self.groupings.items():
            share = uniform_shares(f"{_OF_GROUP}{name}", seed=seed, start=start, stop=stop)
            found[name] = np.array(list(grouping.groups), dtype=np.str_)[grouping.chosen(share)]
        return found

    def related(self) -> tuple[tuple[str, ...], ...]:
        """Return the sets of paths that are drawn again together where one of their relations is not fulfilled."""
        links = [*self.correlations, *self.relations]
        within = {path for pair in self.relations for path in pair}
        return tuple(each for each in connected(self.paths, links) if within & set(each))

    def shares_of(
        self, paths: Collection[str], *, seed: int, start: int, stop: int, attempt: int
    ) -> dict[str, Real]:
        """Return the independent shares of some paths at a repetition; those that choose the group are always the first.

        Parameters
        ----------
        paths : collection of str
            Dotted paths.
        seed, start, stop : int
            As for `draw`.
        attempt : int
            Number of the repetition, 0 for the first draw.

        Returns
        -------
        shares : dict of str to ndarray, shape (stop - start,)
            Stream to cumulative probabilities, above 0 and below 1.
        """
        found = {
            path: uniform_shares(path, seed=seed, start=start, stop=stop, attempt=attempt) for path in paths
        }
        for name in {self._grouping_of[path] for path in paths if path in self._grouping_of}:
            stream = f"{_OF_GROUP}{name}"
            found[stream] = uniform_shares(stream, seed=seed, start=start, stop=stop)
        return found

    @property
    def remarks(self) -> tuple[str, ...]:
        """Sentences to print wherever the space is used: entries that are unverified, and entries that were omitted."""
        unverified = [where for where, origin in self.origins.items() if origin.is_unverified]
        found = [f"{where}: the distribution is {self.origins[where].in_words}" for where in unverified]
        return (*found, *(f"{path} is not drawn: {why}" for path, why in self.omitted.items()))

    def as_table(self) -> dict[str, Any]:
        """Return the space as nested tables with numbers in SI, from which `read_space` makes an equal one."""
        return space_table(self)

    def to_toml(self) -> str:
        """Return the space as the text of a TOML file, from which `read_space` makes an equal one."""
        import tomlkit

        return tomlkit.dumps(space_table(self, texts=True))

    @functools.cached_property
    def _copula(self) -> Copula:
        return Copula(self.paths, self.correlations)

    @functools.cached_property
    def _grouping_of(self) -> dict[str, str]:
        return {path: name for name, each in self.groupings.items() for path in each.paths}

    def _names_of(self, streams: tuple[str, ...]) -> list[str]:
        """Return the names under which an input is shown: a division into groups stands for the paths that it sets."""
        groups = [each for each in streams if each.startswith(_OF_GROUP)]
        set_by_them = {path for each in groups for path in self.groupings[each.removeprefix(_OF_GROUP)].paths}
        return groups + [each for each in streams if each not in groups and each not in set_by_them]


def wrong_groups(space: Space) -> list[str]:
    """List parameters that two divisions set, and those that some groups of a division lack."""
    found = []
    for name, grouping in space.groupings.items():
        for other in [other for other in space.groupings if other < name]:
            both = set(grouping.paths) & set(space.groupings[other].paths)
            found += [f"groups.{name}: {path} is set by groups.{other} too" for path in sorted(both)]
        for label, group in grouping.groups.items():
            missing = [p for p in grouping.paths if p not in {*group.distributions, *space.distributions}]
            found += [
                f"groups.{name}.{label}: {path} is set by other groups; give its distribution here, or in [space] for"
                " the groups that have none"
                for path in missing
            ]
    return found


def wrong_pairs(space: Space) -> list[str]:
    """List relations and correlations that are not between two parameters of the space."""
    found = []
    for first, second in space.relations:
        foreign = [path for path in (first, second) if path not in space.paths]
        found += [f"relations: {first} < {second}: '{path}' is not in the space" for path in foreign]
    for (first, second), value in space.correlations.items():
        pair = f"correlation: {first} ~ {second}"
        foreign = [path for path in (first, second) if path not in space.paths]
        found += [f"{pair}: '{path}' is not in the space" for path in foreign]
        if first == second or (second, first) in space.correlations:
            found.append(f"{pair}: expected each pair of two different parameters once")
        if not -1 <= value <= 1:
            found.append(f"{pair} = {value:g}: expected a coefficient from -1 to 1")
    return found


_ROUNDING: Final = 1e-12
"""How far below 0 rounding can bring a pivot of a matrix that is positive semidefinite."""
_SMALLEST: Final = 2.0**-53
"""Distance of a share from 0 and 1 at least."""
_TRIALS: Final = np.linspace(-1, 1, 201)
"""Coefficients that are tried in place of one that contradicts the others."""


class Copula:
    """Gaussian copula: normal variables with given correlations make the shares of the parameters dependent.

    `correlations` maps a pair of parameters to the correlation coefficient r of their normal variables; other
    pairs have 0. Where no normal variables have these correlations, the pair whose coefficient has to change
    least is named. The rank correlation is 6/pi asin(r/2) for any distributions. Sums are written out,
    because a product of matrices may round differently for another number of draws.
    """

    def __init__(self, paths: tuple[str, ...], correlations: Mapping[tuple[str, str], float]) -> None:
        self.sets = tuple(
            each
            for each in connected(paths, correlations)
            if any(set(pair) <= set(each) for pair in correlations)
        )
        self._factors = [_factor(each, _matrix(each, correlations)) for each in self.sets]

    def applied(self, shares: Mapping[str, Real]) -> dict[str, Real]:
        """Return dependent shares made of independent ones; each alone is as uniform as before."""
        found = dict(shares)
        for paths, factor in zip(self.sets, self._factors, strict=True):
            if paths[0] in shares:
                found |= _coupled(paths, factor, shares)
        return found


def _coupled(
    paths: tuple[str, ...], factor: list[list[float]], shares: Mapping[str, Real]
) -> dict[str, Real]:
    from scipy.special import ndtr, ndtri

    normal = [np.asarray(ndtri(shares[path])) for path in paths]
    found = {}
    for path, row in zip(paths[1:], factor[1:], strict=True):
        total = np.zeros_like(normal[0])
        for weight, each in zip(row, normal, strict=True):
            if weight:
                total = total + weight * each
        found[path] = np.asarray(np.clip(ndtr(total), _SMALLEST, 1 - _SMALLEST))
    return found


def _matrix(paths: tuple[str, ...], correlations: Mapping[tuple[str, str], float]) -> list[list[float]]:
    matrix = [[float(row == column) for column in range(len(paths))] for row in range(len(paths))]
    for (first, second), value in correlations.items():
        if first in paths:
            row, column = paths.index(first), paths.index(second)
            matrix[row][column] = matrix[column][row] = value
    return matrix


def _factor(paths: tuple[str, ...], matrix: list[list[float]]) -> list[list[float]]:
    """Factorise by Cholesky in floats of Python, which round alike on every machine; a pivot may be 0."""
    size = len(matrix)
    found = [[0.0] * size for _ in range(size)]
    for column in range(size):
        pivot = matrix[column][column] - sum(each * each for each in found[column][:column])
        if pivot < -_ROUNDING:
            raise InputError(_contradiction(paths, matrix))
        found[column][column] = math.sqrt(pivot) if pivot > _ROUNDING else 0.0
        for row in range(column + 1, size):
            inner = sum(a * b for a, b in zip(found[row][:column], found[column][:column], strict=True))
            rest = matrix[row][column] - inner
            if found[column][column]:
                found[row][column] = rest / found[column][column]
            elif abs(rest) > math.sqrt(_ROUNDING):
                raise InputError(_contradiction(paths, matrix))
    return found


def _contradiction(paths: tuple[str, ...], matrix: list[list[float]]) -> str:
    """Write the smallest change of one coefficient that makes the correlations possible, or of all where none does."""
    given = np.array(matrix)
    lowest = float(np.linalg.eigvalsh(given)[0])
    start = (
        f"correlation: no quantities have these correlations with each other (smallest eigenvalue {lowest:.2g}, 0 or more"
        " is needed). "
    )
    changes = []
    for row, column in zip(*np.nonzero(np.triu(given, 1)), strict=True):
        trials = np.repeat(given[None], len(_TRIALS), axis=0)
        trials[:, row, column] = trials[:, column, row] = _TRIALS
        possible = _TRIALS[np.linalg.eigvalsh(trials)[:, 0] >= -_ROUNDING]
        if len(possible):
            best = possible[np.argmin(np.abs(possible - given[row, column]))]
            changes.append((abs(best - given[row, column]), best, row, column))
    if changes:
        _, best, row, column = min(changes)
        return (
            f"{start}The smallest change that is enough: '{paths[row]} ~ {paths[column]}' = {best:.2f} in place of"
            f" {given[row, column]:g}"
        )
    factors = np.linspace(0, 1, 1001)
    scaled = np.eye(len(given)) + factors[:, None, None] * (given - np.eye(len(given)))
    largest = factors[np.linalg.eigvalsh(scaled)[:, 0] >= -_ROUNDING].max()
    return f"{start}No change of a single coefficient is enough; all of them times {np.floor(100 * largest) / 100:g} are possible"
