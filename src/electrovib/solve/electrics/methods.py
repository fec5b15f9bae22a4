"""The methods by which solvers come to their answers: their names in a Trace, and what their steps cost."""

from __future__ import annotations

from typing import Final

from electrovib.solve.costs import March, gap_step, leak_step, limit_look, radau_step
from electrovib.solve.electrics.solution import Method

TRANSIENT: Final = Method(name="transient", by_modes=True)
PERIODIC: Final = Method(name="periodic", by_modes=True)
CURRENT_DRIVE: Final = Method(name="current drive", by_modes=True)
ONE_SINE: Final = Method(name="one sine", by_modes=True)
RENEWAL: Final = Method(name="renewal")
"""A mean over places, each of which answers by modes; not linear where it is the mean of a square."""
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
"""Its cost is that of as long as no limit is met; where it changes, the march counts on."""
NONLINEAR: Final = Method(
    name="nonlinear",
    march=March(name="the nonlinear equations", step=radau_step, at_corner=300, in_cycle=25, for_sample=0),
)
