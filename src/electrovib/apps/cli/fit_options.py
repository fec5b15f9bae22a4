"""Options of ``electrovib fit``, and how their texts are read."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from collections.abc import Collection, Sequence

    from electrovib.recordings.calibration_error import CalibrationError

Recordings: TypeAlias = Annotated[
    list[str], typer.Argument(metavar="RECORD...", help="Trace files with signals over time or frequency.")
]
Free: TypeAlias = Annotated[
    list[str],
    typer.Option(metavar="PATH,PATH,...", help="Parameters to estimate, as dotted paths; repeatable."),
]
Vary: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="PATH,...", help="Those of them that differ between sessions; repeatable."),
]
Session: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="FILE=NAME", help="Session of a recording; by default each is its own. Repeatable."),
]
Noise: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=VALUE",
        help="Standard deviation of a signal, with its unit; of an impedance relative to it: impedance=0.01. Repeatable.",
    ),
]
Zero: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(metavar="SIGNAL", help="Signal whose zero is unknown and is fitted; repeatable."),
]
GainError: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=SHARE",
        help="Relative standard uncertainty of the gain of a sensor, such as electrostatic_force='2 %'; repeatable.",
    ),
]
ZeroError: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SIGNAL=VALUE",
        help="Standard uncertainty of the zero of a sensor, with its unit; repeatable.",
    ),
]
OnlySignal: TypeAlias = Annotated[
    list[str] | None, typer.Option(metavar="SIGNAL", help="Fit only this signal; repeatable.")
]
CompareWith: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="SCENARIO", help="Another model of the same experiment, compared by AICc and BIC; repeatable."
    ),
]
Keep: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="PART",
        help="Take the drive, load or motion of the scenario although the recordings hold their own; repeatable.",
    ),
]
Folder: TypeAlias = Annotated[
    str | None,
    typer.Option(
        "--output",
        "-o",
        metavar="DIR",
        help="Folder for report.html, parameters.csv, parameters.toml and space.toml.",
    ),
]
Separately: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--separately",
        help="Fit each recording alone; one table and one figure for all, with the scatter within and between recordings.",
    ),
]
PosteriorAsked: TypeAlias = Annotated[
    bool,
    typer.Option("--posterior", help="Sample the posterior distribution too, with emcee; needs --seed."),
]
Seed: TypeAlias = Annotated[int | None, typer.Option(help="Seed of the random numbers of --posterior.")]
Steps: TypeAlias = Annotated[int, typer.Option(help="Length of each chain of --posterior.")]


def names_of(texts: Sequence[str]) -> list[str]:
    """Split names at commas."""
    return [name.strip() for text in texts for name in text.split(",") if name.strip()]


def pair_of(text: str, option: str, form: str) -> tuple[str, str]:
    """Split ``NAME=VALUE`` at the last equals sign."""
    from electrovib.core.errors import InputError

    first, sign, second = text.rpartition("=")
    if not (sign and first.strip() and second.strip()):
        raise InputError(f"{option} {text}: expected {form}")
    return first.strip(), second.strip()


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
