"""Design of a plate: candidates against closed forms, the Pareto set against brute force, and what binds."""

from __future__ import annotations

import csv
import functools
import io
import itertools
import json
import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.export.design import write_design
from electrovib.study.design.plate import pareto_set
from electrovib.study.design.plate.candidates import PERCEIVED
from electrovib.view.plate import as_csv, as_html, figure_of

PERMITTIVITY, GAP, AREA, STRENGTH = 3.0, 20e-6, 1e-4, 20e6
CHANGES = {
    "stack": {
        "insulator": {
            "thickness": "5 um",
            "material": {"model": "Constant", "permittivity": PERMITTIVITY},
            "breakdown_field": STRENGTH,
        },
        "gap": {"thickness": GAP},
    },
    "circuit.return_path": {"model": "Grounded", "resistance": 0.0},
}
STATIC = ev.load("bau_2010/sine", changes=CHANGES)
"""Insulator and gap that do not conduct: everything is in phase with the voltage."""
THICKNESSES = [2e-6, 5e-6, 1e-5, 2e-5]
AMPLITUDES = [100.0, 300.0, 500.0, 1000.0, 1500.0]
OVER = {"stack.insulator.thickness": THICKNESSES, "drive.amplitude": AMPLITUDES}
plate = functools.partial(ev.design_plate, refine=0)
FAR = {"voltage": "1 MV"}


def force(thickness, amplitude):
    """Mean over a period of eps0 A (v/(T/eps + g))^2/2."""
    return eps0 * AREA * (amplitude / (thickness / PERMITTIVITY + GAP)) ** 2 / 4


def field(thickness, amplitude):
    return amplitude / (thickness + PERMITTIVITY * GAP)


def paschen(gap):
    """112.5/(kPa cm) and 2737.5 V/(kPa cm) at 101.325 kPa, secondary emission 0.01."""
    product = 101325.0 * gap
    return 273.75 * product / (math.log(11.25 * product) - math.log(math.log(101)))


def breaks(thickness, amplitude):
    gap_voltage = amplitude * PERMITTIVITY * GAP / (thickness + PERMITTIVITY * GAP)
    return gap_voltage > paschen(GAP)


def at(candidate):
    return candidate.at["stack.insulator.thickness"], candidate.at["drive.amplitude"]


def row(candidate, quantity):
    return next(each for each in candidate.rows if each.quantity == quantity)


@pytest.fixture(scope="module")
def design():
    return plate(STATIC, OVER, limits={"voltage": "900 V", "current": "1 mA"})


def test_every_combination_is_a_candidate_with_its_closed_form(design):
    assert [at(each) for each in design.candidates] == list(itertools.product(THICKNESSES, AMPLITUDES))
    for each in design.candidates:
        assert each.values["mean electrostatic_force"] == pytest.approx(force(*at(each)), rel=1e-9)
        assert row(each, "film strength, insulator").value == pytest.approx(field(*at(each)), rel=1e-5)
        assert each.values["peak voltage"] == at(each)[1]


def test_a_candidate_is_forbidden_by_exactly_the_limits_that_it_exceeds(design):
    for each in design.candidates:
        expected = set()
        if at(each)[1] > 900:
            expected.add("peak voltage")
        if field(*at(each)) > STRENGTH:
            expected.add("film strength, insulator")
        if breaks(*at(each)):
            expected.add("Paschen")
        assert set(each.forbidden_by) == expected
        assert each.is_allowed == (not expected)
    found = {name for each in design.candidates for name in each.forbidden_by}
    assert found == {"peak voltage", "film strength, insulator", "Paschen"}


def test_margins_are_limit_over_value(design):
    for each in design.candidates:
        assert row(each, "peak voltage").margin == pytest.approx(900 / at(each)[1], rel=1e-12)
        assert row(each, "film strength, insulator").margin == pytest.approx(
            STRENGTH / field(*at(each)), rel=1e-5
        )
        assert row(each, "charge").margin is None


def test_current_and_energy_of_a_candidate(design):
    capacitance = eps0 * AREA / (5e-6 / PERMITTIVITY + GAP)
    one = next(each for each in design.candidates if at(each) == (5e-6, 300.0))
    assert row(one, "peak current").value == pytest.approx(2 * math.pi * 125 * 300 * capacitance, rel=1e-4)
    assert row(one, "stored energy").value == pytest.approx(capacitance * 300**2 / 2, rel=1e-4)


