"""A recorded swipe: friction of the finger, with the uncertainty due to the zero of the sensors.

Run with a file of your own, ``python measured_swipe.py record.mat``, after writing its calibration below. A column that
is a force already has a unit in place of a sensitivity, {"column": "trial.Fz", "unit": "N", "sign": -1}. Without an encoder
omit it, and state "speed": "40 mm/s" if it is known. With "missing_rows": 20 up to 20 rows with a NaN are omitted.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.model import read_model
from electrovib.physics.rig import TribometerChannels
from electrovib.recordings.recording import read_recording
from electrovib.recordings.swipe.reduce import reduce_swipe
from electrovib.recordings.swipe.result import SwipeResult

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FRICTION, LOAD = 0.4, 0.5
CHANNELS = {
    "lateral": {"column": 0, "sensitivity": "0.4444444444 N/V"},
    "normal": {"column": 1, "sensitivity": "-0.31 N/V"},  # falls under load
    "encoder": {"column": 4, "step": "0.5 um"},
    "clock": {"model": "EvenSamples", "rate": "10 kHz"},
}


def make_record(path: Path) -> None:
    """Write a swipe with drifting zeros, noise and an encoder that wraps, as MATLAB would."""
    import scipy.io

    random = np.random.default_rng(1)
    time = np.arange(60_000) / 10e3
    load = LOAD * np.interp(time, [1.5, 1.6, 4.7, 4.8], [0, 1, 1, 0])
    position = np.interp(time, [2.2, 4.2], [0, 80e-3])
    slides = np.interp(time, [2.2, 2.25, 4.2, 4.25], [0, 1, 1, 0])
    lateral = (FRICTION * load * slides + 0.01 * time) / 0.4444444444 + 3e-3 * random.standard_normal(
        time.size
    )
    normal = (load + 2e-3 * time) / -0.31 + 5.4 + 5e-3 * random.standard_normal(time.size)
    counts = (np.rint(position / 0.5e-6) + 2**32 - 1000) % 2**32
    table = np.column_stack([lateral, normal, 0 * time, 0 * time, counts])
    scipy.io.savemat(path, {"record": table}, do_compression=True)


def draw(swipe: SwipeResult) -> Figure:
    """Draw both forces over time, the window, and friction by choice of the baseline."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(8, 4), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=[3, 1])
    for name in ("normal_force_measured", "lateral_force_measured"):
        left.plot(
            swipe.trace.time, 1e3 * swipe.trace[name], lw=0.6, label=swipe.trace[name].attrs["long_name"]
        )
    left.axvspan(*swipe.window, color="0.9", label="window")
    left.set(xlabel="time [s]", ylabel="force [mN]")
    left.legend(fontsize=7)
    friction = swipe.friction
    right.plot(list(friction.choices.values()), range(len(friction.choices)), "o")
    right.axvspan(*friction.ends, color="0.9")
    right.set_yticks(range(len(friction.choices)), list(friction.choices))
    right.set(xlabel="friction", title="by baseline")
    return figure


def main(file: str = "") -> SwipeResult:
    """Reduce a recorded swipe, or one made up with a friction of 0.4."""
    channels = read_model(TribometerChannels, CHANNELS)
    if file:
        return reduce_swipe(read_recording(Path(file), channels))
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "swipe.mat"
        make_record(made)
        return reduce_swipe(read_recording(made, channels))


if __name__ == "__main__":
    found = main(*sys.argv[1:])
    low, high = found.friction.ends
    print(f"friction {found.friction.value:.3f} ({low:.3f} to {high:.3f})")
    print("\n".join(found.remarks))
    draw(found).savefig("measured_swipe.png", dpi=150)
