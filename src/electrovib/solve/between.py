"""A force that is costly to ask for, as cubics between its corners: smooth where it is smooth."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.solve.transfer import Real

KNOTS = 8000
"""Even times, besides those asked for, between which the force is taken as a cubic."""
_BEFORE = 1e-9
"""How long before a corner the force before it is looked up, as a share of the whole time."""


class Between:
    """A force as cubics between its corners, where it may bend or jump; right-continuous there.

    Parameters
    ----------
    force_at : callable
        Force [N] at increasing times [s], at a jump the value after it; asked once.
    times : ndarray, shape (n,)
        Where it has to be right [s], the last one the end.
    corners : ndarray
        Where it may bend or jump [s].
    """

    def __init__(self, force_at: Callable[[Real], Real], times: Real, corners: Real) -> None:
        end = float(times[-1])
        inside = corners[(corners > 0) & (corners < end)]
        self.ends = np.unique(np.concatenate([[0.0], inside, [end]]))
        self._just = self.ends[1:] - _BEFORE * end
        even = np.linspace(0.0, end, KNOTS + 1)
        self._asked = np.unique(np.concatenate([even, times, self.ends, self._just]))
        self._force = force_at(self._asked)
        self._pieces = self._cubics(np.ones(len(self._asked), bool))

    def __call__(self, time: Any) -> Any:
        """Force [N] at times [s], scalar or array."""
        return self._value(self._pieces, time)

    def error(self) -> float:
        """Error over the largest force, from cubics through every other knot: a fifteenth of what they miss."""
        kept = np.zeros(len(self._asked), bool)
        kept[::2] = True
        kept |= np.isin(self._asked, np.concatenate([self.ends, self._just]))
        coarse = self._value(self._cubics(kept), self._asked)
        inside = ~np.isin(self._asked, self.ends)
        missed = np.max(np.abs(coarse - self._force)[inside], initial=0.0)
        return float(missed) / 15 / (float(np.max(np.abs(self._force))) or 1.0)

    def _cubics(self, kept: Any) -> list[Any]:
        from scipy.interpolate import CubicSpline

        found, tiny = [], 2 * _BEFORE * float(self.ends[-1])
        for start, stop, just in zip(self.ends[:-1], self.ends[1:], self._just, strict=True):
            chosen = kept & (self._asked >= start) & (self._asked < just)
            stamps, values = self._asked[chosen], self._force[chosen]
            spaced = np.append(True, np.diff(stamps) > tiny) & (stop - stamps > tiny)
            spaced[:1] = True
            stamps = np.append(stamps[spaced], stop)
            values = np.append(values[spaced], self._force[np.searchsorted(self._asked, just)])
            found.append(CubicSpline(stamps, values, bc_type="natural" if len(stamps) < 4 else "not-a-knot"))
        return found

    def _value(self, pieces: list[Any], time: Any) -> Any:
        place = np.clip(np.searchsorted(self.ends, time, side="right") - 1, 0, len(pieces) - 1)
        if np.ndim(time) == 0:
            return float(pieces[int(place)](time))
        found = np.empty(np.shape(time))
        for index in np.unique(place).tolist():
            found[place == index] = pieces[index](np.asarray(time)[place == index])
        return found
