"""Design of a plate: candidates against closed forms, the Pareto set against brute force, and what binds."""

import csv
import functools
import io
import itertools
import json
import math
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.exports.save import write_design
from electrovib.studies.design.plate.function import PERCEIVED
from electrovib.studies.design.plate.result import pareto_set
from electrovib.view.pages import drawn, html

PERMITTIVITY, GAP, AREA, STRENGTH = 3.0, 20e-6, 1e-4, 20e6
FORCE, FILM = "mean electrostatic_force", "film strength, insulator"
CLOSED = f"{FILM}, gap closed"
THICKNESS, VOLTS = "stack.insulator.thickness", "drive.amplitude"
MATERIAL = {"model": "Constant", "permittivity": PERMITTIVITY}
INSULATOR = {"thickness": "5 um", "material": MATERIAL, "breakdown_field": STRENGTH}
GROUNDED = {"circuit.return_path": {"model": "Grounded", "resistance": 0.0}}
STATIC = ev.load(
    "bau_2010/sine", changes={"stack": {"insulator": INSULATOR, "gap": {"thickness": GAP}}} | GROUNDED
)
"""Insulator and gap that do not conduct: everything is in phase with the voltage."""
THICKNESSES, AMPLITUDES = [2e-6, 5e-6, 1e-5, 2e-5], [100.0, 300.0, 500.0, 1000.0, 1500.0]
STRONG = STATIC.replace({"stack.insulator.breakdown_field": 1e9})
OVER = {THICKNESS: THICKNESSES, VOLTS: AMPLITUDES}
FAR = {"voltage": "1 MV"}
plate = functools.partial(ev.plan_plate, refine=0)


def volts(*values):
    return {VOLTS: [float(each) for each in values]}


def force(thickness, amplitude):
    """Mean over a period of eps0 A (v/(T/eps + g))^2/2."""
    return eps0 * AREA * (amplitude / (thickness / PERMITTIVITY + GAP)) ** 2 / 4


def field(thickness, amplitude):
    return amplitude / (thickness + PERMITTIVITY * GAP)


def breaks(thickness, amplitude):
    """Paschen: 112.5/(kPa cm) and 2737.5 V/(kPa cm) at 101.325 kPa, secondary emission 0.01."""
    product = 101325.0 * GAP
    breakdown = 273.75 * product / (math.log(11.25 * product) - math.log(math.log(101)))
    return PERMITTIVITY * GAP * field(thickness, amplitude) > breakdown


def at(candidate):
    return candidate.at[THICKNESS], candidate.at[VOLTS]


def row(candidate, quantity):
    return next(each for each in candidate.rows if each.quantity == quantity)


@pytest.fixture(scope="module")
def design():
    return plate(STATIC, OVER, limits={"voltage": "900 V", "current": "1 mA"})


def test_every_combination_is_a_candidate_with_its_closed_forms_margins_and_limits(design):
    every = list(itertools.product(THICKNESSES, AMPLITUDES))
    assert [at(each) for each in design.candidates] == every
    allowed = []
    for each, (thickness, amplitude) in zip(design.candidates, every, strict=True):
        assert each.values[FORCE] == pytest.approx(force(thickness, amplitude), rel=1e-9)
        assert each.values["peak voltage"] == amplitude
        film = row(each, FILM)
        assert film.value == pytest.approx(field(thickness, amplitude), rel=1e-5)
        assert film.margin == pytest.approx(STRENGTH / field(thickness, amplitude), rel=1e-5)
        assert row(each, "peak voltage").margin == pytest.approx(900 / amplitude, rel=1e-12)
        assert row(each, "charge").margin is None
        assert row(each, CLOSED).value == pytest.approx(amplitude / thickness, rel=1e-12)
        exceeded = {"peak voltage": amplitude > 900, FILM: film.value > STRENGTH}
        exceeded[CLOSED] = amplitude / thickness > STRENGTH
        exceeded["Paschen"] = breaks(thickness, amplitude)
        assert set(each.forbidden_by) == {name for name, is_exceeded in exceeded.items() if is_exceeded}
        assert each.is_allowed == (not any(exceeded.values()))
        allowed += [(thickness, amplitude)] if each.is_allowed else []
    found = {name for each in design.candidates for name in each.forbidden_by}
    assert found == {"peak voltage", FILM, CLOSED, "Paschen"}
    assert [at(each) for each in design.allowed] == allowed
    assert at(design.best) == max(allowed, key=lambda each: force(*each))
    assert design.check.state != "fail"
    assert design.check.value("peak voltage") == design.best.values["peak voltage"]
    assert not design.best.doubts
    assert "film strength" not in " ".join(each for each in design.document.sentences if "Not shown" in each)


