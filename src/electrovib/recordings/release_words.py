"""What a fitted release says of the clutch and its rig, and what it leaves open, in sentences."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import numpy as np

from electrovib.physics.drive.readback import OneOfTwoInAntiphase

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.physics.drive.readback import Readback
    from electrovib.recordings.release_fit import Release
    from electrovib.recordings.release_parts import Decay, Extremum
    from electrovib.recordings.release_uncertainty import Uncertainty

_APART = 3.0
"""Two numbers differ if they lie this many standard uncertainties apart."""
_KNOWN = 0.3
"""A resonance whose frequency is known no better than to this share is not determined."""
_CALLED = {
    "noise": "noise",
    "window": "start of the fit",
    "fall time": "fall times that fit as well",
    "end": "end of the drive",
    "change": "change while it dies away",
}
"""Components of an uncertainty, in a sentence."""


def words_about(
    best: Release,
    uncertainty: Mapping[str, Uncertainty],
    *,
    falls: tuple[float, float],
    without: float,
    extrema: Sequence[Extremum],
    decays: tuple[Decay | None, Decay | None],
) -> tuple[str, ...]:
    """Say what a fitted release determines.

    Parameters
    ----------
    best : Release
        The fit.
    uncertainty : mapping of str to Uncertainty
        Of ``delay``, ``frequency`` and ``quality``.
    falls : tuple of float
        Between which fall times the fit is as good [s].
    without : float
        Misfit without the resonance [1].
    extrema : sequence of Extremum
        Turning points.
    decays : tuple of Decay or None
        From the first turning point and from three quarters of a period later.

    Returns
    -------
    tuple of str
        Sentences.
    """
    return (
        *_resonance(best, uncertainty, without),
        *_delay(best, uncertainty["delay"], falls),
        *_change(extrema, decays),
    )


def about_the_record(readback: Readback | None, missing: int) -> tuple[str, ...]:
    """Say what was left out of a record, and what its drive column cannot tell.

    Parameters
    ----------
    readback : Readback or None
        What the column is of the drive.
    missing : int
        Rows that were left out.

    Returns
    -------
    tuple of str
        Sentences; none where there is nothing to say.
    """
    said = []
    if missing:
        rows = "1 row that holds" if missing == 1 else f"{missing} rows that hold"
        said.append(f"{rows} a NaN {'was' if missing == 1 else 'were'} left out.")
    if isinstance(readback, OneOfTwoInAntiphase) and readback.stop is None:
        said.append(
            "The drive counts as ended at the last fall of the electrode that was read back. If the other electrode was"
            " driven after that, the drive ended later and the delay is that much shorter; readback.stop says when."
        )
    return tuple(said)


def _resonance(best: Release, uncertainty: Mapping[str, Uncertainty], without: float) -> tuple[str, ...]:
    of_frequency, of_quality = uncertainty["frequency"], uncertainty["quality"]
    if not of_frequency.total < _KNOWN * best.frequency:
        return (
            f"The record does not determine a resonance: the best one, {best.frequency:.0f} Hz, is uncertain by"
            f" {of_frequency.total:.2g} Hz.",
        )
    return (
        f"One resonance of the loaded assembly (load cell with all that it carries), {best.frequency:.0f} Hz with a"
        f" standard uncertainty of {of_frequency.total:.2g} Hz ({_parts(of_frequency, 1, 'Hz')}), quality"
        f" {best.quality:.1f} with {of_quality.total:.2g} ({_parts(of_quality, 1, '')}), leaves {best.misfit:.1%} of the"
        f" force after the drive ends; the same release without it leaves {without:.1%}.",
    )


def _delay(best: Release, uncertainty: Uncertainty, falls: tuple[float, float]) -> tuple[str, ...]:
    said = (
        f"The force lets go {best.delay * 1e3:.2f} ms after the drive ends, with a standard uncertainty of"
        f" {uncertainty.total * 1e3:.2g} ms ({_parts(uncertainty, 1e3, 'ms')})."
    )
    low, high = falls
    if low == 0:
        return (
            said,
            f"How fast it falls is not determined: any time constant up to {high * 1e3:.2g} ms fits as well.",
        )
    return said, (
        f"It falls with a time constant of {best.fall_time * 1e3:.2g} ms; between {low * 1e3:.2g} and"
        f" {high * 1e3:.2g} ms fit as well."
    )


def _parts(uncertainty: Uncertainty, factor: float, unit: str) -> str:
    """List the components."""
    return ", ".join(
        f"{_CALLED[name]} {value * factor:.2g} {unit}".rstrip()
        for name, value in uncertainty.components.items()
    )


def _change(extrema: Sequence[Extremum], decays: tuple[Decay | None, Decay | None]) -> list[str]:
    """Say whether the ringing keeps its frequency."""
    said = []
    times = [extremum.time for extremum in extrema]
    halves = [1 / (2 * (later - earlier)) for earlier, later in itertools.pairwise(times)]
    if len(halves) >= 2:
        said.append(f"Successive turning points give {', '.join(f'{value:.0f}' for value in halves)} Hz.")
    early, late = decays
    if early and late:
        said.append(
            f"A damped sine gives {early.frequency:.0f} Hz, give or take {early.frequency_uncertainty:.2g} Hz (quality"
            f" {early.quality:.1f}), from the first turning point and {late.frequency:.0f} Hz, give or take"
            f" {late.frequency_uncertainty:.2g} Hz (quality {late.quality:.1f}), three quarters of a period later."
        )
        error = float(np.hypot(early.frequency_uncertainty, late.frequency_uncertainty))
        if abs(late.frequency - early.frequency) > max(_APART * error, 0.01 * early.frequency):
            way = "falls" if late.frequency < early.frequency else "rises"
            said.append(
                f"The frequency {way} while the ringing dies away: no single linear resonance does that, so part of the"
                " misfit is that, and not noise."
            )
    return said
