"""Uncertainty of the delay, the fall time, the frequency and the quality factor of a fitted release."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.recordings.correlated import autocovariance, covariance
from electrovib.recordings.release.least_squares import refined

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from numpy.typing import NDArray

    from electrovib.recordings.release.least_squares import Release
    from electrovib.recordings.release.parts import Decay

JUDGED = ("delay", "frequency", "quality")
_LATER_STARTS = (0.25, 0.5, 0.75)
"""Alternative beginnings of the window after the release, in periods."""
_FALLS = (0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 1.0)
"""Fall times that are tried, in periods."""
_INTERVAL = 3.29
"""Standard deviations from one end of an interval to the other: 95 % on either side."""


@dataclass(frozen=True)
class Uncertainty:
    """Standard uncertainty of a number, by its causes, in the unit of the number.

    The components are ``noise`` (of the fit, with the correlation of the residuals), ``window`` (rms change
    if the fit begins up to three quarters of a period after the release), ``fall time`` (of the other fall
    times that fit as well), for a delay ``end`` (of the drive, between two samples), for frequency and
    quality factor ``change`` (during the decay).
    """

    components: Mapping[str, float]

    @property
    def total(self) -> float:
        """Root of the sum of squares of the components, in their unit."""
        return float(np.sqrt(sum(value**2 for value in self.components.values())))

    def to_dict(self) -> dict[str, float]:
        """Return plain numbers for JSON: the components and their total."""
        return {**self.components, "total": self.total}


def uncertainties(
    *, stamps: NDArray[np.float64], force: NDArray[np.float64], window: float, best: Release
) -> tuple[dict[str, Uncertainty], tuple[float, float]]:
    """Compute the uncertainty of a fitted release, and its lowest and highest fall time that fit as well within 95 %."""
    jacobian, after = _jacobian(stamps, best), stamps >= 0
    # the residual is noise before the end of the drive, and includes model error after it: the larger effect is taken
    kinds = (
        autocovariance(best.residual[~after], fitted=1),
        autocovariance(best.residual[after], fitted=jacobian.shape[1]),
    )
    alike = max(kinds, key=lambda of: float(covariance(jacobian=jacobian, autocovariance=of)[1, 1]))
    noise = np.sqrt(np.diag(covariance(jacobian=jacobian, autocovariance=alike)))
    falls, interval = _falls(stamps, force, window, best, alike)
    later = []
    for share in _LATER_STARTS:
        kept = (stamps < 0) | (stamps > best.delay + share / best.frequency)
        later.append(refined(stamps[kept], force[kept], best, window=window))
    step = float(np.median(np.diff(stamps)))
    found = {}
    for place, name in enumerate(JUDGED):
        value = getattr(best, name)
        components = {
            "noise": float(noise[place]),
            "window": float(np.sqrt(np.mean([(getattr(fit, name) - value) ** 2 for fit in later]))),
            "fall time": float(np.ptp([value, *(getattr(fit, name) for fit in falls)]) / _INTERVAL),
        }
        if name == "delay":
            components["end"] = step / float(np.sqrt(12))
        found[name] = Uncertainty(components)
    return found, interval


def with_change(
    found: Mapping[str, Uncertainty], decays: tuple[Decay | None, Decay | None]
) -> dict[str, Uncertainty]:
    """Add the change of frequency and quality factor during the decay, uniformly distributed, beyond the noise of both fits."""
    early, late = decays
    if early is None or late is None:
        return dict(found)
    added = dict(found)
    for name in ("frequency", "quality"):
        apart = getattr(late, name) - getattr(early, name)
        noise = [getattr(decay, f"{name}_uncertainty") for decay in (early, late)]
        beyond = max(0.0, apart**2 - noise[0] ** 2 - noise[1] ** 2)
        added[name] = Uncertainty({**found[name].components, "change": float(np.sqrt(beyond / 12))})
    return added


def _jacobian(stamps: NDArray[np.float64], at: Release, *, of_fall: bool = False) -> NDArray[np.float64]:
    """Return the derivatives by delay, frequency, quality factor and both levels; by the fall time at equal delay."""
    step = 1e-4 / at.frequency
    changes: list[tuple[float, dict[str, float]]] = [
        (step, {"start": step}),
        (1e-4 * at.frequency, {"frequency": 1e-4 * at.frequency}),
        (1e-4 * at.quality, {"quality": 1e-4 * at.quality}),
    ]
    changes += [(step, {"fall_time": step, "start": -step})] * of_fall
    slopes = []
    for size, change in changes:
        more, less = (
            replace(at, **{name: getattr(at, name) + sign * by for name, by in change.items()}).shape(stamps)
            for sign in (1, -1)
        )
        slopes.append((at.held - at.after) * (more - less) / (2 * size))
    shape = at.shape(stamps)
    return np.column_stack([*slopes, shape, 1 - shape])


def _falls(
    stamps: NDArray[np.float64],
    force: NDArray[np.float64],
    window: float,
    best: Release,
    alike: NDArray[np.float64],
) -> tuple[list[Release], tuple[float, float]]:
    """Return the fits with the lowest and the highest fall time that fit as well, and these two times."""
    # near 0 the record depends on the square of the fall time, so the effect of the correlation is found further off
    fall = max(best.fall_time, _FALLS[2] / best.frequency)
    seen = _jacobian(stamps, replace(best, fall_time=fall, start=best.delay - fall), of_fall=True)
    with_neighbours, alone = (covariance(jacobian=seen, autocovariance=of)[3, 3] for of in (alike, alike[:1]))
    allowed = (_INTERVAL / 2) ** 2 * alike[0] * (max(with_neighbours / alone, 1.0) if alone > 0 else 1.0)
    least = float(best.residual @ best.residual)

    def excess(fall: float) -> float:
        residual = refined(stamps, force, best, window=window, fall_time=fall).residual
        return float(residual @ residual) - least

    tried = [part / best.frequency for part in _FALLS if part / best.frequency < window / 2]
    shorter = [fall for fall in reversed(tried) if fall < best.fall_time]
    longer = [fall for fall in tried if fall > best.fall_time]
    lowest = _end(best.fall_time, [*shorter, float(np.median(np.diff(stamps))) / 10], excess, allowed) or 0.0
    highest = _end(best.fall_time, longer, excess, allowed) or window / 2
    ends = [
        refined(stamps, force, best, window=window, fall_time=fall) for fall in (lowest, highest) if fall > 0
    ]
    return ends, (lowest, highest)


def _end(
    best: float, tried: Sequence[float], excess: Callable[[float], float], allowed: float
) -> float | None:
    """Find the fall time beyond which the sum of squares is larger than allowed; None if it never is."""
    inside, cost = best, 0.0
    for fall in tried:
        beyond = excess(fall)
        if beyond > allowed:
            return _crossing(inside, fall, cost, beyond, allowed)
        inside, cost = fall, beyond
    return None


def _crossing(inside: float, outside: float, cost: float, beyond: float, allowed: float) -> float:
    """Interpolate the fall time at which the sum of squares, taken as quadratic, is as large as allowed."""
    low, high, wanted = (np.sqrt(max(value, 0.0)) for value in (cost, beyond, allowed))
    share = (wanted - low) / (high - low) if high > low else 1.0
    return float(inside + np.clip(share, 0, 1) * (outside - inside))
