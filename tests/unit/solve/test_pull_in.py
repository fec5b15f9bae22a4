"""A gap that forces close altogether is told as what it is."""

from __future__ import annotations

import re

import pytest

from electrovib.core.errors import InputError
from electrovib.physics.contact import pull_in_voltage
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

STIFFNESS, FREE_GAP = 1e8, 20e-6


@pytest.fixture(scope="module")
def base():
    """A spring of 2 kPa over a film of 90 um, pressed with 200 Pa."""
    founding = load("vezzoli_2014/fig6_static")
    layers = founding.stack.to_dict()
    gap = {"thickness": FREE_GAP, "material": {"model": "Constant", "permittivity": 1.0}}
    changes = {
        "stack": {"insulator": layers["insulator"], "gap": gap, "stratum_corneum": layers["stratum_corneum"]},
        "force.model": "MaxwellStressInGap",
        "load.normal_force": 0.02,
        "time.duration": 0.04,
        "contact.surface": {"model": "LinearSpring", "stiffness": STIFFNESS, "free_gap": FREE_GAP},
        "contact.closing": {"damping": 1e6},
    }
    return founding.replace(changes)


def test_a_pull_in_names_gap_time_voltage_and_remedy(base):
    with pytest.raises(InputError) as told:
        simulate(base.replace({"drive": {"model": "Step", "level": 1000.0}}))
    found = re.search(
        r"contact\.closing: the layer 'gap' closes at ([\d.e-]+) s, under a drive of 1000 V: load and attraction press with"
        r" ([\d.e+]+) Pa, and contact\.surface = LinearSpring supports at most ([\d.e+]+) Pa \(pull-in\)\..* lower drive",
        str(told.value),
    )
    assert found
    when, pressing, held = map(float, found.groups())
    # the film alone: eps0 (V/K)^2/2 with K = 90 um/3.35, but for skin that has not charged yet, and the load
    assert pressing == pytest.approx(8.854e-12 * (1000 / (90e-6 / 3.35)) ** 2 / 2 + 200, rel=0.02)
    assert held == pytest.approx(STIFFNESS * FREE_GAP, rel=1e-3)
    assert 1e6 * 18e-6 / 6300 < when < 0.04  # no earlier than the largest pressure closes it


def test_below_the_pull_in_voltage_it_stays_open(base):
    snap = pull_in_voltage(
        stiffness=STIFFNESS, free_gap=FREE_GAP, electrical_thickness=90e-6 / 3.35, pressure=200.0
    )
    drive = {"model": "Step", "level": 0.9 * snap}
    trace = simulate(base.replace({"drive": drive}))
    assert trace.gap.values.min() > 5e-6
