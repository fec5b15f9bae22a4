"""Response of finger and rig to the attraction over time: load, area, friction, skin, sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.contact import FixedArea
from electrovib.physics.friction import BristleFriction, FollowingFriction, SteadyFriction
from electrovib.solve.electrics.solution import TRANSIENT, Solution
from electrovib.solve.mechanics.answer import Mechanics
from electrovib.solve.mechanics.chain import refuse_readings
from electrovib.solve.mechanics.friction_chain import MOST, FrictionChain

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario


def mechanical(
    scenario: Scenario, times: Real, answer: Solution, at: Callable[[Real], Solution]
) -> Mechanics:
    """Compute load, contact, friction, skin and readings over time.

    `times` (n,) [s].

    Where the finger slides, the friction is that of load and attraction together. Off the plate it is 0. At rest it is
    not determined, NaN, unless the spring of a skin or the bristles of the friction law determine it; behind a memory it
    is unknown until the memory of the rest has decayed. The sensor under the plate reads the load alone while the finger
    touches: the attraction is balanced by the contact pressure that it causes. Off the plate the hand balances the
    attraction: there is no contact pressure, and the sensor reads the attraction.
    """
    chain = FrictionChain(scenario, times, answer, at)
    moved = Mechanics()
    moved.add(_given(chain))
    error = _friction(chain, moved)
    if scenario.rig is not None:
        chain.prepare()
        readings = chain.measured()
        moved.add(readings.signals)
        moved.diagnostics += readings.diagnostics
        error = max(error, readings.error)
    if error:
        moved.how["mechanics_error"] = max(error, chain.bend)
    return moved


def refuse_unsolved_mechanics(scenario: Scenario, *, end: float) -> None:
    """Refuse mechanical models that cannot be combined, before any computation."""
    chain = _without_attraction(scenario)
    chain.real_area(scenario.load.forces(np.zeros(1)))
    if isinstance(scenario.friction, BristleFriction):
        from electrovib.solve.mechanics.bristles import refuse_unslid

        refuse_unslid(scenario)
    elif isinstance(scenario.friction, (SteadyFriction, FollowingFriction)):
        chain.filters() if not chain.comes_and_goes() else chain.skin()
    digitiser = None if scenario.rig is None else scenario.rig.digitiser
    if digitiser is not None:
        refuse_readings(digitiser, span=end, most=MOST)


def slowest_rates(scenario: Scenario) -> list[float]:
    """Return the slowest rates of friction and skin, of each that has a memory."""
    chain = _without_attraction(scenario)
    filters = chain.skin() if chain.comes_and_goes() else chain.filters()
    return [float(np.min(-each.poles.real)) for each in filters.values() if len(each.poles)]


def _without_attraction(scenario: Scenario) -> FrictionChain:
    """Return the mechanics of a scenario at time 0, before anything is solved."""
    nothing = Solution(found={}, method=TRANSIENT, reason="", force=np.zeros(1))
    return FrictionChain(scenario, np.zeros(1), nothing, lambda _: nothing)


def _given(chain: FrictionChain) -> dict[str, Real]:
    """Return load, speed and contact areas, which depend only on load and attraction."""
    scenario, times = chain.scenario, chain.times
    rows = {"normal_force": scenario.load.forces(times)}
    if scenario.motion.speed is not None:
        rows["sliding_speed"] = scenario.motion.speeds(times)
    if scenario.contact.surface is None and isinstance(scenario.contact, FixedArea):
        return rows
    whole = rows["normal_force"] + chain.pressing(times, chain.answer.attraction)
    touches = scenario.motion.touches(times)
    rows["gross_contact_area"] = np.where(touches, scenario.contact.outline(whole), 0.0)
    if scenario.contact.surface is not None:
        rows["real_contact_area"] = np.where(touches, chain.real_area(whole), 0.0)
    return rows


def _friction(chain: FrictionChain, moved: Mechanics) -> float:
    """Compute friction and skin by the method of the friction's family, and return the relative error [1]."""
    friction = chain.scenario.friction
    if isinstance(friction, BristleFriction):
        return chain.slip(moved)
    if not isinstance(friction, (SteadyFriction, FollowingFriction)):
        raise InputError(
            f"friction = {type(friction).__name__}: no solver for its family; derive it from SteadyFriction,"
            " FollowingFriction or BristleFriction"
        )
    if chain.comes_and_goes():
        return chain.along(moved)
    wanted = chain.filters()
    if isinstance(friction, SteadyFriction):
        lateral = chain.steady(chain.times, chain.answer.attraction)
        moved.add({"lateral_force": chain.known(lateral)})
        del wanted["lateral_force"]
    if not wanted:
        return 0.0
    rows, error = chain.follow(wanted)
    if "lateral_force" in rows:
        rows["lateral_force"] = chain.known(rows["lateral_force"], wanted["lateral_force"])
    moved.add(rows)
    return error
