"""From the attraction over time to what finger and rig make of it: load, area, friction, skin, sensors."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.contact import FixedArea
from electrovib.physics.friction import BristleFriction, SteadyFriction
from electrovib.solve.bristles import slide
from electrovib.solve.chain import finger_filters, measured, respond_mechanically
from electrovib.solve.electrical import Electrical
from electrovib.solve.expand import contact_share
from electrovib.solve.filters.declared import cascade, of_stages
from electrovib.solve.lateral import changing_lag, corner_changes, friction_filter, shortest_time, steady_law
from electrovib.solve.scenario import PeriodicState
from electrovib.solve.steps import marks_of

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.lamps import Lamp
    from electrovib.solve.filters.filter import Filter
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.transfer import Real

MOST = 4_000_000
"""Pieces of the finest grid on which the mechanics is followed."""
MARCHED = 8000
"""Steps, besides the output times, at which an attraction is taken that has to be marched."""
CLOSED = ("transient", "periodic", "current drive", "one sine", "renewal")
"""Solvers that answer at any times for little."""
FORGOTTEN = 25.0
"""Time constants after which a beginning counts as forgotten: 1e-11 of it is left."""
MOST_PERIODS = 3000


@dataclass
class Mechanics:
    """What the mechanics does over time.

    Parameters
    ----------
    signals : dict
        Dimensions and values of every signal.
    how : dict
        Errors and events, for the Trace.
    lamps : list of Lamp
        What a user should know.
    """

    signals: dict[str, Any] = field(default_factory=dict)
    how: dict[str, Any] = field(default_factory=dict)
    lamps: list[Lamp] = field(default_factory=list)

    def add(self, rows: dict[str, Real]) -> None:
        """Take signals over time.

        Parameters
        ----------
        rows : dict of str to ndarray, shape (n,)
            By the name of the signal, in its unit.
        """
        self.signals |= {name: (("time",), row) for name, row in rows.items()}


def mechanical(
    scenario: Scenario, times: Real, answer: Electrical, at: Callable[[Real], Electrical]
) -> Mechanics:
    """Compute load, contact, friction, skin and readings over time.

    Parameters
    ----------
    scenario : Scenario
        Everything.
    times : ndarray, shape (n,)
        Increasing, >= 0 [s].
    answer : Electrical
        Attraction at these times.
    at : callable
        Attraction at other times.

    Returns
    -------
    Mechanics
        Signals, errors and lamps.

    Raises
    ------
    InputError
        If models do not go together.

    Notes
    -----
    The friction is that of load and attraction together. The sensor under the plate reads the load alone while the
    finger touches: the attraction is balanced by the contact that it presses. Of a finger whose distance is given
    the hand holds against the attraction: it presses nothing, and the sensor reads the pull.
    """
    chain = _Chain(scenario, times, answer, at)
    moved = Mechanics()
    moved.add(_given(chain))
    error = _friction(chain, moved)
    if scenario.rig is not None:
        chain.prepare()
        readings = chain.measured(moved)
        moved.add(readings.signals)
        moved.lamps += readings.lamps
        error = max(error, readings.error)
    if error:
        moved.how["mechanics_error"] = max(error, chain.bend)
    return moved


def _given(chain: _Chain) -> dict[str, Real]:
    """Load, speed and areas, which only load and attraction decide on."""
    scenario, times = chain.scenario, chain.times
    rows = {"normal_force": scenario.load.forces(times)}
    if scenario.motion.speed is not None:
        rows["sliding_speed"] = scenario.motion.speeds(times)
    if not isinstance(scenario.contact, FixedArea):
        rows["gross_contact_area"] = scenario.contact_area * contact_share(scenario, times)
    if scenario.contact.surface is not None:
        rows["real_contact_area"] = chain.real_area(rows["normal_force"] + chain.answer.force)
    return rows


def _friction(chain: _Chain, moved: Mechanics) -> float:
    """Friction and skin, by the way that the friction asks for; gives the error."""
    if isinstance(chain.scenario.friction, BristleFriction):
        chain.slip(moved)
        return 0.0
    if corner_changes(chain.scenario):
        return chain.lag(moved)
    wanted = chain.filters()
    if isinstance(chain.scenario.friction, SteadyFriction):
        moved.add({"lateral_force": chain.steady(chain.times, chain.answer.force)})
        del wanted["lateral_force"]
    if not wanted:
        return 0.0
    rows, error = chain.follow(wanted)
    moved.add(rows)
    return error


class _Chain:
    """The linear mechanics of a scenario behind the force of a steady friction."""

    def __init__(
        self, scenario: Scenario, times: Real, answer: Electrical, at: Callable[[Real], Electrical]
    ) -> None:
        self.scenario, self.times, self.answer, self.at = scenario, times, answer, at
        self.settled = isinstance(scenario.time.initial_state, PeriodicState)
        self.bend = self.run_in = 0.0
        self.prepared = answer.choice["solver"] in CLOSED

    def steady(self, times: Real, force: Real) -> Real:
        """Friction that load and attraction [N] would have at these times [s] if it had no memory."""
        law, normal = steady_law(self.scenario.friction), self.scenario.load.forces(times)
        if self.scenario.motion.distance is not None:
            force = np.zeros_like(force)  # the hand holds against it
        return np.asarray(law.lateral_force(normal, force, self.real_area(normal + force)))

    def real_area(self, force: Real) -> Real:
        """Area that touches [m2] under a whole normal force [N]; NaN where the contact does not tell."""
        contact = self.scenario.contact
        if contact.surface is None and not steady_law(self.scenario.friction).needs_real_area:
            return np.full(len(force), np.nan)
        return np.asarray(contact.real_area(force))

    def prepare(self) -> None:
        """March an attraction once that has no closed form, before it is asked for many times."""
        if not self.prepared:
            self.at, self.bend = _between(self.at, self.times, self._corners())
            self.prepared = True

    def filters(self) -> dict[str, Filter]:
        """Name what follows the steady friction: the friction itself, and the skin."""
        found = {"lateral_force": friction_filter(self.scenario)}
        return found | {name: cascade(found["lateral_force"], each) for name, each in self.skin().items()}

    def skin(self) -> dict[str, Filter]:
        """Name what follows the friction in the skin."""
        return {} if self.scenario.finger is None else finger_filters(_at_speed(self.scenario))

    def lag(self, moved: Mechanics) -> float:
        """Follow a lag whose corner changes in time, and the skin behind it; give the error."""
        if self.settled:
            raise InputError(
                "time.initial_state = PeriodicState: the corner of friction changes with motion.programme. Start AtRest"
            )
        self.prepare()
        lateral, error = changing_lag(self.scenario, self._force, self.times, self._corners())
        moved.add({"lateral_force": lateral(self.times)})
        if skin := self.skin():
            rows, more = respond_mechanically(lateral, skin, self.times, **self._options())
            moved.add(rows)
            error = max(error, more)
        return error

    def slip(self, moved: Mechanics) -> None:
        """March a skin with bristles, which no filter describes."""
        self.prepare()
        law, count = self.scenario.friction, len(self.times)
        assert isinstance(law, BristleFriction)
        found, how = slide(self.scenario, law, self.times, self._force, self._corners())
        rows = {"lateral_force": found.lateral_force, "bristle_deflection": found.bristle_deflection}
        if self.scenario.finger is not None:
            rows |= {"skin_displacement": found.skin_displacement, "skin_speed": found.skin_speed}
        moved.add({name: row[len(row) - count :] for name, row in rows.items()})
        moved.how |= how

    def follow(self, wanted: dict[str, Filter]) -> tuple[dict[str, Real], float]:
        """Run filters behind the steady friction."""
        self.prepare()
        slow = min(float(np.min(-each.poles.real)) for each in wanted.values() if len(each.poles))
        return self._ran(lambda run: respond_mechanically(self._force, wanted, run, **self._options()), slow)

    def _force(self, times: Real) -> Real:
        """Steady friction at any times, before the beginning that of the load alone."""
        wrapped = np.mod(times, self._period) if self.settled else np.maximum(times, 0.0)
        order = np.argsort(wrapped, kind="stable")
        force = np.empty(len(wrapped))
        force[order] = self.at(wrapped[order]).force
        if not self.settled:
            force = np.where(times < 0, 0.0, force)
        return self.steady(wrapped, force)

    @property
    def _period(self) -> float:
        return self.scenario.drive.period or 1.0

    def _ran(
        self, run: Callable[[Real], tuple[dict[str, Real], float]], slow: float
    ) -> tuple[dict[str, Real], float]:
        """Begin early enough: just before a jump at time 0, or in the periodic state."""
        before = 0.0
        if self.settled:
            before = self._run_in(slow)
        elif len(self.times) > 1:
            began = self._force(np.array([-1.0, 0.0]))
            if began[0] != began[1]:
                before = 1e-3 * float(np.min(np.diff(self.times)))
        if not before:
            return run(self.times)
        self.run_in = before
        rows, error = run(np.append(-before, self.times))
        return {name: row[1:] for name, row in rows.items()}, error

    def _run_in(self, slow: float) -> float:
        """Whole periods after which a decay at this rate [1/s] has forgotten its beginning [s]."""
        periods = math.ceil(FORGOTTEN / (slow * self._period))
        if periods > MOST_PERIODS:
            raise InputError(
                f"time.initial_state = PeriodicState: the mechanics needs {periods} periods of the drive to settle;"
                " start AtRest and look at a late period"
            )
        return periods * self._period

    def _options(self) -> dict[str, Any]:
        return {"most": MOST, "jumps": self._corners(), "shortest": shortest_time(self.scenario.drive)}

    def _corners(self) -> Real:
        """Times at which the attraction or the load may bend or jump."""
        end = float(self.times[-1])
        load = np.array([time for time, _ in self.scenario.load.programme.corners()])
        corners = np.concatenate([[0.0], marks_of(self.scenario.drive, end)[0], load])
        if self.settled and self.run_in:
            marks = marks_of(self.scenario.drive, self._period)[0]
            back = np.arange(1, math.ceil(self.run_in / self._period) + 1) * self._period
            corners = np.concatenate([corners, (marks[:, None] - back).ravel()])
        return corners[corners <= end]

    def measured(self, moved: Mechanics) -> Any:
        """Read load and friction through the rig."""
        rig, scenario = self.scenario.rig, self.scenario
        assert rig is not None
        lateral: Any = self._force
        if not isinstance(scenario.friction, SteadyFriction):
            lateral = moved.signals["lateral_force"][1]
        off = scenario.motion.distance is not None

        def normal(times: Real) -> Real:
            load = scenario.load.forces(times)
            return load - self.at(np.maximum(times, 0.0)).force if off else load

        if not self.settled:
            return measured(rig, self.times, normal, lateral, **self._options())
        if not callable(lateral):
            raise InputError(
                f"rig: what it reads of {type(scenario.friction).__name__}, a friction with memory, is not known in the"
                " periodic state. Set time.initial_state = AtRest and look at a late period"
            )
        sensor = of_stages(rig.lateral_stages())
        before = self._run_in(float(np.min(-sensor.poles.real)))
        rate = rig.digitiser.sampling_rate if rig.digitiser else 1 / before
        self.run_in = before = math.ceil(before * rate - 1e-9) / rate  # a reading falls on the first time
        run = np.append(self.times[0] - before, self.times)
        load = scenario.load.forces(run)
        held: Any = load if not off and np.ptp(load) == 0 else normal  # samples of what is held are exact
        found = measured(rig, run, held, lateral, **self._options())
        return replace(found, signals={name: row[1:] for name, row in found.signals.items()})


def _between(
    at: Callable[[Real], Electrical], times: Real, corners: Real
) -> tuple[Callable[[Real], Electrical], float]:
    """March the attraction once on a fine grid and take it as straight in between; with the error of that."""
    even = np.linspace(0.0, float(times[-1]), MARCHED + 1)
    fixed = np.union1d(times, corners)
    stamps, coarse = np.union1d(even, fixed), np.union1d(even[::2], fixed)
    known = at(stamps)
    guessed = np.interp(stamps, coarse, known.force[np.searchsorted(stamps, coarse)])
    error = float(np.max(np.abs(guessed - known.force))) / 4 / (float(np.max(np.abs(known.force))) or 1.0)

    def between(wanted: Real) -> Electrical:
        return Electrical({}, np.interp(wanted, stamps, known.force), known.choice)

    return between, error


def _at_speed(scenario: Scenario) -> Any:
    """Give the fingertip at the full sliding speed."""
    finger = scenario.finger
    growth = getattr(finger, "growth", None)
    if growth is not None and scenario.motion.speed is None:
        raise InputError("finger.growth needs motion.speed, for instance motion.speed = '50 mm/s'")
    return finger.at_speed(scenario.motion.speed) if growth is not None else finger  # type: ignore[union-attr]
