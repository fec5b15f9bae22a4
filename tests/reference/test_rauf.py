"""The clutch of interdigitated electrodes: published field calculations, the formula, and the stack."""

import numpy as np
import pytest
from scipy.optimize import brentq

from electrovib.core.constants import eps0
from electrovib.papers.rauf_2025 import FIELD_POINTS, clutch_force, materials, scenarios, shear_force
from electrovib.solve.prepare import prepare
from electrovib.solve.simulate import simulate
from electrovib.studies.evidence.files import of_publication

MEASURED = {  # formula over field calculation, evaluated apart from this code, three digits
    (50.0, 10e-9): 0.999,
    (50.0, 1e-6): 0.989,
    (50.0, 10e-6): 0.946,
    (3.0, 10e-9): 0.996,
    (3.0, 1e-6): 0.996,
    (3.0, 10e-6): 0.988,
}


@pytest.mark.parametrize("point", FIELD_POINTS, ids=str)
def test_field_calculations(point):
    permittivity, gap = point
    ratio = clutch_force(voltage=300.0, gap=gap, permittivity=permittivity) / FIELD_POINTS[point]
    assert ratio == pytest.approx(MEASURED[point], abs=6e-4)
    # the stress inside the dielectric is not the force
    inside = clutch_force(voltage=300.0, gap=gap, permittivity=permittivity) / permittivity
    assert abs(inside / FIELD_POINTS[point] - 1) > 0.5


@pytest.mark.parametrize("point", FIELD_POINTS, ids=str)
def test_two_contacts_of_a_stack_are_the_formula(point):
    permittivity, gap = point
    changes = {"stack.insulator.material.permittivity": permittivity, "stack.gap.thickness": gap}
    scenario = scenarios()["field_50"].replace(changes)
    force = float(simulate(scenario, time=np.array([0.0, 1e-3])).electrostatic_force[-1])
    # plates in series, no more than a dozen roundings
    assert force == pytest.approx(clutch_force(voltage=300.0, gap=gap, permittivity=permittivity), rel=1e-12)
    one = scenario.replace({"circuit.return_path": {"model": "Grounded", "resistance": 0.0}})
    alone = float(simulate(one, time=np.array([0.0, 1e-3])).electrostatic_force[-1])
    assert alone == pytest.approx(2 * force, rel=1e-12)  # half of the area at twice the voltage


def test_film_polarises_within_its_fit():
    permittivity = materials()["relaxor"].complex_permittivity(
        np.array([1e-3, 1 / (2 * np.pi * 2.82e-6), 1e15])
    )
    assert permittivity[0].real == pytest.approx(54.2, rel=1e-3)
    assert permittivity[2].real == pytest.approx(4.0, rel=1e-3)
    # half of the strength in phase at the relaxation frequency, whatever the broadening
    assert permittivity[1].real == pytest.approx((54.2 + 4.0) / 2, rel=1e-9)
    assert np.all(permittivity.imag < 0)


def test_slow_film_pulls_less_at_first():
    trace = simulate(scenarios()["relaxor"], time=np.array([0.0, 1e-5, 9e-4]))
    _, early, late = trace.electrostatic_force.values
    settled = clutch_force(voltage=300.0, gap=1e-6, permittivity=54.2)
    assert 0.5 * settled < early < late < settled
    assert late > 0.95 * settled


def test_a_smaller_gap_would_give_the_measured_force_of_the_clutch():
    """The gaps that the likely cause names: found by bisection at both ends and at the extremes in between."""
    declared = of_publication("rauf_2025")["voltage"]
    made = prepare(
        declared.scenario.replace({"friction.coefficient": 0.17}),
        free=["drive.amplitude", "stack.gap.thickness"],
        quantity=["mean lateral_force"],
    )
    for times, low, high in ((1.0, 0.78e-6, 0.98e-6), (4.0, 2.03e-6, 2.45e-6)):
        gaps = []
        for voltage, force in zip(declared.at, declared.values, strict=True):

            def over(log_gap, voltage=voltage, force=force, times=times):
                point = {"drive.amplitude": voltage, "stack.gap.thickness": float(np.exp(log_gap))}
                return times * made(point)["mean lateral_force"] / force - 1

            gaps.append(np.exp(brentq(over, np.log(1e-7), np.log(1e-5), xtol=1e-3)))
        assert min(gaps) == pytest.approx(low, rel=0.02)
        assert max(gaps) == pytest.approx(high, rel=0.02)
    assert "0.78 to 0.98 um" in declared.cause
    assert "2.03 to 2.45 um" in declared.cause


def test_friction_of_load_and_attraction_follows_the_permittivity_of_the_film():
    """The attraction of the smaller permittivity at a frequency; the friction of the load is the same at all."""
    clutch = of_publication("rauf_2025")["frequency_150V_of_surfaces"].scenario
    clutch = clutch.replace(
        {"contact.surface.free_gap": 2e-6, "contact.surface.stiffness": 1e12, "load.normal_force": 0.5}
    )
    before = clutch.friction.coefficient * 0.5
    forces = []
    for frequency in (0.1, 1e4, 1e7):
        permittivity = float(materials()["relaxor"].complex_permittivity(frequency).real)
        there = clutch.replace({"drive.frequency": frequency})
        gap = 2e-6  # stiff enough to stay
        expected = eps0 * 84e-6 * (75.0 / (24e-6 / permittivity + gap)) ** 2 / 2 * clutch.friction.coefficient
        forces.append(shear_force(there) - before)
        assert forces[-1] == pytest.approx(expected, rel=0.02)
    assert forces[0] > forces[1] > forces[2] > 0