def test_the_best_is_the_largest_force_among_the_allowed(design):
    allowed = [
        each
        for each in itertools.product(THICKNESSES, AMPLITUDES)
        if each[1] <= 900 and field(*each) <= STRENGTH and not breaks(*each)
    ]
    assert at(design.best) == max(allowed, key=lambda each: force(*each))
    assert len(design.allowed) == len(allowed)


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
    found = plate(scenario, {"drive.amplitude": [100.0]}, limits=EVERY).candidates[0]
    expected = ev.check(None, scenario, limits=EVERY)
    assert len(found.rows) == len(expected.rows)
    for mine, theirs in zip(found.rows, expected.rows, strict=True):
        assert (mine.quantity, mine.limit, mine.state) == (theirs.quantity, theirs.limit, theirs.state)
        assert mine.value == (theirs.value and pytest.approx(theirs.value, rel=1e-5))


def test_root_mean_squares_are_judged_where_they_are_declared_or_an_objective():
    over = {"drive.amplitude": [50.0, 100.0]}
    plain = plate(STATIC, over).candidates[0]
    assert not [each for each in plain.rows if "rms" in each.quantity or "slew" in each.quantity]
    found = plate(STATIC, over, limits={"rms_voltage": 50.0}, minimise=["slew rate"])
    assert [each.forbidden_by for each in found.candidates] == [(), ("rms voltage",)]
    assert found.best.values["slew rate"] == pytest.approx(2 * math.pi * 125 * 50)


def test_the_best_candidate_is_checked_again(design):
    assert design.check.state != "fail"
    assert design.check.value("peak voltage") == design.best.values["peak voltage"]


def test_the_force_at_the_breakdown_field_is_independent_of_the_thickness():
    """At E = V/(T + eps g) the force is eps0 A (eps E)^2/4: the optimum is a line, which refinement approaches."""
    held = STATIC.replace({"stack.insulator.breakdown_field": 3e6})  # below Paschen in this gap
    found = plate(
        held,
        {"stack.insulator.thickness": [2e-6, 5e-6, 2e-5], "drive.amplitude": [50.0, 150.0, 400.0]},
        refine=6,
    )
    most = eps0 * AREA * (PERMITTIVITY * 3e6) ** 2 / 4
    assert 0.99 * most < found.best.values["mean electrostatic_force"] <= most * (1 + 1e-9)
    gain = found.gains[0]
    assert gain.limits == ("film strength, insulator",)
    relaxed = gain.relaxed.values["mean electrostatic_force"]
    assert 0.97 * 1.21 * most < relaxed <= 1.21 * most * (1 + 1e-9)
    assert any(each.refined for each in found.candidates)
    assert len({tuple(each.at.values()) for each in found.candidates}) == len(found.candidates), (
        "each only once"
    )


def test_thickness_at_which_current_and_voltage_limit_together():
    """The current of the capacitance falls with the thickness, the voltage limit is flat: thin plates take less voltage."""
    limit = 20e-6
    found = plate(
        STATIC,
        {
            "stack.insulator.thickness": np.linspace(1e-6, 40e-6, 14),
            "drive.amplitude": np.linspace(20, 300, 15),
        },
        limits={"voltage": 300.0, "current": limit},
    )
    for each in found.candidates:
        thickness, amplitude = at(each)
        current = 2 * math.pi * 125 * amplitude * eps0 * AREA / (thickness / PERMITTIVITY + GAP)
        if abs(current / limit - 1) > 1e-4:
            assert ("peak current" in each.forbidden_by) == (current > limit)


def test_what_binds_is_the_limit_without_which_more_is_reached(design):
    first = design.gains[0]
    without = [each for each in design.candidates if set(each.forbidden_by) <= {first.limits[0]}]
    most = max(each.values["mean electrostatic_force"] for each in without)
    assert (
        first.without.values["mean electrostatic_force"]
        == most
        > design.best.values["mean electrostatic_force"]
    )
    assert f"{first.limits[0][0].upper()}{first.limits[0][1:]} binds" in design.answer
    assert "relaxed by 10 %" in design.answer or "relaxing this limit by 10 %" in design.answer


def test_limits_that_bind_only_together_are_named_together():
    """Twice the voltage exceeds the limits of voltage and of charge at once, so relaxing one alone gains nothing."""
    found = plate(STATIC, {"drive.amplitude": [100.0, 200.0]}, limits={"voltage": 150.0, "charge": "6 nC"})
    assert at_amplitude(found.best) == 100
    assert {gain.limits for gain in found.gains} == {("peak voltage", "charge")}
    assert "Peak voltage and charge bind together" in found.answer


