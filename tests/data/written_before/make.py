"""How the Traces beside this script were made: by the commit of this repository that their names begin with.

    git archive COMMIT src | tar -x -C OLD
    PYTHONPATH=OLD/src python tests/data/written_before/make.py COMMIT

a727f48 is the last commit in which the validity of a Trace was the attribute ``lamps``, laws were named ``GapPlane`` ... and
the time profile of a load or a motion was its ``programme``; 7cb751d is the last in which the drive ``Step`` was named
``Constant``.
"""

from __future__ import annotations

import sys
from pathlib import Path

import electrovib as ev

HERE = Path(__file__).parent
COMMIT = sys.argv[1]
LAYERS = {
    "insulator": {"thickness": "1 um", "material": {"model": "Constant", "permittivity": 3.9}},
    "gap": {"thickness": "3 um"},
    "stratum_corneum": {
        "thickness": "200 um",
        "material": {"model": "Constant", "permittivity": 1560, "conductivity": "1.8 uS/m"},
    },
}
SMALL = {
    "title": f"written by {COMMIT}",
    "drive": {"model": "Step", "level": "100 V"},
    "force": {"model": "GapPlane"},
    "friction": {"model": "Coulomb", "coefficient": 0.5},
    "contact": {"model": "FixedArea", "area": "1 cm2"},
    "load": {"normal_force": "0.5 N", "programme": {"model": "Press", "rise": "1 ms"}},
    "motion": {
        "speed": "20 mm/s",
        "programme": {"model": "Swipe", "rise": "1 ms", "hold": "3 ms", "fall": "1 ms"},
    },
    "circuit": {"return_path": {"model": "Grounded", "resistance": "1 kohm"}},
    "stack": LAYERS,
    "time": {"duration": "5 ms", "samples": 11},
    "frequency": {"low": 10, "high": 1000, "samples": 3},
}


KEPT = ["drive_voltage", "electrostatic_force", "lateral_force", "mean_force"]
"""Signals of the run, so that its files are small."""


def main() -> None:
    """Write a run and a sweep in each format, and a sweep over a time profile; or one file of the earlier commit."""
    if COMMIT == "7cb751d":
        constant = SMALL | {"drive": {"model": "Constant", "level": "100 V"}}
        ev.save(ev.simulate(ev.load(constant)), HERE / f"{COMMIT}_run.mat")
        return
    scenario = ev.load(SMALL)
    run = ev.simulate(scenario)
    wanted = ["peak electrostatic_force", "mean lateral_force"]
    sweep = ev.sweep(scenario, {"drive.level": [50.0, 100.0]}, quantities=wanted)
    for suffix in (".nc", ".csv", ".mat"):
        ev.save(run[KEPT], HERE / f"{COMMIT}_run{suffix}")
        ev.save(sweep, HERE / f"{COMMIT}_sweep{suffix}")
    profile = ev.sweep(scenario, {"load.programme.rise": [1e-3, 2e-3]}, quantities=wanted)
    ev.save(profile, HERE / f"{COMMIT}_sweep_of_profile.mat")


if __name__ == "__main__":
    main()
