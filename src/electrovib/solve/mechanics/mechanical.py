"""Response of finger and rig to the attraction over time: load, area, friction, skin, sensors."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics.friction import BristleFriction
from electrovib.solve.electrics.attraction import real_area
from electrovib.solve.electrics.solution import TRANSIENT, Solution
from electrovib.solve.mechanics.between import COARSER, Between
from electrovib.solve.mechanics.filters import Filter, cascade
from electrovib.solve.mechanics.lateral import (
    COUNTS,
    along_the_motion,
    friction_filter,
    memory_changes,
    not_known,
    resting,
    shortest_time,
)
from electrovib.solve.mechanics.response import (
    FORGOTTEN,
    MOST,
    Measured,
    finger_filters,
    measured,
    refuse_readings,
    respond,
    respond_mechanically,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.closed_form import ExponentialSum
    from electrovib.solve.mechanics.skin import Slide

READINGS: Final = frozenset({"normal_force_measured", "lateral_force_measured"})
"""Signals of the sensors of a rig."""
BEHIND_FILTERS: Final = READINGS | {"normal_force", "sliding_speed", "skin_displacement", "skin_speed"}
"""Signals that need no attraction at their own times: filters compute it at theirs."""
MOST_PERIODS = 3000
"""Largest number of periods of the drive that are computed to reach the periodic state."""


@dataclass
class Mechanics:
    """Results of the mechanics over time.

    Parameters
    ----------
    signals : dict
        Dimensions and values of every signal.
    how : dict
        Errors and events, for the attributes of the Trace.
    diagnostics : list of Diagnostic
        Diagnostics of the mechanics.
    """

    signals: dict[str, Any] = field(default_factory=dict)
    how: dict[str, Any] = field(default_factory=dict)
    diagnostics: list[Diagnostic] = field(default_factory=list)

    def add(self, rows: dict[str, Real]) -> None:
        """Add signals over time."""
        self.signals |= {name: (("time",), row) for name, row in rows.items()}


def mechanical(
    scenario: Scenario,
    times: Real,
    answer: Solution,
    at: Callable[[Real], Solution],
    *,
    closed: Callable[[float], ExponentialSum | None] | None = None,
    wanted: frozenset[str] | None = None,
) -> Mechanics:
    """Compute load, contact, friction, skin and readings over time, or at least the signals that are wanted.

    `times` (n,) [s]; `at` solves for the attraction at other times, and `closed` returns it in closed form up to a time.

    Where the finger slides, the friction is that of load and attraction together. Off the plate it is 0. At rest it is
    not determined, NaN, unless the spring of a skin or the bristles of the friction law determine it; behind a memory it
    is unknown until the memory of the rest has decayed. The sensor under the plate reads the load alone while the finger
    touches: the attraction is balanced by the contact pressure that it causes. Off the plate the hand balances the
    attraction: there is no contact pressure, and the sensor reads the attraction.
    """
    chain = FrictionChain(scenario, times, answer, at, closed)
    moved = Mechanics()
    moved.add(_given(chain, wanted))
    error = _friction(chain, moved, wanted)
    if scenario.rig is not None and (wanted is None or READINGS.intersection(wanted)):
        readings = chain.measured(wanted)
        moved.add(readings.signals)
        moved.diagnostics += readings.diagnostics
        error = max(error, readings.error)
    if error:
        moved.how["mechanics_error"] = max(error, chain.bend)
    return moved


def is_instant(scenario: Scenario) -> bool:
    """Return whether friction and contact at a time follow from load and attraction at that time."""
    remembers = scenario.friction.deflects or scenario.friction.has_memory
    return not remembers and scenario.finger is None and scenario.rig is None


def refuse_unsolved_mechanics(scenario: Scenario, *, end: float) -> None:
    """Refuse mechanical models that cannot be combined, before any computation."""
    chain = under_force(scenario, np.zeros(1), np.zeros(1))
    chain.real_area(scenario.load.forces(np.zeros(1)), np.zeros(1))
    if scenario.friction.deflects:
        _refuse_unslid(scenario)
    elif chain.comes_and_goes():
        chain.skin()
    else:
        chain.filters()
    digitiser = None if scenario.rig is None else scenario.rig.digitiser
    if digitiser is not None:
        refuse_readings(digitiser, span=end)


def _refuse_unslid(scenario: Scenario) -> None:
    """Refuse a scenario that cannot be solved with a friction whose contact deflects."""
    name = type(scenario.friction).__name__
    if scenario.motion.speed is None:
        raise InputError(f"friction = {name} needs motion.speed, for instance motion.speed = '30 mm/s'")
    if scenario.time.settled:
        raise InputError(
            f"time.initial_state = PeriodicState: the stick-slip of friction = {name} does not have the period of the drive."
            " Start AtRest and evaluate a late period"
        )


def slowest_rates(scenario: Scenario) -> list[float]:
    """Return the slowest rates of friction and skin, of each that has a memory."""
    chain = under_force(scenario, np.zeros(1), np.zeros(1))
    filters = chain.skin() if chain.comes_and_goes() else chain.filters()
    return [float(np.min(-each.poles.real)) for each in filters.values() if len(each.poles)]


def under_force(scenario: Scenario, times: Real, force: Real) -> FrictionChain:
    """Return the mechanics of a scenario under a known attraction (n,) [N] at some times (n,) [s]."""
    known = Solution(found={}, method=TRANSIENT, reason="", force=force)
    return FrictionChain(scenario, times, known, lambda _: known)


def _given(chain: FrictionChain, wanted: frozenset[str] | None) -> dict[str, Real]:
    """Return load, speed and, where they are wanted, contact areas, which depend only on load and attraction."""
    scenario, times = chain.scenario, chain.times
    rows = {"normal_force": scenario.load.forces(times)}
    if scenario.motion.speed is not None:
        rows["sliding_speed"] = scenario.motion.speeds(times)
    constant = scenario.contact.surface is None and not scenario.contact.grows
    if constant or (wanted is not None and wanted <= BEHIND_FILTERS):
        return rows
    load, pressing = rows["normal_force"], chain.pressing(times, chain.answer.attraction)
    touches = scenario.motion.touches(times)
    rows["gross_contact_area"] = np.where(touches, scenario.contact.outline(load + pressing), 0.0)
    if scenario.contact.surface is not None:
        rows["real_contact_area"] = np.where(touches, chain.real_area(load, pressing), 0.0)
    return rows


def _friction(chain: FrictionChain, moved: Mechanics, asked: Collection[str] | None) -> float:
    """Compute friction and skin by the method that the friction needs, and return the relative error [1]."""
    friction = chain.scenario.friction
    if friction.deflects:
        return chain.slip(moved)
    if chain.comes_and_goes():
        return chain.along(moved)
    wanted = {name: each for name, each in chain.filters().items() if asked is None or name in asked}
    if not friction.has_memory and "lateral_force" in wanted:
        del wanted["lateral_force"]
        lateral = chain.steady(chain.times, chain.answer.attraction)
        moved.add({"lateral_force": chain.known(lateral)})
    if not wanted:
        return 0.0
    rows, error = chain.follow(wanted, chain.times)
    if "lateral_force" in rows:
        rows["lateral_force"] = chain.known(rows["lateral_force"], wanted["lateral_force"])
    moved.add(rows)
    return error


class FrictionChain:
    """Friction, skin and sensors of a scenario: linear behind the steady friction, or a skin that sticks and slips."""

    def __init__(
        self,
        scenario: Scenario,
        times: Real,
        answer: Solution,
        at: Callable[[Real], Solution],
        closed: Callable[[float], ExponentialSum | None] | None = None,
    ) -> None:
        self.scenario, self.times, self.answer, self.at, self.closed = scenario, times, answer, at, closed
        self.settled = scenario.time.settled
        self.bend = self.run_in = 0.0
        self.lateral_at: Callable[[Real], Real] | None = None
        self.rests = () if scenario.friction.deflects else resting(scenario.motion)
        self.prepared = answer.method.by_modes

    @functools.cached_property
    def memory(self) -> Filter:
        """Filter from the steady friction to the friction."""
        return friction_filter(self.scenario)

    def steady(self, times: Real, force: Real) -> Real:
        """Return the friction under load and attraction if the finger slides and the law has no memory.

        `times` (n,) [s], `force` (n,) [N]; returns `lateral` (n,) [N].
        """
        motion, law = self.scenario.motion, self.scenario.friction.without_memory()
        normal = self.scenario.load.forces(np.maximum(times, 0.0))
        force = self.pressing(times, force)
        real = self.real_area(normal, force) if law.needs_real_area else np.full(np.shape(force), np.nan)
        lateral = law.lateral_force(normal, force, real)
        return lateral if motion.distance is None else np.where(motion.touches(times), lateral, 0.0)

    def pressing(self, times: Real, force: Real) -> Real:
        """Return the attraction that presses skin and plate together.

        `times` (n,) [s], `force` (n,) [N]; returns `pressing` (n,) [N].
        """
        motion = self.scenario.motion
        return force if motion.distance is None else np.where(motion.touches(times), force, 0.0)

    def real_area(self, load: Real, pressing: Real) -> Real:
        """Return the real contact area under load and attraction [N]; NaN where the contact does not define it [m2]."""
        if (
            self.scenario.contact.surface is None
            and not self.scenario.friction.without_memory().needs_real_area
        ):
            return np.full(len(pressing), np.nan)
        return real_area(self.scenario, load, pressing)

    def comes_and_goes(self) -> bool:
        """Return whether the friction has to be stepped along the motion, because it is no linear filter of the steady one."""
        scenario, rests = self.scenario, bool(self.rests)
        lifts = scenario.motion.distance is not None and scenario.friction.has_memory
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
        found = {name: cascade(self.memory, each) for name, each in self.skin().items()}
        return {"lateral_force": self.memory} | found

    def skin(self) -> dict[str, Filter]:
        """Return the filters from the friction to the skin, by signal."""
        finger, speed = self.scenario.finger, self.scenario.motion.speed
        return {} if finger is None else finger_filters(finger.at_speed(speed))

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
            stiffness = 1 / scenario.finger.at_speed(scenario.motion.speed).compliance_at_rest()
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
        """Compute a skin with bristles by time stepping, and return the relative error of the interpolated attraction [1].

        A finger that moves at time 0 has always slid steadily; one that begins at rest is not deflected.
        """
        self.prepare()
        times, count = self.times if self.times[0] == 0 else np.append(0.0, self.times), len(self.times)
        strength = Between(self._force, times, self._corners(), shortest=shortest_time(self.scenario.drive))
        found = self._slide(strength, times)
        rows = {"lateral_force": found.lateral_force, "bristle_deflection": found.bristle_deflection}
        if self.scenario.finger is not None:
            rows |= {"skin_displacement": found.skin_displacement, "skin_speed": found.skin_speed}
        moved.add({name: row[len(row) - count :] for name, row in rows.items()})
        moved.how |= {
            "friction_solver": f"{type(self.scenario.friction).__name__} sticks and slips: skin and bristles as one stiff"
            f" system, Radau's method of order 5, {found.steps} steps, {len(found.events)} events located",
            "energy_residual": found.energy_residual,
            "friction_events": len(found.events),
        }
        self.lateral_at = lambda wanted: self._slide(strength, np.append(0.0, wanted)).lateral_force[1:]
        return max(self.bend, strength.error()) + self._of_damping(strength, times, found.lateral_force)

    def _of_damping(self, strength: Between, times: Real, lateral: Real) -> float:
        """Return the relative error of the friction of a rigid skin whose bristles are damped [1]; 0 of any other.

        Where the strength nearly vanishes, the damping makes small errors of strength and deflection large ones of the
        friction. All that a coarser strength and tolerance change is stated: near such a strength no order is reached.
        """
        law = self.scenario.friction
        assert isinstance(law, BristleFriction)
        if self.scenario.finger is not None or law.bristles is None or not law.bristles.bristle_damping:
            return 0.0
        coarse = self._slide(strength.coarser(), times, coarser=COARSER).lateral_force
        return float(np.max(np.abs(coarse - lateral))) / (float(np.max(np.abs(lateral))) or 1.0)

    def _slide(self, strength: Between, times: Real, *, coarser: float = 1.0) -> Slide:
        """Return the motion of a skin with bristles: in compiled steps for a law of a known formula.

        `times` (n,) [s]; the tolerance is `coarser` by this factor.
        """
        motion, finger, law = self.scenario.motion, self.scenario.finger, self.scenario.friction
        assert isinstance(law, BristleFriction)
        mass, stiffness, damping = (
            (None, None, None) if finger is None else finger.at_speed(motion.speed).lumped()
        )
        from electrovib.solve.mechanics.sliding import TOLERANCE, slide_quickly, sliding

        body: dict[str, Any] = {"mass": mass, "stiffness": stiffness, "damping": damping}
        body["tolerance"] = coarser * TOLERANCE
        if law.bristles is not None:
            return slide_quickly(law, motion=motion, strength=strength, times=times, **body)
        return sliding(
            law,
            speed=motion.speeds,
            strength=strength,
            times=times,
            breaks=strength.ends[1:-1].tolist(),
            touches=motion.touches,
            settled=float(motion.speeds(0.0)) > 0,
            **body,
        )

    def exactly(self, filter_: Filter, times: Real) -> Real | None:
        """Return the output of a filter of the steady friction in closed form (n,); None where there is none."""
        scenario, end = self.scenario, float(self.times[-1])
        straight = scenario.friction.without_memory().is_linear and scenario.motion.distance is None
        if self.closed is None or not (straight and scenario.load.time_profile.is_constant):
            return None
        attraction = self.closed(end)
        if attraction is None:
            return None
        start, unit = self.steady(np.zeros(2), np.array([0.0, 1.0])).tolist()
        given = attraction.line(slope=unit - start, start=start)
        return given.filtered(filter_, attraction.groups(times), level=start)

    def follow(self, wanted: dict[str, Filter], times: Real) -> tuple[dict[str, Real], float]:
        """Return the outputs of filters of the steady friction at some times [s], and their relative error."""
        exact = {name: self.exactly(each, times) for name, each in wanted.items()}
        known = {name: row for name, row in exact.items() if row is not None}
        if len(known) == len(wanted):
            return known, 0.0
        self.prepare()
        began = self._before(min(_slowest(each) for each in wanted.values()))
        asked = np.append(-began, times) if began else times
        rows, error = respond_mechanically(self._force, wanted, asked, **self._options())
        return {name: row[len(row) - len(times) :] for name, row in rows.items()}, error

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
        if not time_profile.is_constant:
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

    def measured(self, wanted: frozenset[str] | None) -> Measured:
        """Return the readings of load and friction by the sensors of the rig, at least those that are wanted."""
        rig, scenario, friction = self.scenario.rig, self.scenario, Filter.through()
        assert rig is not None
        if self.lateral_at is None:
            friction = self.memory

        def lateral(sensor: Filter, moments: Real) -> tuple[Real, float]:
            if self.lateral_at is not None:
                return respond(self.lateral_at, sensor, moments, **self._options())
            rows, error = self.follow({"lateral": cascade(friction, sensor)}, moments)
            return rows["lateral"], error

        def normal(sensor: Filter, moments: Real) -> tuple[Real, float]:
            if scenario.motion.distance is None and scenario.load.time_profile.is_constant:
                return np.full(len(moments), sensor.at_rest() * float(scenario.load.forces(0.0))), 0.0
            self.prepare()
            return respond(self._normal, sensor, moments, **self._options())

        def unknown(sensor: Filter, moments: Real) -> Any:
            return self.unknown(cascade(friction, sensor), moments)

        both = rig.digitiser is not None or wanted is None or "normal_force_measured" in wanted
        return measured(
            rig, self.times, normal if both else None, lateral, unknown=unknown if self.rests else None
        )


def _slowest(filter_: Filter) -> float:
    """Return the slowest rate of a filter [1/s]; infinite without memory."""
    return float(np.min(-filter_.poles.real)) if len(filter_.poles) else math.inf
