"""Rough contact of a scenario: its numbers against the maps, energies, plates, and what is refused."""

import csv
import io

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.solve.rough_contact import Loaded, MaxwellStress

PAPER = "bau_2010/sine"
GIVEN = {"rms": 2e-6, "hurst": 0.8, "longest": 1e-3, "roll_off": 2.5e-4, "shortest": 1.25e-4}
REACH = 1e-6 / 3.9
"""Electrical thickness of the paper's insulator [m]."""
AREA, LOAD = 1e-4, 0.5
CURRENT = {"model": "CurrentAmplifier", "command": {"model": "Sine", "amplitude": 0.1, "frequency": 125.0}}


def solved(changes=None, **other):
    rough = ev.SelfAffine(**GIVEN | other.pop("roughness", {}))
    body = other.pop("body", ev.Elastic(modulus=1e7))
    scenario = ev.load(PAPER, changes=changes or {})
    return ev.rough_contact(scenario, **{"roughness": rough, "body": body, "points": 64} | other)


@pytest.fixture(scope="module")
def found():
    return solved(voltage=[0.0, 19.99, 20.0, 20.01])


def test_the_numbers_are_those_of_the_maps(found):
    for at, (volt, rest) in enumerate(zip(found.voltage, found.rests, strict=True)):
        field = volt / (rest.gap + REACH)
        assert rest.gap.shape == (64, 64)
        assert found.attraction[at] == pytest.approx(np.mean(eps0 * field**2 / 2), rel=1e-9)
        assert found.force[at] == pytest.approx(found.attraction[at] * AREA, rel=1e-12)
        assert found.capacitance[at] == pytest.approx(eps0 * AREA * np.mean(1 / (rest.gap + REACH)), rel=1e-9)
        assert found.contact_share[at] == np.mean(rest.gap == 0) > 0
        assert found.mean_gap[at] == pytest.approx(rest.gap.mean(), rel=1e-12)
        plates = eps0 * volt**2 / (2 * (rest.gap.mean() + REACH) ** 2)
        assert found.plates[at] == pytest.approx(plates, rel=1e-9)
        assert rest.pressure.mean() == pytest.approx(LOAD / AREA + found.attraction[at], rel=1e-5)


def test_the_energy_falls_with_the_voltage_by_the_charge(found):
    energy = [rest.energy for rest in found.rests]
    slope = (energy[3] - energy[1]) / (found.voltage[3] - found.voltage[1])
    assert slope == pytest.approx(-found.capacitance[2] * found.voltage[2] / AREA, rel=1e-5)


def test_a_nearly_even_surface_is_plates_that_touch():
    found = solved(roughness={"rms": 1e-12}, voltage=[20.0])
    assert found.attraction[0] == pytest.approx(eps0 * 20**2 / (2 * REACH**2), rel=1e-9)
    assert found.contact_share[0] == 1
    assert found.capacitance[0] == pytest.approx(eps0 * AREA / REACH, rel=1e-9)


def test_a_stiff_body_keeps_the_heights_and_their_seed():
    for seed in (0, 3):
        found = solved(body=ev.Elastic(modulus=1e16), voltage=[0.0], seed=seed)
        heights = ev.SelfAffine(**GIVEN).heights((64, 64), (1e-3, 1e-3), seed=seed)
        assert found.rests[0].gap == pytest.approx(heights.max() - heights, abs=1e-11)
        assert found.mean_gap[0] == pytest.approx(heights.max(), rel=1e-5)
        assert found.rests[0].gap.std() == pytest.approx(2e-6, rel=1e-5)


def test_up_and_down_have_two_branches_where_the_contact_falls():
    volts = [0.0, 20.0, 50.0, 20.0, 0.0]
    found = solved(body=ev.Elastic(modulus=1e6), voltage=volts)
    assert found.voltage.tolist() == volts
    assert found.contact_share[2] == 1
    assert found.attraction[3] > 1.02 * found.attraction[1]
    assert found.contact_share[3] > 1.02 * found.contact_share[1]
    assert found.attraction[4] == found.attraction[0] == 0
    assert "between 20 V and 50 V the contact passes states that are not stable" in str(found)
    assert "between 0 V and 50 V the contact passes" in str(
        solved(body=ev.Elastic(modulus=1e6), voltage=50.0)
    )
    assert found.at_largest_voltage == 2


def test_the_grid_and_the_waves_beside_it(found):
    fine = solved(voltage=[0.0, 20.0], points=128)
    assert fine.coarser[0].tolist() == found.contact_share[[0, 2]].tolist()
    assert fine.coarser[1] == pytest.approx(found.attraction[[0, 2]], rel=1e-5)
    smooth = ev.SelfAffine(**GIVEN).without_shortest_octave()
    even = ev.rough_contact(
        PAPER, roughness=smooth, body=ev.Elastic(modulus=1e7), points=64, voltage=[0.0, 20.0]
    )
    assert fine.smoother[0].tolist() == even.contact_share.tolist()
    assert fine.smoother[1] == pytest.approx(even.attraction, rel=1e-5)