def test_current_and_energy_of_a_candidate():
    capacitance = eps0 * AREA / (5e-6 / PERMITTIVITY + GAP)
    one = next(each for each in plate(STATIC, volts(300)).candidates)
    assert row(one, "peak current").value == pytest.approx(2 * math.pi * 125 * 300 * capacitance, rel=1e-4)
    assert row(one, "stored energy").value == pytest.approx(capacitance * 300**2 / 2, rel=1e-4)


CHECKED = {
    "a step with a series resistance": {
        "drive.phase": math.pi / 2, "time": {"duration": "20 ms"}, "circuit.source_resistance": "1 Mohm",
    },
    "a discontinuity": {"drive.phase": math.pi / 2, "time": {"duration": "20 ms"}},
    "stray capacitance": {"circuit.amplifier": {"stray_capacitance": "100 pF"}},
}  # fmt: skip
EVERY = {"voltage": 90.0, "current": 1e-4, "charge": 1e-9, "stored_energy": 1e-6, "body_current": 1e-4}
EVERY |= {"rms_voltage": 71.0, "rms_current": 1e-4, "slew_rate": 1e4}


@pytest.mark.parametrize("case", CHECKED)
def test_rows_of_a_candidate_are_those_of_the_check(case):
    scenario = STATIC.replace(CHECKED[case])
    found, expected = plate(scenario, volts(100), limits=EVERY), ev.check(None, scenario, limits=EVERY)
    for mine, theirs in zip(found.candidates[0].rows, expected.rows, strict=True):
        assert (mine.quantity, mine.limit, mine.state) == (theirs.quantity, theirs.limit, theirs.state)
        assert mine.value == (theirs.value and pytest.approx(theirs.value, rel=1e-5))


@pytest.mark.parametrize(
    ("amplifier", "binds"),
    [
        ({"source_current": 4e-6}, "asked peak current"),
        ({"gain": 2.0, "saturation": 250.0}, "asked peak voltage"),
    ],
    ids=["current", "saturation"],
)
def test_an_amplifier_bounds_a_plate_by_what_the_drive_asks_of_it(amplifier, binds):
    """2 pi f C V of 100 V is within 4 uA, that of 150 V is not; twice 100 V is within 250 V."""
    limited = STRONG.replace({"circuit.amplifier": amplifier, "time": {"duration": "16 ms"}})
    found = plate(limited, volts(30, 100, 150))
    assert [each.forbidden_by for each in found.candidates] == [(), (), (binds,)]
    assert found.best.at[VOLTS] == 100
    assert found.gains[0].limits == (binds,)
    asked = row(
        found.best, "asked peak current" if "source_current" in amplifier else "asked peak voltage"
    ).value
    capacitance = eps0 * AREA / (5e-6 / PERMITTIVITY + GAP)
    expected = 2 * math.pi * 125 * 100 * capacitance if "source_current" in amplifier else 200
    assert asked == pytest.approx(expected, rel=1e-4)


