"""A waveform that rises from 0 V and falls to 0 V over a ramp at either end."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.errors import InputError

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.studies.waveform import Waveform


def ramped(waveform: Waveform, ramp: float) -> Waveform:
    """Multiply a waveform by an envelope that rises linearly from 0 to 1 and falls back to 0 at its end.

    With samples s and envelope e, the straight line between two products departs from the product of two
    straight lines by at most |ds de|/4; a held product departs from s e(t) by at most |s de|. Either is added
    to the error.
    """
    last = len(waveform.times) - 1
    if not (math.isfinite(ramp) and ramp > 0):
        raise InputError("must be a time above 0 s", path="ramp", value=str(ramp))
    count = max(1, round(ramp * waveform.rate))
    if 2 * count > last:
        why = f"two ramps do not fit into {float(waveform.times[-1]):g} s; take a shorter ramp"
        raise InputError(why, path="ramp", value=f"{ramp:g}")
    envelope = envelope_of(last, count)
    voltages = np.where(envelope == 0, 0.0, waveform.voltages * envelope)
    steps = np.abs(np.diff(envelope))
    sizes = np.abs(waveform.voltages[:-1]) if waveform.held else np.abs(np.diff(waveform.voltages)) / 4
    return replace(waveform, voltages=voltages, error=waveform.error + float(np.max(sizes * steps)))


def envelope_of(last: int, count: int) -> Real:
    """Return the envelope (last + 1,) of a waveform from 0 to 1, with `count` intervals of either ramp."""
    places = np.arange(last + 1)
    return np.minimum(1.0, np.minimum(places, last - places) / count)
