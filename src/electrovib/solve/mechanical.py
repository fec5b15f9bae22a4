"""From the attraction over time to what finger and rig make of it: load, area, friction, skin, sensors."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.friction import SteadyFriction

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.solve.electrical import Electrical
    from electrovib.solve.scenario import Scenario
    from electrovib.solve.transfer import Real


def mechanical(
    scenario: Scenario, times: Real, answer: Electrical, at: Callable[[Real], Electrical]
) -> tuple[dict[str, Any], dict[str, Any]]:
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
    signals : dict
        Dimensions and values of every signal.
    how : dict
        Errors, for the Trace.
    """
    del at
    normal = scenario.load.forces(times)
    if not isinstance(scenario.friction, SteadyFriction):
        raise InputError(f"friction = {type(scenario.friction).__name__}: not solved yet")
    lateral = scenario.friction.lateral_force(normal, answer.force, np.full(len(times), np.nan))
    return {"normal_force": (("time",), normal), "lateral_force": (("time",), lateral)}, {}