def test_the_strictest_limit_counts_and_root_mean_squares_are_judged_where_declared_or_an_objective():
    plain = plate(STATIC, volts(50)).candidates[0]
    assert not [each for each in plain.rows if "rms" in each.quantity or "slew" in each.quantity]
    found = plate(STATIC, volts(50, 100), limits={"rms_voltage": 50.0}, minimise=["slew rate"])
    assert [each.forbidden_by for each in found.candidates] == [(), ("rms voltage",)]
    assert found.best.values["slew rate"] == pytest.approx(2 * math.pi * 125 * 50)
    own = STATIC.replace({"limits.voltage": "250 V"})
    found = plate(own, volts(100, 200, 300), limits=[{"voltage": 150.0}])
    assert found.best.at[VOLTS] == 100
    assert "250 V of the scenario" in row(found.best, "peak voltage").source


def test_the_force_at_the_breakdown_field_is_independent_of_the_thickness():
    """With the gap closed E = V/T, so the force eps0 A (E T/(T/eps + g))^2/4 is largest at the thickest film."""
    held = STATIC.replace({"stack.insulator.breakdown_field": 10e6, "stack.gap.thickness": "1 nm"})
    found = plate(held, {THICKNESS: [2e-6, 5e-6, 2e-5]} | volts(20, 60, 200), refine=6)
    most = eps0 * AREA * (10e6 * 2e-5 / (2e-5 / PERMITTIVITY + 1e-9)) ** 2 / 4
    assert 0.99 * most < found.best.values[FORCE] <= most * (1 + 1e-9)
    assert at(found.best)[1] <= 10e6 * at(found.best)[0] * (1 + 1e-9)
    assert any(each.refined for each in found.candidates)
    assert len({at(each) for each in found.candidates}) == len(found.candidates), "each only once"


def test_what_binds_is_the_limit_without_which_more_is_reached(design):
    first = design.gains[0]
    without = [each for each in design.candidates if set(each.forbidden_by) <= {first.limits[0]}]
    most = max(each.values[FORCE] for each in without)
    assert first.without.values[FORCE] == most > design.best.values[FORCE]
    assert f"{first.limits[0][0].upper()}{first.limits[0][1:]} binds" in " ".join(design.document.sentences)
    assert any(
        words in " ".join(design.document.sentences)
        for words in ("relaxed by 10 %", "relaxing this limit by 10 %")
    )


def test_limits_that_bind_only_together_are_named_together_and_the_largest_gain_first():
    """Twice the voltage exceeds the limits of voltage and of charge at once, so relaxing one alone gains nothing."""
    found = plate(STRONG, volts(100, 200), limits={"voltage": 150.0, "charge": "6 nC"})
    assert found.best.at[VOLTS] == 100
    assert {gain.limits for gain in found.gains} == {("peak voltage", "charge")}
    assert "Peak voltage and charge bind together" in " ".join(found.document.sentences)
    over = {"contact.area": [0.5e-4, 1.5e-4]} | volts(200, 300)  # 200 V on 1.5 cm2 have more force
    found = plate(STRONG, over, limits={"voltage": 250.0, "charge": 8e-9})
    assert [each.forbidden_by for each in found.candidates[:3]] == [(), ("peak voltage",), ("charge",)]
    assert [gain.limits for gain in found.gains] == [("charge",), ("peak voltage",)]
    assert " ".join(found.document.sentences).count("Charge binds") == 1