def at_amplitude(candidate):
    return candidate.at["drive.amplitude"]


def test_without_a_binding_limit_the_ranges_decide():
    found = plate(STATIC, {"drive.amplitude": [100.0, 200.0]}, limits=FAR)
    assert "No limit binds: drive.amplitude has the largest of its values" in found.answer
    inside = plate(
        STATIC,
        {"drive.amplitude": [100.0, 200.0, 300.0]},
        maximise=[],
        minimise=["drive.amplitude"],
        limits=FAR,
    )
    assert at_amplitude(inside.best) == 100


def test_without_limits_the_answer_is_called_a_corner_of_the_ranges():
    found = plate("bau_2010/sine", {"drive.amplitude": [100.0, 200.0]}, materials=["silica", "parylene C"])
    first, *rest = found.answer.split(". ")
    both = plate("bau_2010/sine", {"drive.amplitude": [1.0, 2.0], "stack.insulator.thickness": [1e-6, 2e-6]})
    assert "at a corner of the ranges: stack.insulator.thickness = 1 um" in both.answer.replace(
        "drive.amplitude = 2 V, ", ""
    )
    assert "at an end of the ranges: " in first
    assert "limits.voltage and limits.current are not declared, so they were not compared" in rest
    within = plate(STATIC, {"drive.amplitude": [100.0, 200.0]}, limits={"voltage": 150.0, "current": 1.0})
    assert "end of the ranges" not in within.answer
    assert "not declared" not in within.answer


def test_the_closest_limit_is_that_with_the_smallest_ratio_in_the_table():
    """In a gap of 3 um field emission at 75 MV/m is nearer than the strength of the film, although it decides nothing."""
    found = plate("bau_2010/sine", {"drive.amplitude": [100.0, 200.0]}, set={"limits.voltage": "1 kV"})
    rows = next(table for table in found.tables if table.title.startswith("Limits at")).rows
    ratios = {each[1]: float(each[4]) for each in rows if each[4]}
    least = min(ratios, key=ratios.get)
    assert least == "field emission"
    assert ratios[least] < 2 < ratios["film strength, insulator"]
    assert f"Closest limit: field emission, {ratios[least]:.3g} (not judged) (59" in found.answer
    pareto = next(table for table in found.tables if table.title.startswith("Pareto"))
    column = pareto.headings.index("closest limit")
    assert all(row[column].startswith("field emission, ") for row in pareto.rows)


def test_nothing_within_the_limits_names_the_limit_and_the_nearest_candidate():
    found = plate(STATIC, {"drive.amplitude": [100.0, 200.0]}, limits={"voltage": 50.0})
    assert found.best is None
    assert found.check is None
    assert not found.pareto
    assert "None of the 2 candidates is within the limits; peak voltage forbids 2 of them" in found.answer
    assert "drive.amplitude = 100 V: peak voltage 100 V (limit 50 V)" in found.answer


def brute(costs):
    return [
        not any(np.isnan(mine)) and not any(np.all(other <= mine) and np.any(other < mine) for other in costs)
        for mine in costs
    ]


@pytest.mark.parametrize("objectives", [1, 2, 3])
@pytest.mark.parametrize("kind", ["real", "ties", "nan"])
def test_pareto_set_of_random_points_is_that_of_brute_force(objectives, kind):
    random = np.random.default_rng(objectives)
    costs = random.normal(size=(150, objectives))
    if kind == "ties":
        costs = np.round(costs)
    if kind == "nan":
        costs[::7, 0] = np.nan
    np.testing.assert_array_equal(pareto_set(costs), brute(costs))


def test_pareto_set_of_force_and_voltage_is_the_thinnest_allowed_plate_of_each_voltage(design):
    expected = set()
    for amplitude in AMPLITUDES:
        allowed = [t for t in THICKNESSES if (t, amplitude) in {at(each) for each in design.allowed}]
        if allowed:
            expected.add((min(allowed), amplitude))
    # a thinner plate at a lower voltage may have more force than the thinnest allowed one at a higher voltage
    kept = {
        one
        for one in expected
        if not any(other[1] < one[1] and force(*other) >= force(*one) for other in expected)
    }
    assert {at(each) for each in design.pareto} == kept
    forces = [each.values["mean electrostatic_force"] for each in design.pareto]
    assert forces == sorted(forces, reverse=True)


