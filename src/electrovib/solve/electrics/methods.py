"""The methods of the electrical solvers: their names in a Trace and the cost of their steps."""

from __future__ import annotations

from typing import Final

from electrovib.solve.costs import March, gap_step, leak_step, limit_look, radau_step
from electrovib.solve.electrics.solution import Method

TRANSIENT: Final = Method(name="transient", by_modes=True)
PERIODIC: Final = Method(name="periodic", by_modes=True)
CURRENT_DRIVE: Final = Method(name="current drive", by_modes=True)
ONE_SINE: Final = Method(name="one sine", by_modes=True)
RENEWAL: Final = Method(name="renewal")
"""A mean over places, each with a modal response; not linear where it is the mean of a square."""
LEAK: Final = Method(
    name="nonlinear branch",
    march=March(name="the leaking layer", step=leak_step, at_corner=500, in_cycle=400, for_sample=7),
)
MOVING_GAP: Final = Method(
    name="moving gap",
    march=March(name="the moving gap", step=gap_step, at_corner=1000, in_cycle=400, for_sample=1),
)
LIMITED: Final = Method(
    name="amplifier",
    march=March(
        name="the amplifier with limits", step=limit_look, at_corner=75, in_cycle=64, for_sample=0, numbers=0
    ),
)
"""The cost holds as long as no limit is met; the time integration adds the cost of every change as it occurs."""
NONLINEAR: Final = Method(
    name="nonlinear",
    march=March(name="the nonlinear equations", step=radau_step, at_corner=300, in_cycle=25, for_sample=0),
)
