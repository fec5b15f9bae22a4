"""Places of a film under a sliding finger: where the response is evaluated, and when each place came into contact."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.motion import Motion


PANELS = 16
"""Equal panels of the contact, each short enough for a quarter period of a sine."""


HALVINGS = 20
"""How often the first panel is halved: fresh film is charged through a series resistance within some nanometres."""


_NODES = np.array(
    [
        0.9914553711208126,
        0.9491079123427585,
        0.8648644233597691,
        0.7415311855993945,
        0.5860872354676911,
        0.4058451513773972,
        0.20778495500789848,
        0.0,
    ]
)


_KRONROD = np.array(
    [
        0.022935322010529224,
        0.06309209262997856,
        0.10479001032225019,
        0.14065325971552592,
        0.1690047266392679,
        0.19035057806478542,
        0.20443294007529889,
        0.20948214108472782,
    ]
)


@dataclass(frozen=True)
class Renewal:
    """Quadrature over the contact: where the response is evaluated, and the weight of each place.

    Parameters
    ----------
    places : ndarray, shape (places,)
        Distance from the leading edge [m].
    weights, coarse : ndarray, shape (places,)
        Share of the contact's length, by Kronrod's rule of 15 points in each panel, and by Gauss's rule on 7 of
        them; each adds up to 1.
    """

    places: Real
    weights: Real
    coarse: Real

    @classmethod
    def over(cls, length: float) -> Renewal:
        """Grade places towards the leading edge of a contact [m], where the charge is youngest."""
        points = np.concatenate([-_NODES, _NODES[-2::-1]])
        kronrod, gauss = np.concatenate([_KRONROD, _KRONROD[-2::-1]]), np.zeros(len(points))
        gauss[1::2] = np.polynomial.legendre.leggauss(7)[1]
        even = np.linspace(0.0, 1.0, PANELS + 1)
        ends = np.concatenate([[0.0], even[1] * 0.5 ** np.arange(HALVINGS, 0, -1), even[1:]])
        half = np.diff(ends)[:, None] / 2
        places = ends[:-1, None] + half * (1 + points)
        return cls(length * places.ravel(), (half * kronrod).ravel(), (half * gauss).ravel())


def entered(motion: Motion, time: Real, places: Real) -> Real:
    """Compute when each place under the finger came under its leading edge.

    `time` (n,) [s], `places` (places,) [m]; returns `entry` (places, n) [s].

    The sliding distance is a quadratic function of time between corners of the speed, so the time is its root.
    """
    corners = np.array([t for t, _ in motion.time_profile.corners()])
    marks = np.unique(np.concatenate([[0.0], corners[corners > 0], [max(float(np.max(time)), 1e-300)]]))
    speeds = motion.speeds(marks)
    paths = np.append(0.0, np.cumsum(np.diff(marks) * (speeds[1:] + speeds[:-1]) / 2))
    gains = np.append(np.diff(speeds) / np.diff(marks), 0.0)

    def path(at: Real) -> Real:
        index = np.clip(np.searchsorted(marks, at, side="right") - 1, 0, len(marks) - 1)
        since = at - marks[index]
        return np.asarray(paths[index] + since * (speeds[index] + gains[index] * since / 2))

    wanted = np.maximum(path(time)[None, :] - places[:, None], 0.0)
    index = np.clip(np.searchsorted(paths, wanted, side="left") - 1, 0, len(marks) - 1)
    left = wanted - paths[index]
    root = np.sqrt(np.maximum(speeds[index] ** 2 + 2 * gains[index] * left, 0.0))
    since = np.divide(2 * left, speeds[index] + root, out=np.zeros_like(left), where=left > 0)
    return np.asarray(np.minimum(np.where(wanted > 0, marks[index] + since, 0.0), time[None, :]))