def test_without_a_binding_limit_the_ranges_decide_and_limits_that_are_not_declared_are_named():
    found = plate(STRONG, volts(100, 200), limits=FAR)
    assert "No limit binds: drive.amplitude has the largest of its values" in " ".join(
        found.document.sentences
    )
    inside = plate(STATIC, volts(100, 200), maximise=[], minimise=[VOLTS], limits=FAR)
    assert inside.best.at[VOLTS] == 100
    undeclared = (
        "Not shown to be safe: the voltage of the plate reaches 200 V; limits.voltage is not declared"
    )
    found = plate("bau_2010/sine", volts(100, 200), materials=["silica", "parylene C"])
    first, *rest = " ".join(found.document.sentences).split(". ")
    assert "at an end of the ranges: " in first
    assert [each for each in rest if each.startswith(undeclared)]
    peak = row(found.best, "peak voltage")
    assert (peak.limit, peak.state, peak.value) == (None, "unknown", 200)
    both = " ".join(plate("bau_2010/sine", volts(1, 2) | {THICKNESS: [1e-6, 2e-6]}).document.sentences)
    assert f"at a corner of the ranges: {THICKNESS} = 1 um" in both.replace("drive.amplitude = 2 V, ", "")
    within = plate(STATIC, volts(100, 200), limits={"voltage": 150.0, "current": 1.0})
    assert "end of the ranges" not in " ".join(within.document.sentences)
    assert "not declared" not in " ".join(within.document.sentences)


def test_the_closest_limit_is_that_with_the_smallest_ratio_in_the_table():
    """In a gap of 3 um field emission at 75 MV/m is nearer than the strength of the film, although it decides nothing."""
    found = plate("bau_2010/sine", volts(100, 200), set={"limits.voltage": "1 kV"})
    rows = next(table for table in found.document.tables if table.title.startswith("Limits at")).rows
    ratios = {each[1]: float(each[4]) for each in rows if each[4]}
    least = min(ratios, key=ratios.get)
    assert least == "field emission"
    assert ratios[least] < 2 < ratios[FILM]
    assert f"Closest limit: field emission, {ratios[least]:.3g} (of uncertain standing) (59" in " ".join(
        found.document.sentences
    )
    pareto = next(table for table in found.document.tables if table.title.startswith("Pareto"))
    column = pareto.headings.index("closest limit")
    assert all(row[column].startswith("field emission, ") for row in pareto.rows)


def test_nothing_within_the_limits_names_the_limit_and_the_nearest_candidate():
    found = plate(STATIC, volts(100, 200), limits={"voltage": 50.0})
    assert (found.best, found.check, found.scenario, found.is_achieved) == (None, None, None, False)
    assert not found.pareto
    assert "None of the 2 candidates is within the limits; peak voltage forbids 2 of them" in " ".join(
        found.document.sentences
    )
    assert "drive.amplitude = 100 V: peak voltage 100 V (limit 50 V)" in " ".join(found.document.sentences)


def brute(costs):
    return [
        not any(np.isnan(mine)) and not any(np.all(other <= mine) and np.any(other < mine) for other in costs)
        for mine in costs
    ]


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("kind", ["real", "ties", "nan"])
def test_pareto_set_of_random_points_is_that_of_brute_force(objectives, kind):
    costs = np.random.default_rng(objectives).normal(size=(150, objectives))
    costs = np.round(costs) if kind == "ties" else costs
    costs[::7, 0] = np.nan if kind == "nan" else costs[::7, 0]
    np.testing.assert_array_equal(pareto_set(costs), brute(costs))


@pytest.mark.parametrize("minimise", ["peak voltage", "peak current", "stored energy", "charge", THICKNESS])
def test_pareto_set_against_any_objective_is_that_of_brute_force(minimise):
    found = plate(STATIC, OVER, minimise=[minimise], limits={"voltage": "1 kV"})
    costs = np.array([[-each.values[FORCE], each.values[minimise]] for each in found.allowed])
    expected = [each for each, kept in zip(found.allowed, brute(costs), strict=True) if kept]
    assert {id(each) for each in found.pareto} == {id(each) for each in expected}
    forces = [each.values[FORCE] for each in found.pareto]
    assert forces == sorted(forces, reverse=True)


