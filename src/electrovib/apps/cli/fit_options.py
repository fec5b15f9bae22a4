"""How the noise and the calibration errors of a fit are read."""

from __future__ import annotations

from typing import TYPE_CHECKING

from electrovib.apps.cli.options import pair_of

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from electrovib.recordings.calibration_error import CalibrationError


def share_of(text: str, option: str) -> float:
    """Read a relative standard deviation, such as ``1 %`` or ``0.01``."""
    from electrovib.core.errors import InputError

    number, per_cent = text.strip().removesuffix("%").strip(), text.strip().endswith("%")
    if not _is_number(number):
        raise InputError(f"{option} {text}: expected a share such as '1 %' or 0.01")
    return float(number) / (100 if per_cent else 1)


def noises_of(texts: Sequence[str]) -> dict[str, float]:
    """Read the noise of signals, in the unit of each or relative to it."""
    from electrovib.recordings.fit.measured import PROPORTIONAL

    return dict(_of_signal(text, "--noise", relative=PROPORTIONAL) for text in texts)


def calibrations_of(gains: Sequence[str], zeros: Sequence[str]) -> dict[str, CalibrationError]:
    """Read the calibration errors of signals: shares of the gain, and zeros in the unit of each signal."""
    from electrovib.core.errors import InputError, nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.recordings.calibration_error import CalibrationError

    found: dict[str, float] = {}
    for text in gains:
        name, value = pair_of(text, "--gain-error", "SIGNAL=SHARE")
        if name not in SIGNALS:
            raise InputError(f"--gain-error {text}: no signal has this name.{nearest(name, SIGNALS)}")
        found[name] = share_of(value, "--gain-error")
    at_zero = dict(_of_signal(text, "--zero-error") for text in zeros)
    for name, error in (*found.items(), *at_zero.items()):
        if not 0 <= error < float("inf"):
            raise InputError(
                f"error of {name} = {error:g}: expected a finite standard uncertainty of 0 or more"
            )
    names = dict.fromkeys([*found, *at_zero])
    return {name: CalibrationError(gain=found.get(name, 0.0), zero=at_zero.get(name, 0.0)) for name in names}


def _of_signal(text: str, option: str, *, relative: Collection[str] = ()) -> tuple[str, float]:
    """Read ``SIGNAL=VALUE`` in the unit of the signal; a number without unit is in SI."""
    from electrovib.core.errors import InputError, nearest
    from electrovib.core.signals import SIGNALS
    from electrovib.core.units import parse_quantity

    name, value = pair_of(text, option, "SIGNAL=VALUE")
    if name not in SIGNALS:
        raise InputError(f"{option} {text}: no signal has this name.{nearest(name, SIGNALS)}")
    unit = "1" if name in relative else SIGNALS[name].unit
    try:
        return name, float(value) if _is_number(value) else parse_quantity(value, unit)
    except ValueError as error:
        raise InputError(f"{option} {text}: {error}") from None


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
