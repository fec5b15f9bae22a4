"""Charge carried away by sliding: fresh film enters under the leading edge, and the charge leaked onto it leaves with it.

In the finger's frame de/dt + u de/dx = dV/dt - e/tau. For a fixed place of the film this is an ordinary response that
begins when the place comes under the finger, so each place needs only the modes at that time.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.leaks import leaking_slab
from electrovib.solve.electrics.solution import RENEWAL, Solution
from electrovib.solve.electrics.transient import refuse_gaps_of_a_law, transient
from electrovib.solve.meter import Meter
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import AmplitudeOf, amplitudes_among
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.motion import Motion
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question

REASON = "the response of each place of the film begins when it comes under the finger"
PULL = "pull"
"""Attraction per area, among the means."""
_BLOCK = 1 << 18
"""Largest number of places times output times in memory."""
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


def renewed(
    transfers: Mapping[Any, Transfer], drive: Drive, time: Real, *, motion: Motion, renewal: Renewal
) -> dict[Any, Real]:
    """Compute the response of linear quantities at every place under a sliding finger.

    `time` (n,) [s].

    A place that came under the finger at t0 has no memory of earlier times: its modes are x(t) - x(t0) exp(-rate (t -
    t0)), and the free part, which the initial charge of its layers drives, begins at t0. The whole column is fresh,
    the polarisation of the skin included. The series impedance acts on each place as if that place were alone, which
    is correct where the film blocks and the series impedance takes little of the voltage. The current of a place
    charges it while it is under the finger; charge that leaves with the place is not part of it.
    """
    whole = transient(transfers, drive, time)
    began = entered(motion, time, renewal.places)
    age, moments = time[None, :] - began, np.unique(began)
    driven = [each.rates[(each.gains != 0) & (each.rates > 0)] for each in transfers.values()]
    rates = np.unique(np.concatenate([np.zeros(0), *driven]))
    alone = dict(
        zip(rates.tolist(), (Transfer(rates=rates, gains=row) for row in np.eye(len(rates))), strict=True)
    )
    states = transient(alone, drive, moments)  # 0 at time 0
    places = np.searchsorted(moments, began)
    found = {}
    for name, transfer in transfers.items():
        answer = np.tile(whole[name], (len(began), 1))
        for rate, gain, free in zip(transfer.rates, transfer.gains, transfer.free, strict=True):
            fading = np.exp(-rate * age) if gain or free else 0.0
            if gain and rate > 0:
                answer -= gain * states[float(rate)][places] * fading
            if free:
                answer += free * (fading - np.exp(-rate * time)[None, :])
        found[name] = answer
    return found


def answer_on_fresh_film(question: Question) -> Solution:
    """Compute the mean response over all places under a sliding finger.

    A place that came under the finger at a discontinuity of the drive is the edge of a step along the
    contact. Where that edge lies within a panel, the error is some thousandths, and reported.
    """
    scenario, times, transfers = question.scenario, question.times, question.wanted(question.section)
    over = Renewal.over(scenario.contact.sliding_length(scenario.load.normal_force))
    many = max(1, _BLOCK // len(over.places))
    means: dict[Any, list[Real]] = {}
    meter = Meter(
        "the response of each place of the film",
        of=f"{len(over.places)} places at {len(times):.3g} times",
        end=len(times),
        repeats=many,
        remedy="ask for fewer time.samples, or choose a shorter time.duration",
    )
    for first in range(0, len(times), many):
        meter.count(first)
        some = times[first : first + many]
        places = renewed(transfers, scenario.drive, some, motion=scenario.motion, renewal=over)
        if given := amplitudes_among(places):
            places = {key: row for key, row in places.items() if not isinstance(key, AmplitudeOf)}
            places[PULL] = total_pull(scenario, given)
        for name, rows in places.items():
            means.setdefault(name, []).append(np.stack([over.weights, over.coarse]) @ rows)
    both = {name: np.concatenate(pieces, axis=1) for name, pieces in means.items()}
    apart = max(
        float(np.max(np.abs(fine - coarse))) / (float(np.max(np.abs(fine))) or 1.0)
        for fine, coarse in both.values()
    )
    found = {name: fine for name, (fine, _) in both.items()}
    why = (
        f"linear layers under a finger that slides over fresh film: real modes from rest; {REASON}. By two quadrature"
        f" rules, the error of the mean over the contact is {apart:.1e} of the largest value"
    )
    pull = found.pop(PULL, None)
    return Solution(found=found, pull=pull, method=RENEWAL, reason=why, errors={"quadrature_error": apart})


def refuse_renewal(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with sliding over fresh film."""
    back = scenario.circuit.return_path
    slab = leaking_slab(scenario.stack.layers, second=Surroundings.of(scenario).second)
    leak = next(iter(slab), None)
    refuse_gaps_of_a_law(scenario, leak)
    reasons = {
        "time.initial_state = PeriodicState: start AtRest and evaluate a late period": scenario.time.settled,
        "a drive that prescribes the current, which all places share: use a voltage drive": (
            scenario.drive.quantity == "current"
        ),
        f"stack.{leak}.leak: give the layer a material that conducts": leak is not None,
        "circuit.amplifier, whose output all places share: omit circuit.amplifier": scenario.circuit.amplifier
        is not None,
        "contact.closing, whose gap all places share: omit contact.closing": scenario.contact.closing
        is not None,
        "this circuit.return_path, whose voltage all places share: use Grounded": back.element().elastance > 0
        or back.second_contact(1.0) > 0,
    }
    found = [text for text, applies in reasons.items() if applies]
    if found:
        raise InputError([f"motion.renews_film cannot be combined with {text}" for text in found])


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
