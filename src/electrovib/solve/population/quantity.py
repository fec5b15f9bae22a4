"""A quantity of a signal over time, for many fingers on one mesh of polynomials."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.solve.population.fingers import TOGETHER, Population
from electrovib.solve.prepare import Prepared
from electrovib.solve.quantities.pieces import tails, taken_from, taken_of_many
from electrovib.solve.quantities.resolve import MOST_VALUES, TOLERANCE, first_mesh, solved, times_of_window

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.scenario import Scenario
    from electrovib.solve.quantities import Named
    from electrovib.solve.quantities.pieces import Mesh

_CHUNK: Final = 1024
"""Fingers whose signals are in memory together, at most."""
_NUMBERS: Final = 4_000_000
"""Numbers of these signals, about."""
_SERIES: Final = 64
"""Fingers whose polynomials are in memory together."""
_PROBES: Final = 32
"""Fingers on which a mesh is refined."""
_ROUNDS: Final = 8
"""Largest number of rounds in which pieces of a mesh are halved."""
_MESHES: Final = 4
"""Meshes that are tried, each for the fingers that the one before does not resolve."""
_FEWEST: Final = 32
"""Smallest number of fingers for which a mesh is made; fewer are evaluated one by one."""


class QuantityOfFingers:
    """A quantity of a scenario as a function of the values of many fingers.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    free : sequence of str
        Dotted paths of the parameters that differ between fingers.
    name : Named
        The quantity.

    Attributes
    ----------
    method : str
        How the fingers are computed, together or one by one, and why.

    Notes
    -----
    Together, all fingers are evaluated on one mesh of Chebyshev polynomials, which is refined until it resolves some of
    them to the tolerance of a single run; fingers that it does not resolve get a finer mesh, and the last ones are solved
    one by one. Both agree to 1e-9 of the largest value of the signal. The mesh follows from all fingers of a call; given
    the mesh, the number of a finger does not depend on the others.
    """

    def __init__(self, scenario: Scenario, free: Sequence[str], name: Named) -> None:
        self.scenario, self.free, self.name = scenario, tuple(free), name
        self._alone = Prepared(scenario, free=self.free, quantities=[name.name])
        self.method = self._method()

    @property
    def in_arrays(self) -> bool:
        """Whether fingers are computed together."""
        return self.method == TOGETHER

    def __call__(
        self, draws: Mapping[str, Real], *, progress: Callable[[int, int], None] | None = None
    ) -> Real:
        """Compute the quantity of fingers.

        Returns `quantity` (fingers,).
        """
        count = len(next(iter(draws.values())))
        found, left = np.full(count, np.nan), np.arange(count)

        def report(more: int = 0) -> None:
            if progress is not None:
                progress(count - len(left) + more, count)

        for _ in range(_MESHES if self.in_arrays else 0):
            if len(left) < _FEWEST or (made := self._mesh(_of(draws, _probes(left)))) is None:
                break
            left = self._on_mesh(*made, draws, left, found, report)
        for start in range(0, len(left), _CHUNK):
            report(start)
            some = left[start : start + _CHUNK]
            found[some] = self._alone(_of(draws, some))[self.name.name]
        return found

    def _population(self, mesh: Mesh) -> Population:
        return Population(
            self.scenario,
            free=self.free,
            signals=[self.name.signal],
            time=mesh.times(),
            band=times_of_window(self.scenario),
        )

    def _method(self) -> str:
        """Return how the fingers are computed; a mesh for the values of the scenario shows it."""
        if any(path.partition(".")[0] == "time" for path in self.free):
            return "one by one: the time grid differs between fingers"
        if any(not isinstance(value, float) for value in self._alone.begin.values()):
            return "one by one: a parameter has no value in the scenario"
        return self._population(first_mesh(solved(self.scenario))).method

    def _mesh(self, draws: Mapping[str, Real]) -> tuple[Mesh, Population] | None:
        """Return a mesh that resolves some fingers, or None where they are not computed together on it.

        The first pieces are those of the finger with the fastest mode.
        """
        points = zip(*[values.tolist() for values in draws.values()], strict=True)
        runs = [solved(self._alone.scenario(dict(zip(draws, point, strict=True)))) for point in points]
        mesh = first_mesh(max(runs, key=lambda run: float(np.max(run.section.modes.rates, initial=0.0))))
        for _ in range(_ROUNDS):
            many = self._population(mesh)
            if many.method != TOGETHER:
                return None
            open_ = np.asarray(_open(_series(mesh, self._signal(many, draws))).any(axis=0))
            if not open_.any():
                return mesh, many
            mesh = mesh.halved(open_)
            if len(mesh.lengths) * (mesh.nodes + 1) > MOST_VALUES:
                break
        return None

    def _signal(self, many: Population, draws: Mapping[str, Real]) -> Real:
        """Return the signal of fingers, shape (fingers, n)."""
        signal, layer = self.name.key
        found: Real = many.signals(draws)[signal]
        return found[:, list(self.scenario.stack.layers).index(layer)] if layer else found

    def _on_mesh(
        self,
        mesh: Mesh,
        many: Population,
        draws: Mapping[str, Real],
        fingers: Indices,
        found: Real,
        report: Callable[[int], None],
    ) -> Indices:
        """Write the quantity of the fingers that a mesh resolves, and return the others."""
        size = max(1, min(_CHUNK, _NUMBERS // (len(mesh.lengths) * (mesh.nodes + 1))))
        left, done = [], 0
        for start in range(0, len(fingers), size):
            report(done)
            some = fingers[start : start + size]
            values = self._signal(many, _of(draws, some))
            for begin in range(0, len(some), _SERIES):
                part = slice(begin, begin + _SERIES)
                resolved, found[some[part]] = self._taken(mesh, values[part])
                left.append(some[part][~resolved])
                done += int(np.count_nonzero(resolved))
        return np.concatenate(left)

    def _taken(self, mesh: Mesh, values: Real) -> tuple[NDArray[np.bool_], Real]:
        """Return which fingers a mesh resolves, and the quantity of all, each of shape (fingers,)."""
        series = _series(mesh, values)
        known, found = np.isfinite(series).all(axis=(1, 2)), np.empty(len(series))
        found[known] = taken_of_many(self.name.taken, [mesh] * int(np.count_nonzero(known)), series[known])
        found[~known] = [taken_from(self.name.taken, mesh, each) for each in series[~known]]
        return np.asarray(~_open(series).any(axis=1)), found


def _series(mesh: Mesh, values: Real) -> Real:
    """Return the Chebyshev coefficients of the signals of fingers, shape (fingers, pieces, nodes)."""
    return np.stack([mesh.series(each) for each in values])


def _of(draws: Mapping[str, Real], fingers: Indices) -> dict[str, Real]:
    """Return the values of some fingers [SI units]."""
    return {path: values[fingers] for path, values in draws.items()}


def _probes(fingers: Indices) -> Indices:
    """Return some of the fingers, evenly spaced."""
    return fingers[:: -(-len(fingers) // _PROBES)]


def _open(series: Real) -> NDArray[np.bool_]:
    """Return which pieces are not resolved, shape (fingers, pieces); a piece that is not known counts as resolved."""
    finite = np.asarray(np.isfinite(series).all(axis=2))
    known = np.where(finite[:, :, np.newaxis], series, 0.0)
    scale = np.abs(known).sum(axis=2).max(axis=1, keepdims=True)
    return np.asarray(tails(known) > TOLERANCE * np.where(scale > 0, scale, 1.0))