@pytest.mark.parametrize(
    "minimise", ["peak current", "stored energy", "charge", "peak body current", "stack.insulator.thickness"]
)
def test_pareto_set_against_any_objective_is_that_of_brute_force(minimise):
    found = plate(STATIC, OVER, minimise=[minimise], limits={"voltage": "1 kV"})
    costs = np.array(
        [[-each.values["mean electrostatic_force"], each.values[minimise]] for each in found.allowed]
    )
    expected = [each for each, kept in zip(found.allowed, brute(costs), strict=True) if kept]
    assert {id(each) for each in found.pareto} == {id(each) for each in expected}


def test_undeclared_limits_forbid_nothing_and_are_named():
    found = plate(STATIC, {"drive.amplitude": [100.0]})
    rows = {each.quantity: each for each in found.best.rows}
    assert rows["peak voltage"].limit is None
    assert rows["peak voltage"].state == "unknown"
    assert rows["peak voltage"].value == 100
    assert "limits.voltage and limits.current are not declared" in found.answer


def test_the_strictest_of_several_limits_counts():
    own = STATIC.replace({"limits.voltage": "250 V"})
    found = plate(own, {"drive.amplitude": [100.0, 200.0, 300.0]}, limits=[{"voltage": 150.0}])
    assert at_amplitude(found.best) == 100
    assert "250 V of the scenario" in row(found.best, "peak voltage").source


def test_materials_take_their_own_strength_and_its_status():
    found = plate(
        STATIC, {"drive.amplitude": [100.0, 200.0]}, materials=["silica", "parylene C", "PTFE"], limits=FAR
    )
    assert [each.material for each in found.candidates[::2]] == ["silica", "parylene_c", "ptfe"]
    by = {each.material: each for each in found.candidates}
    assert row(by["silica"], "film strength, insulator").limit == pytest.approx(660e6)
    assert "a thickness that its source does not state" in by["silica"].doubts[0]
    assert by["parylene_c"].doubts
    assert any(
        "stack.insulator.breakdown_field belongs to the material of the scenario" in note
        for note in found.notes
    )
    assert "This rests on a breakdown strength that is unverified or may not apply here" in found.answer


def test_a_field_above_an_unverified_strength_forbids_and_the_row_says_unverified():
    thin = STATIC.replace({"stack.insulator.thickness": "100 nm", "stack.gap.thickness": "1 nm"})
    found = plate(thin, {"drive.amplitude": [1.0, 100.0]}, materials=["parylene C"])
    film = row(found.candidates[1], "film strength, insulator")
    assert film.value > film.limit
    assert film.state == "fail"
    assert "unverified" in film.text


def test_a_declared_strength_leaves_no_doubt(design):
    assert not design.best.doubts
    assert "rests on" not in design.answer


def test_field_emission_is_shown_and_forbids_nothing():
    found = plate(
        STATIC.replace({"stack.gap.thickness": "1 um", "stack.insulator.breakdown_field": 1e9}),
        {"drive.amplitude": [300.0]},
        limits=FAR,
    )
    emission = row(found.candidates[0], "field emission")
    assert emission.value > emission.limit
    assert emission.state == "unknown"
    assert found.best is not None


def test_varied_permittivity_with_a_named_material_is_noted():
    named = STATIC.replace({"stack.insulator.material": "silica", "stack.insulator.breakdown_field": None})
    found = plate(named, {"stack.insulator.material.permittivity": [3.9, 8.0]}, limits=FAR)
    assert any("remains that of silica" in note for note in found.notes)
    thickness = 5e-6
    for each in found.candidates:
        permittivity = each.at["stack.insulator.material.permittivity"]
        expected = eps0 * AREA * (100 / (thickness / permittivity + GAP)) ** 2 / 4
        assert each.values["mean electrostatic_force"] == pytest.approx(expected, rel=1e-9)


def with_perception(threshold, uncertainty=3.0):
    return STATIC.replace(
        {
            "perception": {
                "threshold": threshold,
                "threshold_uncertainty": uncertainty,
                "compliance": {"model": "ElasticViscousSkin", "stiffness": 1e3, "corner": 1e4},
            }
        }
    )


