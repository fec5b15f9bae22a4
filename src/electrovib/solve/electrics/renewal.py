"""Charge carried away by sliding: fresh film enters under the leading edge, and the charge leaked onto it leaves with it.

In the finger's frame de/dt + u de/dx = dV/dt - e/tau. For a fixed place of the film this is an ordinary response that
begins when the place comes under the finger, so each place needs only the modes at that time.
"""

from __future__ import annotations

import functools
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.circuit import Grounded
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics.attraction import total_pull
from electrovib.solve.electrics.leaks.answer import leaking_slab
from electrovib.solve.electrics.linear.answer import refuse_gaps_of_a_law
from electrovib.solve.electrics.linear.transient import transient
from electrovib.solve.electrics.methods import RENEWAL
from electrovib.solve.electrics.places import Renewal, entered
from electrovib.solve.electrics.solution import Solution
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.keys import AmplitudeOf
from electrovib.solve.stack.transfer import Transfer

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.motion import Motion
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key

REASON = "the response of each place of the film begins when it comes under the finger"
PULL = "pull"
"""Attraction per area, among the means."""
_AT_ONCE = 1 << 18
"""Largest number of places times output times in memory."""


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
    age = time[None, :] - began
    memory = _Memory(drive, began)
    found = {}
    for name, transfer in transfers.items():
        answer = np.tile(whole[name], (len(began), 1))
        for rate, gain, free in zip(transfer.rates, transfer.gains, transfer.free, strict=True):
            fading = np.exp(-rate * age) if gain or free else 0.0
            if gain and rate > 0:
                answer -= gain * memory.state(float(rate)) * fading
            if free:
                answer += free * (fading - np.exp(-rate * time)[None, :])
        found[name] = answer
    return found


def mean_over_contact(
    transfers: Mapping[Any, Transfer],
    drive: Drive,
    time: Real,
    *,
    motion: Motion,
    length: float,
    read: Callable[[dict[Any, Real]], dict[Any, Real]],
) -> Solution:
    """Compute the mean response over all places under a sliding finger.

    A place that came under the finger at a discontinuity of the drive is the edge of a step along the
    contact. Where that edge lies within a panel, the error is some thousandths, and reported.
    """
    over = Renewal.over(length)
    many = max(1, _AT_ONCE // len(over.places))
    means: dict[Any, list[Real]] = {}
    for first in range(0, len(time), many):
        places = renewed(transfers, drive, time[first : first + many], motion=motion, renewal=over)
        for name, rows in read(places).items():
            means.setdefault(name, []).append(np.stack([over.weights, over.coarse]) @ rows)
    both = {name: np.concatenate(pieces, axis=1) for name, pieces in means.items()}
    apart = [
        float(np.max(np.abs(fine - coarse))) / (float(np.max(np.abs(fine))) or 1.0)
        for fine, coarse in both.values()
    ]
    found = {name: fine for name, (fine, _) in both.items()}
    why = (
        f"linear layers under a finger that slides over fresh film: real modes from rest; {REASON}. By two quadrature"
        f" rules, the error of the mean over the contact is {max(apart):.1e} of the largest value"
    )
    return Solution(found=found, method=RENEWAL, reason=why, errors={"quadrature_error": max(apart)})


def answer_on_fresh_film(question: Question) -> Solution:
    """Compute the mean response over all places under the sliding finger."""
    scenario = question.scenario

    def read(places: dict[Key, Real]) -> dict[Key, Real]:
        kept: dict[Key, Real] = {key: row for key, row in places.items() if not isinstance(key, AmplitudeOf)}
        given = {key.name: row for key, row in places.items() if isinstance(key, AmplitudeOf)}
        return kept | ({PULL: total_pull(scenario, given)} if given else {})

    mean = mean_over_contact(
        question.wanted(question.section),
        scenario.drive,
        question.times,
        motion=scenario.motion,
        length=scenario.contact.sliding_length(scenario.load.normal_force),
        read=read,
    )
    found = dict(mean.found)
    pull = found.pop(PULL, None)
    return replace(mean, found=found, pull=pull)


class _Memory:
    """State of single modes at the moments of entry, each computed once."""

    def __init__(self, drive: Drive, began: Real) -> None:
        self._drive = drive
        self._times, self._places = np.unique(began, return_inverse=True)
        self._shape = began.shape
        self.state = functools.cache(self._state)

    def _state(self, rate: float) -> Real:
        """Return the mode of this rate at the moments of entry, 0 at time 0."""
        mode = Transfer(rates=np.array([rate]), gains=np.array([1.0]))
        found = transient({"mode": mode}, self._drive, self._times)["mode"]
        found = np.where(self._times > 0, found, 0.0)
        return np.asarray(found[self._places.ravel()].reshape(self._shape))


def refuse_renewal(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with sliding over fresh film."""
    slab = leaking_slab(scenario.stack.layers, second=Surroundings.of(scenario).second)
    leak = next(iter(slab), None)
    refuse_gaps_of_a_law(scenario, leak)
    reasons = {
        "time.initial_state = PeriodicState: start AtRest and evaluate a late period": isinstance(
            scenario.time.initial_state, PeriodicState
        ),
        "a drive that prescribes the current, which all places share: use a voltage drive": (
            scenario.drive.quantity == "current"
        ),
        f"stack.{leak}.leak: give the layer a material that conducts": leak is not None,
        "circuit.amplifier, whose output all places share: omit circuit.amplifier": scenario.circuit.amplifier
        is not None,
        "contact.closing, whose gap all places share: omit contact.closing": scenario.contact.closing
        is not None,
        "this circuit.return_path, whose voltage all places share: use Grounded": not isinstance(
            scenario.circuit.return_path, Grounded
        ),
    }
    found = [text for text, applies in reasons.items() if applies]
    if found:
        raise InputError([f"motion.renews_film cannot be combined with {text}" for text in found])
