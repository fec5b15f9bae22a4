"""Sentences on what a fitted release determines of the clutch and its rig, and on what it does not."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.readback import OneOfTwoInAntiphase

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.physics.drive.readback import Readback
    from electrovib.recordings.release.least_squares import Release
    from electrovib.recordings.release.parts import Decay, Extremum
    from electrovib.recordings.release.uncertainty import Uncertainty

_APART = 3.0
"""Distance of two numbers in standard uncertainties above which they differ."""
_KNOWN = 0.3
"""Relative uncertainty of the frequency from which on the resonance counts as not determined."""
_CALLED = {
    "noise": "noise",
    "window": "start of the fit",
    "fall time": "fall times that fit as well",
    "end": "end of the drive",
    "change": "change during the decay",
}
"""Name of each component of an uncertainty in a sentence."""


def statements_on_fit(
    best: Release,
    uncertainty: Mapping[str, Uncertainty],
    *,
    falls: tuple[float, float],
    without: float,
    extrema: Sequence[Extremum],
    decays: tuple[Decay | None, Decay | None],
) -> tuple[str, ...]:
    """Write what a fitted release determines: on the resonance, the delay, and the change of the frequency."""
    return (
        *_resonance(best, uncertainty, without),
        *_delay(best, uncertainty["delay"], falls),
        *_change(extrema, decays),
    )


def statements_on_record(readback: Readback | None, missing: int) -> tuple[str, ...]:
    """Write how many rows were omitted from a record, and what its drive column does not determine."""
    said = []
    if missing:
        rows = "1 row that holds" if missing == 1 else f"{missing} rows that hold"
        said.append(f"{rows} a NaN {'was' if missing == 1 else 'were'} omitted.")
    if isinstance(readback, OneOfTwoInAntiphase) and readback.stop is None:
        said.append(
            "The drive is taken to end at the last fall of the electrode that was read back. If the other electrode was"
            " driven after that, the drive ended later and the delay is shorter by the same time; readback.stop states when."
        )
    return tuple(said)


def _resonance(best: Release, uncertainty: Mapping[str, Uncertainty], without: float) -> tuple[str, ...]:
    of_frequency, of_quality = uncertainty["frequency"], uncertainty["quality"]
    if not of_frequency.total < _KNOWN * best.frequency:
        return (
            f"The record does not determine a resonance: the best fit, {best.frequency:.0f} Hz, has a standard uncertainty"
            f" of {of_frequency.total:.2g} Hz.",
        )
    return (
        f"One resonance of the loaded assembly (load cell with its load) is fitted: {best.frequency:.0f} Hz with a"
        f" standard uncertainty of {of_frequency.total:.2g} Hz ({_parts(of_frequency, 1, 'Hz')}), quality factor"
        f" {best.quality:.1f} with {of_quality.total:.2g} ({_parts(of_quality, 1, '')}). Its residual is {best.misfit:.1%} of"
        f" the force after the end of the drive; without the resonance the residual is {without:.1%}.",
    )


def _delay(best: Release, uncertainty: Uncertainty, falls: tuple[float, float]) -> tuple[str, ...]:
    said = (
        f"The force falls {best.delay * 1e3:.2f} ms after the end of the drive, with a standard uncertainty of"
        f" {uncertainty.total * 1e3:.2g} ms ({_parts(uncertainty, 1e3, 'ms')})."
    )
    low, high = falls
    if low == 0:
        return (
            said,
            f"The time constant of the fall is not determined: any value up to {high * 1e3:.2g} ms fits as well.",
        )
    return said, (
        f"The time constant of the fall is {best.fall_time * 1e3:.2g} ms; values between {low * 1e3:.2g} and"
        f" {high * 1e3:.2g} ms fit as well."
    )


def _parts(uncertainty: Uncertainty, factor: float, unit: str) -> str:
    return ", ".join(
        f"{_CALLED[name]} {value * factor:.2g} {unit}".rstrip()
        for name, value in uncertainty.components.items()
    )


def _change(extrema: Sequence[Extremum], decays: tuple[Decay | None, Decay | None]) -> list[str]:
    said = []
    times = [extremum.time for extremum in extrema]
    halves = [1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times)]
    if len(halves) >= 2:
        said.append(f"Successive turning points give {', '.join(f'{value:.0f}' for value in halves)} Hz.")
    early, late = decays
    if early and late:
        said.append(
            f"A damped sine fitted from the first turning point on has {early.frequency:.0f} ±"
            f" {early.frequency_uncertainty:.2g} Hz (quality factor {early.quality:.1f}); fitted from three quarters of a"
            f" period later, {late.frequency:.0f} ± {late.frequency_uncertainty:.2g} Hz (quality factor {late.quality:.1f})."
        )
        error = float(np.hypot(early.frequency_uncertainty, late.frequency_uncertainty))
        if abs(late.frequency - early.frequency) > max(_APART * error, 0.01 * early.frequency):
            change = "falls" if late.frequency < early.frequency else "rises"
            said.append(
                f"The frequency {change} during the decay, which no single linear resonance reproduces: part of the"
                " misfit is due to it and not to noise."
            )
    return said
