"""Friction, skin and sensors of a scenario, from its steady friction."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.finger import Finger, MassSpringDamper
from electrovib.physics.friction import BristleFriction, SteadyFriction
from electrovib.physics.time_profile import Steady
from electrovib.scenario import PeriodicState
from electrovib.solve.mechanics.answer import Mechanics
from electrovib.solve.mechanics.between import Between
from electrovib.solve.mechanics.chain import Measured, finger_filters, measured, respond_mechanically
from electrovib.solve.mechanics.filters.declared import cascade, of_stages
from electrovib.solve.mechanics.filters.filter import Filter
from electrovib.solve.mechanics.lateral import (
    along_the_motion,
    friction_filter,
    memory_changes,
    shortest_time,
)
from electrovib.solve.mechanics.unknown import COUNTS, not_known, resting

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.solution import Solution

MOST = 4_000_000
"""Pieces of the finest grid on which the mechanics is computed."""
FORGOTTEN = 25.0
"""Time constants after which an initial state counts as decayed: 1e-11 of it remains."""
MOST_PERIODS = 3000
"""Largest number of periods of the drive that are computed to reach the periodic state."""


class FrictionChain:
    """Linear mechanics of a scenario behind the force of a steady friction."""

    def __init__(
        self, scenario: Scenario, times: Real, answer: Solution, at: Callable[[Real], Solution]
    ) -> None:
        self.scenario, self.times, self.answer, self.at = scenario, times, answer, at
        self.settled = isinstance(scenario.time.initial_state, PeriodicState)
        self.bend = self.run_in = 0.0
        self.lateral_at: Callable[[Real], Real] | None = None
        self.rests = () if isinstance(scenario.friction, BristleFriction) else resting(scenario.motion)
        self.prepared = answer.method.by_modes

    def steady(self, times: Real, force: Real) -> Real:
        """Return the friction under load and attraction if the finger slides and the law has no memory.

        `times` (n,) [s], `force` (n,) [N]; returns `lateral` (n,) [N].
        """
        motion, law = self.scenario.motion, self.scenario.friction.without_memory()
        normal = self.scenario.load.forces(np.maximum(times, 0.0))
        force = self.pressing(times, force)
        lateral = law.lateral_force(normal, force, self.real_area(normal + force))
        return lateral if motion.distance is None else np.where(motion.touches(times), lateral, 0.0)

    def pressing(self, times: Real, force: Real) -> Real:
        """Return the attraction that presses skin and plate together.

        `times` (n,) [s], `force` (n,) [N]; returns `pressing` (n,) [N].
        """
        motion = self.scenario.motion
        return force if motion.distance is None else np.where(motion.touches(times), force, 0.0)

    def real_area(self, force: Real) -> Real:
        """Return the real contact area under load and attraction [N]; NaN where the contact does not define it [m2]."""
        contact = self.scenario.contact
        if contact.surface is None and not self.scenario.friction.without_memory().needs_real_area:
            return np.full(len(force), np.nan)
        return np.asarray(contact.real_area(force))

    def comes_and_goes(self) -> bool:
        """Return whether the friction has to be stepped along the motion, because it is no linear filter of the steady one."""
        scenario, rests = self.scenario, bool(self.rests)
        lifts = scenario.motion.distance is not None and not isinstance(scenario.friction, SteadyFriction)
        return lifts or memory_changes(scenario) or (rests and scenario.finger is not None)

    def prepare(self) -> None:
        """Interpolate an attraction without closed form, so that it is solved once only."""
        if not self.prepared:
            at, answer = self.at, self.answer
            shortest = shortest_time(self.scenario.drive)
            force = Between(
                lambda times: at(times).attraction, self.times, self._corners(), shortest=shortest, once=True
            )
            self.at, self.bend = (lambda times: replace(answer, found={}, force=force(times))), force.error()
            self.prepared = True

    def filters(self) -> dict[str, Filter]:
        """Return the filters from the steady friction to the friction and to the skin, by signal."""
        found = {"lateral_force": friction_filter(self.scenario)}
        return found | {name: cascade(found["lateral_force"], each) for name, each in self.skin().items()}

    def skin(self) -> dict[str, Filter]:
        """Return the filters from the friction to the skin, by signal."""
        finger, speed = self.scenario.finger, self.scenario.motion.speed
        return {} if finger is None else finger_filters(_at_speed(finger, speed))

    def along(self, moved: Mechanics) -> float:
        """Compute the friction along the motion and the skin behind it, and return the relative error [1]."""
        scenario = self.scenario
        if self.settled and len(scenario.motion.breaks()) > 1:
            raise InputError(
                f"time.initial_state = PeriodicState: motion.time_profile = {type(scenario.motion.time_profile).__name__}"
                " occurs once, and the friction depends on it. Start AtRest"
            )
        self.prepare()
        stiffness = None
        if scenario.finger is not None:
            stiffness = 1 / _at_speed(scenario.finger, scenario.motion.speed).compliance_at_rest()
        found = along_the_motion(scenario, self._force, self.times, self._corners(), stiffness=stiffness)
        self.lateral_at, self.rests, error = found.force, found.unknown, found.error
        moved.add({"lateral_force": self.known(found.force(self.times))})
        if skin := self.skin():
            rows, more = respond_mechanically(found.force, skin, self.times, **self._options())
            moved.add(rows)
            error = max(error, more)
        return error

    def known(self, lateral: Real, filter_: Filter | None = None) -> Real:
        """Return the friction with NaN where it is not determined: at rest, and until a filter before it has decayed.

        `lateral` (n,) [N]; returns `lateral` (n,) [N].
        """
        if not self.rests:
            return lateral
        unknown = self.unknown(Filter.through(), self.times)
        if filter_ is not None:
            unknown = (unknown | self.unknown(filter_, self.times)) & self.scenario.motion.touches(self.times)
        return np.where(unknown, np.nan, lateral)

    def unknown(self, filter_: Filter, times: Real) -> Any:
        """Return when the output of a filter depends on a friction that is not determined.

        `times` (n,) [s]; returns `unknown` (n,).
        """
        return not_known(filter_, self.rests, times) > COUNTS

    def slip(self, moved: Mechanics) -> float:
        """Compute a skin with bristles by time stepping, and return the relative error of the interpolated attraction [1]."""
        from electrovib.solve.mechanics.bristles import slide

        self.prepare()
        law, count = self.scenario.friction, len(self.times)
        assert isinstance(law, BristleFriction)
        found, march, how = slide(self.scenario, law, self.times, self._force, self._corners())
        rows = {"lateral_force": found.lateral_force, "bristle_deflection": found.bristle_deflection}
        if self.scenario.finger is not None:
            rows |= {"skin_displacement": found.skin_displacement, "skin_speed": found.skin_speed}
        moved.add({name: row[len(row) - count :] for name, row in rows.items()})
        error = max(self.bend, float(how.pop("mechanics_error")))
        moved.how |= how
        self.lateral_at = lambda wanted: march(np.append(0.0, wanted)).lateral_force[1:]
        return error

    def follow(self, wanted: dict[str, Filter]) -> tuple[dict[str, Real], float]:
        """Return the outputs of filters of the steady friction, and their relative error."""
        self.prepare()
        began = self._before(min(_slowest(each) for each in wanted.values()))
        asked = np.append(-began, self.times) if began else self.times
        rows, error = respond_mechanically(self._force, wanted, asked, **self._options())
        return {name: row[len(row) - len(self.times) :] for name, row in rows.items()}, error

    def _force(self, times: Real) -> Real:
        """Return the steady friction at any times [s], before time 0 that of the load alone [N]."""
        return self.steady(times, self.attraction(times))

    def attraction(self, times: Real) -> Real:
        """Return the attraction at any times [s]: before time 0 it is 0, or periodic in the periodic state [N]."""
        wrapped = np.mod(times, self._period) if self.settled else np.maximum(times, 0.0)
        order = np.argsort(wrapped, kind="stable")
        force = np.empty(len(wrapped))
        force[order] = self.at(wrapped[order]).attraction
        return force if self.settled else np.where(times < 0, 0.0, force)

    @property
    def _period(self) -> float:
        return self.scenario.drive.period or 1.0

    def _before(self, slow: float) -> float:
        """Return the time before 0 to start from [s]: enough for a rate [1/s] to decay, or just before a step at 0."""
        if self.settled:
            return self._settling(slow)
        if len(self.times) > 1:
            began = self._force(np.array([-1.0, 0.0]))
            if began[0] != began[1]:
                return 1e-3 * float(np.min(np.diff(self.times)))
        return 0.0

    def _settling(self, slow: float) -> float:
        """Return the duration of whole periods of the drive in which a memory of a rate [1/s] decays [s]."""
        time_profile = self.scenario.load.time_profile
        if not isinstance(time_profile, Steady):
            raise InputError(
                f"time.initial_state = PeriodicState: load.time_profile = {type(time_profile).__name__} occurs once."
                " Start AtRest"
            )
        periods = math.ceil(FORGOTTEN / (slow * self._period))
        if periods > MOST_PERIODS:
            raise InputError(
                f"time.initial_state = PeriodicState: the mechanics needs {periods} periods of the drive to settle;"
                " start AtRest and evaluate a late period"
            )
        self.run_in = periods * self._period
        return self.run_in

    def _options(self) -> dict[str, Any]:
        return {"most": MOST, "corners": self._corners(), "shortest": shortest_time(self.scenario.drive)}

    def _corners(self) -> Real:
        """Return the times at which attraction, load or contact, or their slopes, may be discontinuous [s]."""
        end = float(self.times[-1])
        load = np.array([time for time, _ in self.scenario.load.time_profile.corners()])
        moves = np.array([time for time in self.scenario.motion.breaks() if time >= 0])
        corners = np.concatenate([[0.0], self.scenario.drive.corners(end)[0], load, moves])
        if self.settled and self.run_in:
            marks = self.scenario.drive.corners(self._period)[0]
            back = np.arange(1, math.ceil(self.run_in / self._period) + 1) * self._period
            corners = np.concatenate([corners, (marks[:, None] - back).ravel()])
        return corners[corners <= end]

    def _normal(self, times: Real) -> Real:
        """Return the force on the sensor under the plate: the load; off the plate the load minus the attraction [N]."""
        load = self.scenario.load.forces(np.maximum(times, 0.0))
        if self.scenario.motion.distance is None:
            return load
        return np.where(self.scenario.motion.touches(times), load, load - self.attraction(times))

    def measured(self) -> Measured:
        """Return the readings of load and friction by the sensors of the rig."""
        rig, scenario = self.scenario.rig, self.scenario
        assert rig is not None

        normal: Any = self._normal
        if scenario.motion.distance is None and isinstance(scenario.load.time_profile, Steady):
            normal = scenario.load.forces(self.times)  # samples of a constant force are exact
        sensor = of_stages(rig.lateral_stages())
        options = self._options()
        if self.lateral_at is None:
            friction = friction_filter(scenario)
            before = self._before(min(_slowest(sensor), _slowest(friction)))
            options |= {"friction": friction, "before": before}
            sensor = cascade(friction, sensor)
        if self.rests:
            options["unknown"] = lambda times: self.unknown(sensor, times)
        return measured(rig, self.times, normal, self.lateral_at or self._force, **options)


def _slowest(filter_: Filter) -> float:
    """Return the slowest rate of a filter [1/s]; infinite without memory."""
    return float(np.min(-filter_.poles.real)) if len(filter_.poles) else math.inf


def _at_speed(finger: Finger, speed: float | None) -> Finger:
    """Return the fingertip at the full sliding speed [m/s]."""
    if not isinstance(finger, MassSpringDamper) or finger.growth is None:
        return finger
    if speed is None:
        raise InputError("finger.growth needs motion.speed, for instance motion.speed = '50 mm/s'")
    return finger.at_speed(speed)