def test_the_sentences_say_the_numbers_of_the_largest_voltage():
    found = solved(voltage=[0.0, -20.0, 10.0])
    first, second = found.document.sentences[:2]
    share, ratio = 100 * found.contact_share[1], found.attraction[1] / found.plates[1]
    assert first.startswith(f"at -20 V under a load of 5 kPa {share:.3g} % of the area touch")
    assert f"{ratio:.3g} times that of plates" in first
    coarse, beside = found.coarser[:, 1]
    assert second.startswith(
        f"on every second point of the grid {100 * coarse:.3g} % touch"
        f" and {beside / found.attraction[1]:.3g} times the attraction; without roughness shorter than 250 um"
    )
    assert found.attraction[1] == pytest.approx(solved(voltage=20.0).attraction[0], rel=1e-5)
    assert "whole area touched" in " ".join(found.document.remarks)
    assert [panel.id for panel in found.document.figures] == ["attraction", "gap", "field"]
    assert [panel.id for panel in solved(voltage=0.0).document.figures] == ["gap"]


def test_the_field_in_the_film_is_that_of_plates_at_each_place():
    """V/(T + eps g) in a film of silica of 1 um on skin that conducts; where faces touch V/T, the step of its distribution."""
    strength, thickness, volt = 12e6, 1e-6, 20.0
    found = solved({"stack.insulator.breakdown_field": strength}, voltage=[0.0, -volt, volt])
    (film,) = found.films
    assert (film.name, film.strength) == ("insulator", strength)
    for at in (1, 2):
        gap = found.rests[at].gap
        field = volt / (thickness + 3.9 * gap)
        assert found.field(film, at) == pytest.approx(field, rel=1e-9)
        above = gap < (volt / strength - thickness) / 3.9
        assert found.area_beyond["insulator"][at] == np.mean(above) > found.contact_share[at]
    assert found.area_beyond["insulator"][0] == 0
    share = found.area_beyond["insulator"][1]
    assert (
        f"above its strength of 12 MV/m on {100 * share:.3g} % of the area, and 20 MV/m where faces touch"
        in str(found)
    )
    assert found.document.numbers[1].rows[1][-2:] == ("20 MV/m", f"{100 * share:.3g} %")
    half = np.median(found.field(film, 2))
    assert found.document.numbers[1].rows[2][1] == format_quantity(half, "V/m", digits=4)
    curve = found.document.figures[-1].curves[0]
    assert float(np.interp(strength, curve.x, curve.y)) == pytest.approx(
        share, abs=2e-3
    )  # 513 of 4096 places
    assert ",0.0,0.0" in found.content("rough_contact.csv")
    closed = next(each for each in found.diagnostics if each.name == "film strength, insulator, gap closed")
    assert closed.state == "warning"


def test_a_film_without_a_known_strength_has_no_share():
    assert (
        solved({"stack.insulator.material": {"model": "Constant", "permittivity": 9.0}}, voltage=20.0).films
        == ()
    )


def test_a_measured_surface_is_solved_with_its_mirror_images():
    """Longer than it is wide: the contact of the four images, and beside it every second point and fewer waves."""
    spectrum = ev.SelfAffine(**GIVEN)
    values = spectrum.heights((64, 96), (1e-3, 1.5e-3), seed=4)
    measured = ev.MeasuredHeights(values=values, spacing=1e-3 / 64)
    body = ev.Elastic(modulus=1e7)
    found = ev.rough_contact(PAPER, roughness=measured, body=body, voltage=[0.0, 20.0])
    pull = MaxwellStress(voltage=20.0, electrical_thickness=REACH)
    for roughness, step, seen in (
        (measured, 1, (found.contact_share[1], found.attraction[1])),
        (measured, 2, found.coarser[:, 1]),
        (measured.without_shortest_octave(), 2, found.smoother[:, 1]),
    ):
        heights = roughness.heights((128, 192), measured.periods, seed=0)[::step, ::step]
        loaded = Loaded(
            heights=heights, periods=(2e-3, 3e-3), compliance=body.compliance, pressure=LOAD / AREA
        )
        rest = loaded.rest(pull)
        assert seen == pytest.approx((rest.contact_share, rest.mean_attraction), rel=1e-3)
    assert found.rests[1].gap.shape == (128, 192)
    assert found.attraction[1] == pytest.approx(solved(voltage=20.0).attraction[0], rel=0.5)
    left, right, bottom, top = ev.plot.contact_map(found).get_images()[0].get_extent()
    assert (left, right, bottom, top) == pytest.approx((0, 3e-3, 0, 2e-3))
    with pytest.raises(InputError, match="points = 64: a measured surface has its own points"):
        ev.rough_contact(PAPER, roughness=measured, body=body, points=64)


def test_steep_roughness_is_a_doubt():
    assert "rms slope" not in str(solved(voltage=0.0))
    assert "slopes are taken as small" in str(solved(voltage=0.0, roughness={"rms": 5e-5}))