def test_materials_take_their_own_strength_and_field_emission_forbids_nothing():
    found = plate(STATIC, volts(100, 200), materials=["silica", "parylene C", "PTFE"], limits=FAR)
    assert [each.material for each in found.candidates[::2]] == ["silica", "parylene_c", "ptfe"]
    by = {each.material: each for each in found.candidates}
    assert row(by["silica"], FILM).limit == pytest.approx(660e6)
    assert "a thickness that its source does not state" in by["silica"].doubts[0]
    assert by["parylene_c"].doubts
    own = "stack.insulator.breakdown_field belongs to the material of the scenario"
    assert any(own in note for note in found.notes)
    assert "Not shown to be safe: the field in 'insulator', with the gap closed" in " ".join(
        found.document.sentences
    )
    thin = STATIC.replace({THICKNESS: "100 nm", "stack.gap.thickness": "1 nm"})
    film = row(plate(thin, volts(1, 100), materials=["parylene C"]).candidates[1], FILM)
    assert film.value > film.limit
    assert (film.state, film.forbids) == ("unknown", True), "an unverified strength forbids too"
    assert "unverified" in film.text
    thin = STATIC.replace({"stack.gap.thickness": "1 um", "stack.insulator.breakdown_field": 1e9})
    found = plate(thin, volts(300), limits=FAR)
    emission = row(found.candidates[0], "field emission")
    assert emission.value > emission.limit
    assert emission.state == "unknown"
    assert found.best is not None


def test_notes_on_a_named_material_and_on_perception_without_a_threshold():
    named = STATIC.replace({"stack.insulator.material": "silica", "stack.insulator.breakdown_field": None})
    path = "stack.insulator.material.permittivity"
    found = plate(named, {path: [3.9, 8.0]}, limits=FAR)
    assert any("remains that of silica" in note for note in found.notes)
    for each in found.candidates:
        expected = eps0 * AREA * (100 / (5e-6 / each.at[path] + GAP)) ** 2 / 4
        assert each.values[FORCE] == pytest.approx(expected, rel=1e-9)
    found = plate(STATIC.replace({"perception": {}}), volts(100))
    assert not [each for each in found.candidates[0].rows if each.quantity == PERCEIVED]
    best = ev.perceive(STATIC, set={VOLTS: 100.0})
    assert best.verdict == "detectable"
    (note,) = [note for note in found.notes if note.startswith("The best plate: ") and "felt" in note]
    assert note == f"The best plate: {best.headline}. {best.to_measure}. This forbids no candidate."


def with_perception(threshold):
    skin = {"model": "ElasticViscousSkin", "stiffness": 1e3, "corner": 1e4}
    known = {"threshold": threshold, "threshold_uncertainty": 3.0, "compliance": skin}
    return STATIC.replace({"perception": known})


def test_a_change_of_friction_below_the_threshold_forbids():
    felt = 1e-9 * 10 ** (ev.perceive(with_perception(1e-9)).sensation / 20)
    found = plate(with_perception(10 * felt), volts(100, 200, 1000), limits=FAR)
    rows = [row(each, PERCEIVED) for each in found.candidates]
    assert [each.state for each in rows] == ["fail", "fail", "pass"]  # -20 dB, -8 dB, +20 dB, within 3 dB
    assert rows[0].value == pytest.approx(10, rel=1e-2)
    assert "detection threshold" in rows[0].text
    near = plate(with_perception(1.1 * felt), volts(100), limits=FAR)
    assert row(near.candidates[0], PERCEIVED).state == "unknown"


