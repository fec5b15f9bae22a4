"""Linear layers behind an amplifier: exact behind a gain and a pole, and from limit to limit where it has limits.

Without limits an amplifier is a filter before the stack. With them it either gives its voltage or its largest
current; the plate's voltage is known in closed form until the next change, and so is all that follows from it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Tones
from electrovib.solve.aim import aim_pieces
from electrovib.solve.limited import LimitedMarch
from electrovib.solve.transfer import Transfer
from electrovib.solve.transient import transient

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.drive.base import Drive
    from electrovib.physics.drive.parts import Part
    from electrovib.solve.transfer import Real

PIECES = 512
"""Straight pieces for one period of what bends a drive that is not straight; then twice as many."""
_LOOKING_BACK = 0.9
"""Share of a time from which on a response is looked at for what is left of it."""
_TAIL = 1e-4
"""Share of the largest below which nothing is held against what is left."""
_SAME_RATE = 1e-8
"""A corner nearer than this to a rate of the stack, relative, is moved away by it."""


@dataclass(frozen=True)
class Amplified:
    """What a stack does behind an amplifier.

    Parameters
    ----------
    found : dict of str to ndarray
        Responses at the output times, `drive_voltage`, `plate_voltage` and `amplifier_current` among them.
    changes : tuple of float
        When [s] the amplifier changed between its voltage and one of its largest currents.
    error : float
        Error of the worst response over the largest that it reaches from about then on, by halving the straight
        pieces; 0 where they are exact.
    """

    found: dict[str, Real]
    changes: tuple[float, ...]
    error: float

    def reason(self) -> str:
        """Say why this solver ran and how well."""
        how = "straight pieces and exponentials exactly"
        if self.error:
            how = "the drive as straight pieces, by halving them the error of the worst response is"
            how += f" {self.error:.1e} of the largest that it reaches from then on"
        return (
            "linear layers behind an amplifier with limits: real modes at its voltage and at its largest current, from"
            f" rest, {len(self.changes)} changes between them located; {how}"
        )


def behind(transfer: Transfer, amplifier: Amplifier) -> Transfer:
    """Put gain and pole of an amplifier before a linear quantity of the plate's voltage.

    Parameters
    ----------
    transfer : Transfer
        Per volt of the plate.
    amplifier : Amplifier
        Its limits are left out.

    Returns
    -------
    Transfer
        Per volt of the drive; what initial charge leaves behind is as before.
    """
    gain = amplifier.gain
    if amplifier.bandwidth is None:
        static = None if transfer.static is None else transfer.static * gain
        forced = (transfer.gains * gain, transfer.direct * gain, transfer.slope * gain)
        return Transfer(transfer.rates, *forced, transfer.free, static)
    corner = 2 * np.pi * amplifier.bandwidth
    if np.any(np.abs(transfer.rates - corner) < _SAME_RATE * corner):
        corner *= 1 + 2 * _SAME_RATE
    apart = corner - transfer.rates
    direct = transfer.direct if transfer.static is None else transfer.static - float(np.sum(transfer.gains))
    own = direct - transfer.slope * corner - float(np.sum(transfer.gains * transfer.rates / apart))
    return Transfer(
        np.append(transfer.rates, corner),
        gain * np.append(transfer.gains * corner / apart, own),
        gain * transfer.slope * corner,
        0.0,
        np.append(transfer.free, 0.0),
        None if transfer.static is None else gain * transfer.static,
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
        return _unlimited(transfers, drive, time, amplifier, settled=settled)
    bending = max((_bending(part) for part in drive.parts()), default=0.0)
    march = LimitedMarch(transfers, amplifier)
    found, changes = march.run(aim_pieces(drive, float(time[-1]), amplifier, bending * PIECES), time)
    error = 0.0
    if bending:
        coarse = found
        found, changes = march.run(aim_pieces(drive, float(time[-1]), amplifier, 2 * bending * PIECES), time)
        error = max(_distance(row, coarse[name], time) for name, row in found.items())
    found["drive_voltage"] = drive.voltage(time)
    return Amplified(found, tuple(changes), error)


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


def _bending(part: Part) -> float:
    """Frequency of a sine as large as all tones together that bends as they do [Hz]: what straight pieces miss."""
    if not isinstance(part, Tones):
        return part.highest_frequency
    sizes = np.abs(part.amplitudes)
    return float(np.sqrt(np.sum(sizes * part.frequencies**2) / (np.sum(sizes) or 1.0)))


def _distance(fine: Real, coarse: Real, time: Real) -> float:
    """Hold a difference against what is still to come: the current of a jump shall not hide it."""
    size = np.abs(fine)
    left = np.maximum.accumulate(size[::-1])[::-1][np.searchsorted(time, _LOOKING_BACK * time)]
    told = left > _TAIL * np.max(size)
    return float(np.max((np.abs(fine - coarse)[told] / left[told]), initial=0.0))


def _unlimited(
    transfers: Mapping[str, Transfer], drive: Drive, time: Real, amplifier: Amplifier, *, settled: bool
) -> Amplified:
    none = np.zeros(0)
    wanted = dict(transfers) | {
        "plate_voltage": Transfer(none, none, 1.0),
        "stray current": Transfer(none, none, 0.0, amplifier.stray_capacitance, static=0.0),
    }
    found = transient(
        {name: behind(transfer, amplifier) for name, transfer in wanted.items()}, drive, time, settled=settled
    )
    found["amplifier_current"] = found.pop("stray current") + found["current"]
    found["drive_voltage"] = drive.voltage(time)
    return Amplified(found, (), 0.0)
