"""Force under a measured drive with jittered time stamps, read from a file."""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np
import xarray as xr

import electrovib as ev


def simulate() -> xr.Dataset:
    """Return the Trace under a measured pulse of 300 V."""
    random = np.random.default_rng(1)
    time = np.cumsum(random.uniform(77e-6, 79e-6, 2000))
    voltage = 300.0 * ((time > 0.05) & (time < 0.1))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "drive.csv"
        np.savetxt(
            file,
            np.column_stack([time * 1e6, voltage]),
            delimiter=",",
            header="time [us],voltage [V]",
            comments="",
        )
        return ev.run("vezzoli_2014/fig6", set={"drive": {"model": "Sampled", "file": str(file)}})


def main() -> float:
    """Return the peak force [N]."""
    return float(simulate().electrostatic_force.max())


if __name__ == "__main__":
    trace = simulate()
    print(f"largest force: {1e3 * float(trace.electrostatic_force.max()):.3f} mN")
    ev.plot.force(trace).figure.savefig("measured_drive.png")
