"""Linear layers behind an amplifier: exact behind a gain and a pole, and from limit to limit where it has limits.

Without limits an amplifier is a filter before the stack. With them it either gives its voltage or its largest
current; the plate's voltage is known in closed form until the next change, and so is all that follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError
from electrovib.solve.electrics.amplifier.limited import LimitedMarch
from electrovib.solve.electrics.amplifier.unlimited import without_limits

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.solve.stack.transfer import Transfer


@dataclass(frozen=True)
class Amplified:
    """What a stack does behind an amplifier.

    Parameters
    ----------
    found : dict of str to ndarray
        Responses at the output times, `drive_voltage`, `plate_voltage` and `amplifier_current` among them.
    changes : tuple of float
        When [s] the amplifier changed between its voltage and one of its largest currents.
    """

    found: dict[str, Real]
    changes: tuple[float, ...]

    def reason(self) -> str:
        """Say why this solver ran and how well."""
        return (
            "linear layers behind an amplifier with limits: real modes at its voltage and at its largest current, from"
            f" rest, {len(self.changes)} changes between them located; in closed form from one to the next"
        )


def amplified_response(
    transfers: Mapping[str, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier,
    settled: bool = False,
) -> Amplified:
    """Response of linear quantities of the plate's voltage behind an amplifier.

    Parameters
    ----------
    transfers : mapping of str to Transfer
        Per volt of the plate; `current` [A per volt] among them.
    drive : Drive
        A voltage, off before time 0 when starting from rest.
    time : ndarray, shape (n,)
        Increasing, >= 0 [s].
    amplifier : Amplifier
        Gain, pole, limits and stray capacitance.
    settled : bool
        Start from the periodic state: for an amplifier without limits.

    Returns
    -------
    Amplified
        At a jump of the drive the value after it.

    Raises
    ------
    InputError
        If the periodic state is asked for behind limits, or the drive prescribes the current.
    """
    refuse_amplified(drive, amplifier, settled=settled)
    if not amplifier.is_limited:
        found = without_limits(transfers, drive, time, amplifier=amplifier, settled=settled)
        return Amplified(found | {"drive_voltage": drive.voltage(time)}, ())
    found, changes = LimitedMarch(transfers, amplifier, drive, float(time[-1])).run(time)
    return Amplified(found | {"drive_voltage": drive.voltage(time)}, tuple(changes))


def refuse_amplified(drive: Drive, amplifier: Amplifier, *, settled: bool) -> None:
    """Refuse what does not go with an amplifier before linear layers.

    Parameters
    ----------
    drive : Drive
        Any.
    amplifier : Amplifier
        With or without limits.
    settled : bool
        Whether the periodic state is asked for.

    Raises
    ------
    InputError
        If the periodic state is asked for behind limits, or the drive prescribes the current.
    """
    if drive.quantity == "current":
        raise InputError(
            f"circuit.amplifier: {type(drive).__name__} prescribes the current itself; leave the amplifier away"
        )
    if settled and amplifier.is_limited:
        raise InputError(
            "time.initial_state = PeriodicState: behind an amplifier with limits the periodic state is not known"
            " beforehand. Start AtRest and look at a late period, or leave its limits away"
        )
