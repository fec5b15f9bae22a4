"""The clutch of interdigitated electrodes: published field calculations, the formula, and the stack."""

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.papers.rauf_2025 import CHECKS, clutch_force, materials, scenarios, shear_force
from electrovib.physics.roughness import IdleSpots, PullingSpots
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
FIELD_POINTS = dict(zip(MEASURED, (check.expect for check in CHECKS[:6]), strict=True))


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


FRICTION, LOAD = 0.17, 0.13
PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "5_which_gap.md"


def rows(label):
    """Return both rows of the tables of the page that begin with a label, and those below them, without it."""
    lines = [line.strip("|").split("|") for line in PAGE.read_text(encoding="utf-8").splitlines()]
    cells = [[cell.strip() for cell in line] for line in lines]
    return [cells[at + below][1:] for below in (0, 1) for at, row in enumerate(cells) if row[0] == label]


def test_no_contact_attracts_as_much_at_half_of_the_voltage_as_was_measured():
    """C V^2/(2 K) bounds eps0 V^2/2 mean(1/(g + K)^2), for every gap g: with the capacitance under load and attraction."""
    known = of_publication("rauf_2025")
    meter, force = known["capacitance_2mm"], known["voltage"]
    film = meter.scenario.stack.layers["insulator"]
    thickness = film.thickness / float(film.material.complex_permittivity(1e3).real)
    attraction = np.array(force.values) / FRICTION
    capacitance = 4 * np.interp(LOAD + attraction, meter.at, meter.values)
    most = capacitance * np.array(force.at) ** 2 / (2 * thickness)
    over = attraction / most
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    first, last = re.search(r"is ([\d.]+) times that at 100 V and ([\d.]+) times at 300 V", text).groups()
    assert [4 * over[0], 4 * over[-1]] == pytest.approx([float(first), float(last)], abs=0.006)
    first, last = re.search(r"needs (\d+) % of the capacitance at 100 V, and (\d+) % at 300 V", text).groups()
    assert 100 * over[[0, -1]] == pytest.approx([float(first), float(last)], abs=0.6)
    assert min(4 * over) > 1.25


def test_from_150_volts_on_the_exponents_are_those_that_the_page_states():
    text = " ".join(PAGE.read_text(encoding="utf-8").split())
    stated = re.search(
        r"the measured exponent is ([\d.]+), .* have ([\d.]+) to ([\d.]+); runs", text
    ).groups()
    table = [rows("measured")[0], *rows("from 1 N on")[::2], *rows("from 1 N on, a third of the area")[::2]]
    voltage = np.log(of_publication("rauf_2025")["voltage"].at[2:])
    found = [np.polyfit(voltage, np.log([float(each) for each in row[2:]]), 1)[0] for row in table]
    expected = [float(each) for each in stated]
    assert [found[0], min(found[1:]), max(found[1:])] == pytest.approx(expected, abs=0.006)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("label", "share", "least"),
    [("all loads", 1, 0.0), ("from 1 N on", 1, 1.0), ("from 1 N on, a third of the area", 1 / 3, 1.0)],
)
def test_the_predictions_of_the_page_are_those_of_the_capacitance(label, share, least):
    """One contact with the whole voltage across film and gap, of all electrodes."""
    known = of_publication("rauf_2025")
    meter, force = known["capacitance_2mm"], known["voltage"]
    loads, capacitance = np.array([meter.at, meter.values])[:, np.array(meter.at) >= least]
    found = ev.fit_contact(
        meter.scenario.replace({"contact.area": 84e-6 * share}),
        load=loads,
        capacitance=4 * capacitance,  # two contacts of half of the area in series
        roughness=ev.SelfAffine(rms=3e-6, hurst=0.8, longest=2e-3, roll_off=2e-3, shortest=62.5e-6),
        body=ev.Elastic(modulus=3e8, poisson=0.4),
    )
    predicted = rows(label)
    for numbers, summary, spots in zip(
        predicted[::2], predicted[1::2], (PullingSpots(), IdleSpots()), strict=True
    ):
        seen = np.array(force.values) / FRICTION
        pulled = found.predict(voltage=force.at, load=LOAD, measured=seen, spots=spots)
        np.testing.assert_allclose(FRICTION * pulled.force, [float(each) for each in numbers], atol=6e-4)
        own, measured = pulled.slopes
        assert [pulled.typical_factor, own] == pytest.approx(
            [float(each) for each in summary[2:4]], abs=0.006
        )
        assert measured == pytest.approx(1.99, abs=0.006)
        growth = [
            np.diff([found.predict(voltage=[volt], load=load, spots=spots).force[0] for load in (0.1, 1.5)])[
                0
            ]
            for volt in (150.0, 200.0, 250.0, 300.0)
        ]
        expected = [float(each) for each in summary[4].split(", ")]
        np.testing.assert_allclose(FRICTION * np.array(growth) / 1.4, expected, atol=6e-4)
    scatter, numbers = predicted[1][0], predicted[1][1]
    assert f"{100 * found.scatter:.1f} %" == scatter
    height, modulus = re.match(r"([\d.]+) µm, ([\d.]+) [MG]Pa", numbers).groups()
    unit = 1e9 if "GPa" in numbers else 1e6
    assert [1e6 * found.rms.value, found.modulus.value / unit] == pytest.approx(
        [float(height), float(modulus)], rel=0.01
    )