def test_a_change_of_friction_below_the_threshold_forbids():
    level = ev.perceive(with_perception(1e-9)).sensation
    felt = 1e-9 * 10 ** (level / 20)
    found = plate(with_perception(10 * felt), {"drive.amplitude": [100.0, 200.0, 1000.0]}, limits=FAR)
    states = [row(each, PERCEIVED).state for each in found.candidates]
    assert states == ["fail", "fail", "pass"]  # -20 dB, -8 dB, +20 dB with 3 dB of uncertainty
    assert row(found.candidates[0], PERCEIVED).value == pytest.approx(10, rel=1e-2)
    assert "detection threshold" in row(found.candidates[0], PERCEIVED).text
    near = plate(with_perception(1.1 * felt), {"drive.amplitude": [100.0]}, limits=FAR)
    assert row(near.candidates[0], PERCEIVED).state == "unknown"


def test_perception_without_a_threshold_forbids_nothing_and_is_answered_from_publications():
    found = plate(STATIC.replace({"perception": {}}), {"drive.amplitude": [100.0]})
    assert not [each for each in found.candidates[0].rows if each.quantity == PERCEIVED]
    best = ev.perceive(STATIC, set={"drive.amplitude": 100.0})
    assert best.verdict == "detectable"
    (note,) = [note for note in found.notes if note.startswith("The best plate: ") and "felt" in note]
    assert note == f"The best plate: {best.answer}. {best.to_measure}. This forbids no candidate."


WRONG = {
    "nothing varied": ({}, {}, "over: name at least one parameter that is varied"),
    "unknown path": ({"over": {"drive.amplitud": [1.0]}}, {}, "drive.amplitud"),
    "unknown objective": ({"maximise": ["mean electrostatic_farce"]}, OVER, "maximise: quantity 'mean electrostatic_farce'"),
    "path not varied": ({"minimise": ["stack.gap.thickness"]}, OVER, "minimise: 'stack.gap.thickness' is not varied"),
    "twice": ({"minimise": ["mean electrostatic_force"]}, OVER, "is an objective already"),
    "no objective": ({"maximise": [], "minimise": []}, OVER, "name at least one objective"),
    "unknown material": ({"materials": ["silicate"]}, OVER, "silicate"),
    "material twice": ({"materials": ["silica", "SiO2"]}, OVER, "named twice"),
    "unknown layer": ({"materials": ["silica"], "layer": "insulater"}, OVER, "layer 'insulater'"),
    "layer alone": ({"layer": "insulator"}, OVER, "layer: names the layer whose material is varied"),
    "too many rounds": ({"refine": 21}, OVER, "refine = 21"),
    "limit": ({"limits": {"voltage": "-1 V"}}, OVER, "limits.voltage"),
    "value": ({}, {"drive.amplitude": ["100 m"]}, "drive.amplitude"),
    "suffix": ({"output": "plate.xlsx"}, OVER, r"plate\.xlsx"),
    "text range": ({"over": ["drive.amplitude=1V"]}, {}, "expected PATH=FROM:TO:N"),
}  # fmt: skip


@pytest.mark.parametrize("wrong", WRONG)
def test_mistakes_are_refused(wrong):
    options, over, words = WRONG[wrong]
    options = {"over": over} | options
    with pytest.raises(InputError, match=words):
        plate(STATIC, **options)


def test_all_mistakes_are_reported_at_once():
    with pytest.raises(InputError) as caught:
        plate(STATIC, OVER, materials=["silicate"], maximise=["x"], limits={"voltage": 0.0}, refine=-1)
    assert len(caught.value.problems) >= 4


def test_the_csv_file_has_every_candidate_with_every_limit(design):
    text = as_csv(design)
    lines = [line for line in text.splitlines() if not line.startswith("#")]
    rows = list(csv.DictReader(io.StringIO("\n".join(lines))))
    assert len(rows) == len(design.candidates)
    for cells, each in zip(rows, design.candidates, strict=True):
        assert float(cells["drive.amplitude [V]"]) == at_amplitude(each)
        assert float(cells["mean electrostatic_force [N]"]) == each.values["mean electrostatic_force"]
        assert (
            float(cells["film strength, insulator: limit/value"])
            == row(each, "film strength, insulator").margin
        )
        assert cells["forbidden by"] == "; ".join(each.forbidden_by)
        assert (cells["within the limits"] == "yes") == each.is_allowed
        assert (cells["best"] == "yes") == (each is design.best)
    assert sum(cells["Pareto set"] == "yes" for cells in rows) == len(design.pareto)
    assert design.answer in text


