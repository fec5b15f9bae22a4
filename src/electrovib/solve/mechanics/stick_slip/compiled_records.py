"""What the compiled march is given: numbers of the method, courses over time, sizes that count as small."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

if TYPE_CHECKING:
    from electrovib.core.arrays import Real


class RadauNumbers(NamedTuple):
    """Numbers of Radau's method: nodes, weights, and the polynomial through the stages."""

    nodes: Real
    weights: Real
    coefficients: Real


class GivenOverTime(NamedTuple):
    """What is given over time, stretch by stretch between the stops.

    Parameters
    ----------
    stops : ndarray, shape (n + 1,)
        Where speed, strength or touch are not smooth, both ends among them [s].
    speeds, touches : ndarray, shape (n + 1,), (n,)
        Of the bone at the stops [m/s], straight between them; 1 or 0 [1].
    first, last : ndarray of int, shape (n,)
        Knots of the strength at the ends of each stretch.
    knots, values, slopes : ndarray
        Strength as cubics [s], [N], [N/s].
    floor : float
        Strength of a lifted finger [N].
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
    """What counts as small.

    Parameters
    ----------
    tolerance : float
        Local error of a step, relative and against the scale [1].
    scale : ndarray, shape (3,)
        Of the states [m], [m], [m/s].
    turned, passed : float
        How far a speed must pass 0 [m/s], the force of the bristles the strength [N], before that counts.
    most_events : int
        Beyond it the march gives up.
    at_once : int
        Steps in one call of the march.
    """

    tolerance: float
    scale: Real
    turned: float
    passed: float
    most_events: int
    at_once: int
