"""Inputs of the compiled time stepping: coefficients of the method, inputs over time, tolerances."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


class RadauNumbers(NamedTuple):
    """Coefficients of Radau's method: nodes, weights, and the polynomial through the stages."""

    nodes: Real
    weights: Real
    coefficients: Real


class GivenOverTime(NamedTuple):
    """Speed, contact and strength over time, in stretches between the stops.

    Parameters
    ----------
    stops : ndarray, shape (n + 1,)
        Times at which speed, strength or contact are not smooth, with both ends [s].
    speeds, touches : ndarray, shape (n + 1,), (n,)
        Speed of the bone at the stops, linear between them [m/s]; contact in each stretch, 1 or 0.
    first, last : ndarray of int, shape (n,)
        Indices of the knots of the strength at the ends of each stretch.
    knots, values, slopes : ndarray
        Cubics of the strength: times [s], values [N], rates of change [N/s].
    floor : float
        Strength without load or contact [N].
    """

    stops: Real
    speeds: Real
    touches: Real
    first: Any
    last: Any
    knots: Real
    values: Real
    slopes: Real
    floor: float


class Sizes(NamedTuple):
    """Tolerances and limits.

    Parameters
    ----------
    tolerance : float
        Local error of a step over the scale of each state [1].
    scale : ndarray, shape (3,)
        Scales of the states [m], [m], [m/s].
    turned, passed : float
        Speed beyond 0 [m/s], and bristle force beyond the strength [N], above which an event counts.
    most_events : int
        Number of events above which the run ends.
    at_once : int
        Number of steps in one call.
    """

    tolerance: float
    scale: Real
    turned: float
    passed: float
    most_events: int
    at_once: int
