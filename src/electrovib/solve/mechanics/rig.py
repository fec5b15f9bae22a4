"""Motion of the skin, and readings of the rig."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.solve.mechanics.filters import of_stages
from electrovib.solve.mechanics.response import MOST, increasing

if TYPE_CHECKING:
    from collections.abc import Callable

    from numpy.typing import ArrayLike, NDArray

    from electrovib.core.arrays import Real
    from electrovib.physics.finger import Finger
    from electrovib.physics.rig import Digitiser, Rig
    from electrovib.solve.mechanics.filters import Filter

    Response: TypeAlias = Callable[[Filter, Real], tuple[Real, float]]


def finger_filters(finger: Finger) -> dict[str, Filter]:
    """Return the filters from the lateral force to the motion of the skin."""
    displacement = finger.compliance_at_rest() * of_stages((finger.resonance(),))
    return {"skin_displacement": displacement, "skin_speed": displacement.rate()}


@dataclass(frozen=True, eq=False)
class Measured:
    """Readings of a rig.

    Parameters
    ----------
    signals : dict of str to ndarray, shape (n,)
        ``normal_force_measured`` and ``lateral_force_measured`` at the output times [N].
    error : float
        Relative error, as from `respond_mechanically` [1].
    diagnostics : list of Diagnostic
        One for each channel of a digitiser: whether its range was exceeded.
    """

    signals: dict[str, Real]
    error: float
    diagnostics: list[Diagnostic]


def measured(
    rig: Rig,
    times: ArrayLike,
    normal: Response | None,
    lateral: Response,
    *,
    most: int = MOST,
    unknown: Callable[[Filter, Real], NDArray[np.bool_]] | None = None,
) -> Measured:
    """Compute the readings of a rig: forces through its sensors, digitised with its noise.

    `times` (n,) [s]; `normal` and `lateral` return the output of a sensor under that force at some times, and its error.
    """
    stamps = increasing(times)
    moments = stamps if rig.digitiser is None else _moments(rig.digitiser, stamps, most)
    found, worst, sensor = {}, 0.0, of_stages(rig.lateral_stages())
    if normal is not None:
        found["normal"], worst = normal(of_stages(rig.normal_stages()), moments)
    found["lateral"], error = lateral(sensor, moments)
    if unknown is not None:
        found["lateral"] = np.where(unknown(sensor, moments), np.nan, found["lateral"])
    worst = max(worst, error)
    signals, diagnostics = found, list[Diagnostic]()
    if rig.digitiser is not None:
        signals, diagnostics = _digitised(rig, rig.digitiser, found)
        place = np.floor((stamps - stamps[0]) * rig.digitiser.sampling_rate + 1e-6).astype(int)
        signals = {name: values[np.minimum(place, len(moments) - 1)] for name, values in signals.items()}
    return Measured({f"{name}_force_measured": row for name, row in signals.items()}, worst, diagnostics)


def _moments(digitiser: Digitiser, stamps: Real, most: int) -> Real:
    """Return the times of the readings; one at the last output time, apart from rounding, is included."""
    count = refuse_readings(digitiser, span=float(stamps[-1] - stamps[0]), most=most)
    moments: Real = np.minimum(stamps[0] + np.arange(count) / digitiser.sampling_rate, stamps[-1])
    return moments


def refuse_readings(digitiser: Digitiser, *, span: float, most: int) -> int:
    """Return the number of readings of a digitiser, refusing too many."""
    count = math.floor(span * digitiser.sampling_rate + 1e-6) + 1
    if 2 * count > most:
        raise InputError(
            f"digitiser.sampling_rate = {format_quantity(digitiser.sampling_rate, 'Hz')}: {count} readings are"
            f" more than half of {most}. Lower the rate, or choose a shorter time."
        )
    return count


def _digitised(
    rig: Rig, digitiser: Digitiser, forces: dict[str, Real]
) -> tuple[dict[str, Real], list[Diagnostic]]:
    """Return readings with noise, quantisation and clipping, and their diagnostics; each channel has its own noise."""
    streams = np.random.SeedSequence(digitiser.seed).spawn(2)
    ranges = (digitiser.normal_range, digitiser.lateral_range)
    readings, diagnostics = {}, []
    for (name, force), noise, full_scale, stream in zip(
        forces.items(), rig.noises(), ranges, streams, strict=True
    ):
        seen = force + noise * np.random.default_rng(stream).standard_normal(len(force))
        readings[name] = digitiser.reading(seen, full_scale=full_scale)
        nearest = digitiser.levels(seen, full_scale=full_scale) * (full_scale / 2.0 ** (digitiser.bits - 1))
        known, allowed = np.isfinite(seen), format_quantity(full_scale, "N")
        beyond = int(np.count_nonzero((readings[name] != nearest) & known))
        text = (
            f"{beyond} of {np.count_nonzero(known)} {name} readings lie beyond the range of {allowed} and are clipped"
            if beyond
            else f"no {name} reading lies beyond the range of {allowed}"
        )
        diagnostics.append(Diagnostic(f"{name} range", "warning" if beyond else "ok", text))
    return readings, diagnostics
