"""The largest voltage of a drive counts as the same number wherever one is needed."""

from __future__ import annotations

import pytest

import electrovib as ev

PULSE = {
    "model": "Trapezium",
    "high": "100 V",
    "delay": "20.03 ms",
    "rise": 0.0,
    "hold": "8 us",
    "fall": 0.0,
} | {"repeat": "0.1 s"}
HELD = {"model": "Step", "level": "100 V"}
SKIN = {"model": "Constant", "permittivity": 1000, "conductivity": "1 uS/m"}


def scenario(drive):
    return ev.load(
        {
            "schema": 1,
            "drive": drive,
            "force": {"model": "MaxwellStressInGap"},
            "friction": {"model": "Coulomb", "coefficient": 0.5},
            "contact": {
                "model": "FixedArea",
                "area": "1 cm2",
                "surface": {"model": "LinearSpring", "stiffness": "1 TPa/m", "free_gap": "2 um"},
            },
            "load": {"normal_force": "0.5 N"},
            "circuit": {"return_path": {"model": "Grounded", "resistance": "1 kohm"}},
            "stack": {
                "insulator": {"thickness": "1 um", "material": {"model": "Constant", "permittivity": 3}},
                "gap": {"thickness": "2 um"},
                "stratum_corneum": {"thickness": "200 um", "material": SKIN},
            },
        }
    )


def offset(drive, level):
    return {"model": "Offset", "drive": drive, "level": level}


@pytest.mark.parametrize(
    ("short", "held"),
    [(PULSE, HELD), (offset(PULSE, "50 V"), HELD | {"level": "150 V"})],
    ids=["pulse", "pulse on an offset"],
)
def test_a_short_pulse_counts_everywhere(short, held):
    """8 us at 20.03 ms fall between any even times; it is held against the same voltage for ever."""
    one, other = scenario(short), scenario(held)
    assert ev.equilibrium(one).voltage == ev.equilibrium(other).voltage
    assert ev.equilibrium(one).force == ev.equilibrium(other).force
    assert ev.equilibrium(one).force[0] > 0.05
    assert ev.simulate(one).mean_force.values.tolist() == ev.simulate(other).mean_force.values.tolist()
    statics = [ev.compare(each).entries for each in (one, other)]
    assert [entry.static for entry in statics[0]] == [entry.static for entry in statics[1]]