WRONG = {
    "nothing varied": ({"over": {}}, "over: name at least one parameter that is varied"),
    "unknown path": ({"over": {"drive.amplitud": [1.0]}}, "drive.amplitud"),
    "value": ({"over": {VOLTS: ["100 m"]}}, VOLTS),
    "text range": ({"over": ["drive.amplitude=1V"]}, "expected PATH=FROM:TO:N"),
    "objective": (
        {"maximise": ["mean electrostatic_farce"]},
        "maximise: quantity 'mean electrostatic_farce'",
    ),
    "not varied": ({"minimise": ["stack.gap.thickness"]}, "minimise: 'stack.gap.thickness' is not varied"),
    "twice": ({"minimise": [FORCE]}, "is an objective already"),
    "no objective": ({"maximise": [], "minimise": []}, "name at least one objective"),
    "unknown material": ({"materials": ["silicate"]}, "silicate"),
    "material twice": ({"materials": ["silica", "SiO2"]}, "named twice"),
    "unknown layer": ({"materials": ["silica"], "layer": "insulater"}, "layer 'insulater'"),
    "layer alone": ({"layer": "insulator"}, "layer: names the layer whose material is varied"),
    "too many rounds": ({"refine": 21}, "refine = 21"),
    "four at once": (
        {"limits": {"voltage": 0.0}, "materials": ["silicate"], "maximise": ["x"], "refine": -1},
        "(?s)limits.voltage",
    ),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_mistakes_are_refused(wrong):
    options, words = WRONG[wrong]
    with pytest.raises(InputError, match=words) as caught:
        plate(STATIC, **{"over": OVER} | options)
    assert len(caught.value.problems) >= len(options) or wrong != "four at once"


def test_table_page_and_figure_have_every_candidate_with_every_limit(design):
    text, page = design.content("candidates.csv"), html(design.document)
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(io.StringIO("\n".join(lines))))
    for cells, each in zip(rows, design.candidates, strict=True):
        assert float(cells["drive.amplitude [V]"]) == each.at[VOLTS]
        assert float(cells[f"{FORCE} [N]"]) == each.values[FORCE]
        assert float(cells[f"{FILM}: limit/value"]) == row(each, FILM).margin
        assert cells["forbidden by"] == "; ".join(each.forbidden_by)
        assert (cells["within the limits"] == "yes") == each.is_allowed
        assert (cells["best"] == "yes") == (each is design.best)
    assert sum(cells["Pareto set"] == "yes" for cells in rows) == len(design.pareto)
    assert " ".join(design.document.sentences) in text
    for words in ("within all limits is", "<svg", "Pareto set"):
        assert words in page
    (axes,) = drawn(design.document.figures[0]).axes
    points = [line for line in axes.lines if line.get_linestyle() == "None" and line.get_marker() != "*"]
    assert sum(len(line.get_xdata()) for line in points) == len(design.candidates)
    assert len(axes.get_legend().get_texts()) <= 5
    assert axes.get_xlabel() == "peak voltage [kV]"
    assert re.fullmatch(r"mean electrostatic force \[(m|µ)?N\]", axes.get_ylabel())
    (front,) = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert list(front.get_xdata()) == sorted(each.values["peak voltage"] for each in design.pareto)


def test_the_plate_is_a_result_like_that_of_every_design(design, tmp_path):
    assert design.is_achieved
    assert (design.scenario.drive.amplitude, design.base.drive.amplitude) == (design.best.at[VOLTS], 100)
    assert design.document.remarks == design.notes
    write_design(design, tmp_path / "plate.json")
    table = json.loads((tmp_path / "plate.json").read_text(encoding="utf-8"))
    assert table["form"] == "plate"
    assert [each["at"] for each in table["candidates"] if each["is_best"]] == [design.best.at]
    assert sum(each["is_efficient"] for each in table["candidates"]) == len(design.pareto)
    write_design(design, tmp_path / "plate.toml")
    assert ev.load(tmp_path / "plate.toml").drive.amplitude == design.best.at[VOLTS]


@pytest.mark.parametrize(
    ("values", "added"), [([1e-6, 4e-6, 16e-6], 2e-6), ([1e-6, 4e-6, 7e-6], 2.5e-6), ([1e-6, 4e-6], 2.5e-6)]
)
def test_candidates_are_added_between_values_as_these_are_spaced(values, added):
    found = plate(STRONG, {THICKNESS: values}, limits=FAR, refine=1)
    assert found.best.at[THICKNESS] == 1e-6
    assert [each.at[THICKNESS] for each in found.candidates if each.refined] == [pytest.approx(added)]
