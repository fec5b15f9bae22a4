"""Linear layers behind an amplifier: exact behind gain and pole, and piecewise in closed form behind limits.

Without limits an amplifier is a filter before the stack. With limits it supplies either its voltage or its largest
current; the plate's voltage, and all that follows from it, is in closed form until the next change between the two.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.solve.electrics.amplifier.limited import LimitedMarch
from electrovib.solve.electrics.amplifier.unlimited import without_limits
from electrovib.solve.electrics.solution import LIMITED, PERIODIC, TRANSIENT, Solution
from electrovib.solve.electrics.transient import how_it_begins

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.electrics.solution import Question
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer


def amplified_response(
    transfers: Mapping[Key, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier,
    settled: bool = False,
) -> Solution:
    """Compute the response behind an amplifier of quantities that are linear in the plate's voltage.

    `time` (n,) [s].
    """
    refuse_amplified(drive, amplifier, settled=settled)
    if not amplifier.is_limited:
        found = without_limits(transfers, drive, time, amplifier=amplifier, settled=settled)
        begin = how_it_begins(drive, settled=settled)
        why = f"linear layers behind an amplifier without limits: its gain and pole are a filter before the stack, {begin}"
        return Solution(
            found=found | {"drive_voltage": drive.voltage(time)},
            method=PERIODIC if settled else TRANSIENT,
            reason=why,
        )
    march = LimitedMarch(transfers, amplifier, drive, float(time[-1]))
    found, changes = march.run(time)
    why = (
        "linear layers behind an amplifier with limits: real modes at its voltage and at its largest current, from"
        f" rest; {len(changes)} changes between them located, in closed form from one to the next"
    )
    return Solution(
        found=found | {"drive_voltage": drive.voltage(time)},
        method=LIMITED,
        reason=why,
        events=tuple(changes),
        kinks=tuple(march.kinks),
    )


def answer_behind_limits(question: Question) -> Solution:
    """Compute the response of linear layers behind an amplifier with limits."""
    amplifier, drive = question.scenario.circuit.amplifier, question.scenario.drive
    assert amplifier is not None
    return amplified_response(question.wanted(question.section), drive, question.times, amplifier=amplifier)


def refuse_amplified(drive: Drive, amplifier: Amplifier, *, settled: bool) -> None:
    """Refuse a drive or an initial state that cannot be combined with an amplifier before linear layers."""
    if drive.quantity == "current":
        raise InputError(
            f"circuit.amplifier: {type(drive).__name__} prescribes the current itself; omit the amplifier"
        )
    if settled and amplifier.is_limited:
        raise InputError(
            "time.initial_state = PeriodicState: behind an amplifier with limits the periodic state is not known"
            " beforehand. Start AtRest and evaluate a late period, or omit its limits"
        )
