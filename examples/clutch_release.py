"""Release of an electroadhesive clutch: delay of the force, and damped oscillation of the load cell with the clutch.

Run with a file of your own, ``python clutch_release.py record.npy``: time [us], force [N], any, and the
voltage [V] read back from one of two electrodes driven in antiphase. If the voltage is that of the whole drive, set
READBACK = None.
"""

from __future__ import annotations

import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.data.registry import read_columns
from electrovib.physics.drive.readback import OneOfTwoInAntiphase
from electrovib.physics.relaxation import release_seen_by_sensor
from electrovib.recordings.release import FittedRelease, fit_release

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FREQUENCY, QUALITY = 350.0, 3.0
COLUMNS = {"time": (0, "us"), "force": (1, "N"), "voltage": (3, "V")}
READBACK = OneOfTwoInAntiphase()


def make_record(path: Path) -> None:
    """Write a clutch whose force begins to fall 0.4 ms after the drive ends, with an oscillation, jitter and noise."""
    random = np.random.default_rng(1)
    time = np.cumsum(random.integers(77, 80, 8000)) * 1e-6
    voltage = np.where((time > 0.1) & (time < 0.5) & ((time * 1000) % 1 < 0.5), 300.0, 2.0)
    end = np.mean(time[np.flatnonzero(voltage > 150)[-1] + np.arange(2)])
    shape = release_seen_by_sensor(
        time, start=end + 0.4e-3, fall_time=0.1e-3, frequency=FREQUENCY, quality=QUALITY
    )
    force = 0.05 + 0.7 * shape * np.clip((time - 0.1) / 0.1, 0, 1) + 5e-3 * random.standard_normal(time.size)
    np.save(path, np.column_stack([time * 1e6, force, 0 * time, voltage]))


def draw(found: FittedRelease) -> Figure:
    """Draw the measured force and both fits."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    axes.plot(1e3 * found.time, found.force, ".", ms=3, color="0.4", label="measured")
    uncertain = found.uncertainty["frequency"].standard_error
    label = f"release, resonance of {found.frequency:.0f} ± {uncertain:.0f} Hz: residual {found.misfit:.1%}"
    axes.plot(1e3 * found.time, found.model, label=label)
    axes.plot(
        1e3 * found.time,
        found.model_without,
        "--",
        label=f"release alone: residual {found.misfit_without:.1%}",
    )
    inside = [extremum for extremum in found.extrema if extremum.time <= found.time[-1]]
    axes.plot([1e3 * extremum.time for extremum in inside], [extremum.force for extremum in inside], "k+")
    axes.set(xlabel="time after the drive ends [ms]", ylabel="force [N]")
    axes.legend(fontsize=8)
    return figure


def main(file: str = "") -> FittedRelease:
    """Fit a recorded release, or one made up with a loaded cell of 350 Hz."""
    if file:
        return fit_release(**read_columns(Path(file), COLUMNS), readback=READBACK)
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "clutch.npy"
        make_record(made)
        return fit_release(**read_columns(made, COLUMNS), readback=READBACK)


if __name__ == "__main__":
    release = main(*sys.argv[1:])
    print(f"the force falls {1e3 * release.delay:.2f} ms after the end of the drive")
    print("\n".join(release.words))
    draw(release).savefig("clutch_release.png", dpi=150)