def test_a_grid_too_coarse_for_the_attraction_is_a_doubt():
    found = solved(voltage=60.0)
    assert found.rests[0].steepness > 1
    assert "the grid does not resolve the attraction" in str(found)
    assert "does not resolve" not in str(solved(voltage=20.0))


def test_the_table_in_a_file(found):
    text = found.content("rough_contact.csv")
    rows = list(
        csv.reader(io.StringIO("".join(f"{x}\n" for x in text.splitlines() if not x.startswith("#"))))
    )
    columns = dict(zip(rows[0], np.array(rows[1:], dtype=float).T, strict=True))
    for name in ("voltage", "contact_share", "mean_gap", "attraction", "plates", "force", "capacitance"):
        assert columns[name] == pytest.approx(getattr(found, name), rel=1e-9)
    assert columns["contact_share of a coarser grid"] == pytest.approx(found.coarser[0], rel=1e-9)
    assert columns["attraction of a smoother roughness"] == pytest.approx(found.smoother[1], rel=1e-9)
    assert columns["fell"].tolist() == found.fell.tolist()


def test_limits_are_judged_with_the_whole_area_touching_and_air_at_the_worst_gap():
    limits = {"limits.charge": 1e-9, "limits.stored_energy": 1e-6, "limits.voltage": 10.0}
    judged = {each.name: each for each in solved(limits, voltage=[-20.0, 5.0]).diagnostics}
    charge = eps0 * AREA * 20 / REACH
    assert judged["charge"].value == pytest.approx(charge, rel=1e-3)
    assert judged["stored energy"].value == pytest.approx(charge * 20 / 2, rel=1e-3)
    assert judged["field emission"].value == pytest.approx(20 / REACH, rel=1e-2)
    assert judged["voltage"].value == 20.0
    wide = solved(roughness={"rms": 1e-5}, body=ev.Elastic(modulus=1e9), voltage=20.0).diagnostics
    assert {each.name: each.state for each in wide}["Paschen"] == "ok"


def test_a_drive_of_current_is_taken_with_a_voltage():
    changes = {"drive": CURRENT | {"sense_resistance": 1e5}}
    assert solved(changes, voltage=20.0).voltage.tolist() == [20.0]
    with pytest.raises(InputError, match="voltage=100"):
        solved(changes)


def test_texts_with_units_are_read():
    texts = {"rms": "2 um", "hurst": "0.8", "longest": "1 mm", "roll_off": "250 um", "shortest": "125 um"}
    assert ev.SelfAffine(**texts).rms_slope((1e-3, 1e-3)) == pytest.approx(
        ev.SelfAffine(**GIVEN).rms_slope((1e-3, 1e-3)), rel=1e-12
    )
    assert ev.Elastic(modulus="1 MPa").modulus == 1e6
    body = ev.Elastic(modulus=1e6)
    assert ev.Coated(film=body, thickness="20 um", below=body).thickness == pytest.approx(2e-5, rel=1e-15)


@pytest.mark.parametrize(
    ("other", "said"),
    [
        ({"voltage": []}, r"voltage = \[\]: expected 1 to 64"),
        ({"voltage": np.arange(65.0)}, "expected 1 to 64"),
        ({"voltage": [[1.0, 2.0]]}, "in a row"),
        ({"voltage": np.nan}, r"voltage = \[nan\]"),
        ({"voltage": 1.1e6}, r"at most 1e\+06 V"),
        ({"frequency": -1.0}, "frequency = -1.0"),
        ({"frequency": np.inf}, "frequency = inf"),
        ({"points": 65}, "points = 65: an even number from 8 .* here 64, to 2048"),
        ({"points": 62}, "points = 62"),
        ({"points": 4096}, "points = 4096"),
        ({"seed": -1}, "seed = -1: Input should be greater than or equal to 0"),
        ({"body": 1e7}, "body = 10000000.0"),
        ({"roughness": {"shortest": 1e-9}}, "roughness.shortest = 1e-09: .* from 3.90625e-06 m"),
        ({"roughness": {"roll_off": 1e-3, "shortest": 6e-4}}, "at most half the longest"),
        ({"changes": {"load.normal_force": 0.0}}, "load.normal_force = 0"),
        ({"changes": {"stack.gap.material.conductivity": 1e-9}}, "stack.gap conducts"),
        ({"changes": {"circuit.return_path": {"model": "Floating", "capacitance": 1e-10}}}, "Grounded"),
    ],
)
def test_what_cannot_be_computed_is_refused(other, said):
    with pytest.raises(InputError, match=said):
        solved(**other)


@pytest.mark.parametrize("name", ["film", "below"])
def test_a_coat_is_of_two_elastic_bodies(name):
    body = ev.Elastic(modulus=1e6)
    with pytest.raises(ValueError, match=rf"{name}\n.*a table"):
        ev.Coated(**{"film": body, "thickness": 1e-5, "below": body} | {name: 100.0})