def test_the_page_begins_with_the_answer_and_has_the_figure(design):
    page = as_html(design)
    assert "within the limits is" in page
    assert "<svg" in page
    assert "Pareto set" in page


def test_the_figure_draws_each_candidate_once_with_prefixed_axes(design):
    (axes,) = figure_of(design).axes
    points = [line for line in axes.lines if line.get_linestyle() == "None" and line.get_marker() != "*"]
    assert sum(len(line.get_xdata()) for line in points) == len(design.candidates)
    assert len(axes.get_legend().get_texts()) <= 5
    assert axes.get_xlabel() == "peak voltage [kV]"
    assert re.fullmatch(r"mean electrostatic force \[(m|µ)?N\]", axes.get_ylabel())
    (front,) = [line for line in axes.lines if line.get_linestyle() == "-"]
    assert list(front.get_xdata()) == sorted(each.values["peak voltage"] for each in design.pareto)


@pytest.mark.parametrize("suffix", ["csv", "html", "png"])
def test_the_command_prints_the_answer_and_writes(suffix, tmp_path):
    (tmp_path / "limits.toml").write_text('voltage = "200 V"\n', encoding="utf-8")
    out = tmp_path / f"plate.{suffix}"
    arguments = [
        "design",
        "bau_2010/sine",
        "--over",
        "stack.insulator.thickness=1um:4um:2log",
        "--over",
        "drive.amplitude=100V:300V:3",
    ]
    arguments += [
        "--material",
        "silica,parylene C",
        "--limits",
        str(tmp_path / "limits.toml"),
        "-o",
        str(out),
    ]
    done = CliRunner().invoke(app, arguments)
    assert done.exit_code == 0, done.output
    assert "mean electrostatic force within the limits is" in done.output.replace("\n", " ")
    assert out.stat().st_size > 1000
    again = CliRunner().invoke(app, arguments)
    assert (again.exit_code == 0) == (suffix in {"csv", "html"}), "a figure carries no mark"


def test_the_plate_is_a_result_like_that_of_every_design(design, tmp_path):
    assert design.is_achieved
    assert design.scenario.drive.amplitude == at_amplitude(design.best)
    assert design.base.drive.amplitude == 100
    assert design.lines[-len(design.notes) :] == design.notes
    assert " ".join(design.sentences) == design.answer
    write_design(design, tmp_path / "plate.json")
    table = json.loads((tmp_path / "plate.json").read_text(encoding="utf-8"))
    assert table["form"] == "plate"
    assert [each["at"] for each in table["candidates"] if each["is_best"]] == [design.best.at]
    assert sum(each["is_efficient"] for each in table["candidates"]) == len(design.pareto)
    write_design(design, tmp_path / "plate.toml")
    assert ev.load(tmp_path / "plate.toml").drive.amplitude == at_amplitude(design.best)


def test_without_a_plate_within_the_limits_there_is_no_scenario():
    found = plate(STATIC, {"drive.amplitude": [100.0]}, limits={"voltage": 50.0})
    assert (found.scenario, found.is_achieved) == (None, False)


@pytest.mark.parametrize(
    ("values", "added"),
    [
        ([1e-6, 4e-6, 16e-6], {2e-6}),
        ([1e-6, 4e-6, 7e-6], {2.5e-6}),
        ([1e-6, 4e-6], {2.5e-6}),
    ],
)
def test_candidates_are_added_between_values_as_these_are_spaced(values, added):
    found = plate(STATIC, {"stack.insulator.thickness": values}, limits=FAR, refine=1)
    assert found.best.at["stack.insulator.thickness"] == 1e-6
    fresh = [each.at["stack.insulator.thickness"] for each in found.candidates if each.refined]
    assert fresh == pytest.approx(sorted(added))


def test_the_limit_with_the_largest_gain_comes_first():
    """300 V on 0.5 cm2 exceed the limit of the voltage alone, and 200 V on 1.5 cm2, with more force, that of the charge."""
    over = {"contact.area": [0.5e-4, 1.5e-4], "drive.amplitude": [200.0, 300.0]}
    found = plate(STATIC, over, limits={"voltage": 250.0, "charge": 8e-9})
    assert [each.forbidden_by for each in found.candidates[:3]] == [(), ("peak voltage",), ("charge",)]
    assert [gain.limits for gain in found.gains] == [("charge",), ("peak voltage",)]
    assert found.answer.count("Charge binds") == 1
