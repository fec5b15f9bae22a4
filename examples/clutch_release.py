"""Release of an electroadhesive clutch: delay of the force after the drive ends, and resonance of the loaded sensor.

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

import electrovib as ev
from electrovib.physics.drive.readback import OneOfTwoInAntiphase
from electrovib.physics.relaxation import release_seen_by_sensor

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from electrovib.recordings.transitions.times import DirectionTimes

FREQUENCY, QUALITY = 350.0, 3.0
COLUMNS = {"lateral_force_measured": "1 [N]", "drive_voltage": "3 [V]"}
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


def measure(path: Path) -> DirectionTimes:
    """Measure the fall of the force after the drive, with the sensor estimated from the oscillation after it."""
    found = ev.measure_times(
        ev.import_file(path, COLUMNS, time="0 [us]"), quantity="lateral_force_measured", by="drive_voltage",
        readback=READBACK, sensor="estimate", edges="falling", window=20e-3, before=10e-3,
    ).falling  # fmt: skip
    assert found is not None
    return found


def draw(found: DirectionTimes) -> Figure:
    """Draw the measured force, the best form and the exponential."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(7, 4), layout="constrained")
    axes = figure.subplots()
    (edge,) = found.edges
    time = 1e3 * edge.record.fit_time
    axes.plot(time, edge.record.fit_values, ".", ms=3, color="0.4", label="measured")
    for name, style in dict.fromkeys((found.form, "exponential"), "-").items():
        fitted = edge.fitted[name]
        label = f"{name}: residual {fitted.misfit:.2g} times the noise"
        axes.plot(time, fitted.reading, style, label=label)
    axes.set(xlabel="time after the drive ends [ms]", ylabel="force [N]")
    axes.legend(fontsize=8)
    return figure


def main(file: str = "") -> DirectionTimes:
    """Measure a recorded release, or one made up with a loaded cell of 350 Hz."""
    if file:
        return measure(Path(file))
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / "clutch.npy"
        make_record(made)
        return measure(made)


if __name__ == "__main__":
    release = main(*sys.argv[1:])
    for name, number in release.exponential.items():
        print(f"{name}: {number.in_words('Hz' if name == 'frequency' else '' if name == 'quality' else 's')}")
    print("\n".join(release.remarks))
    draw(release).savefig("clutch_release.png", dpi=150)
