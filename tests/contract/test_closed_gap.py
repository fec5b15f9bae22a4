"""Every door that judges a limit judges the film with the gap closed: 3 um of air hide what 300 V do to a film of 1 um."""

import json

import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.apps.explorer.computed import Further, compute, with_answers
from electrovib.apps.explorer.key_figures import LIMIT, answers
from electrovib.apps.explorer.page.plots import answer_words
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.exports.save import export_netlist

FILM, CLOSED = "film strength, insulator", "film strength, insulator, gap closed"
STRENGTH, THICKNESS, GAP, VOLTS = 200e6, 1e-6, 3e-6, 300.0
LARGEST = STRENGTH * THICKNESS
SCREEN = {
    "schema": 1,
    "drive": {"model": "Sine", "amplitude": VOLTS, "frequency": 120},
    "force": {"model": "MaxwellStressInGap"},
    "friction": {"model": "Coulomb", "coefficient": 0.5},
    "contact": {"model": "FixedArea", "area": 1e-4},
    "load": {"normal_force": 0.5},
    "motion": {"speed": "30 mm/s"},
    "limits": {"voltage": "2 kV", "current": "1 A"},
    "circuit": {"return_path": {"model": "Grounded", "resistance": "1 kohm"}},
    "stack": {
        "insulator": {
            "thickness": THICKNESS,
            "material": {"model": "Constant", "permittivity": 3.9},
            "breakdown_field": STRENGTH,
        },
        "gap": {"thickness": GAP},
        "stratum_corneum": {
            "thickness": "200 um",
            "material": {"model": "Constant", "permittivity": 1560, "conductivity": "1.79 uS/m"},
        },
    },
}
OVER = {"drive.amplitude": [100.0, 150.0, 250.0, 300.0]}


@pytest.fixture(scope="module")
def screen():
    return ev.load(SCREEN)


def closed(result):
    return next(each for each in diagnostics_of(result) if each.name == CLOSED)


def row(rows, quantity):
    return next(each for each in rows if each.quantity == quantity)


def test_the_film_holds_behind_air_and_not_where_a_ridge_or_sweat_closes_the_gap(screen):
    """Voltage over thickness; what the gap takes, and a resistor in front of the plate, does not count."""
    for changes in ({}, {"circuit.source_resistance": "10 Mohm"}, {"stack.gap.thickness": "1 mm"}):
        rows = ev.check(screen, set=changes).rows
        assert row(rows, FILM).state == "pass"
        assert row(rows, CLOSED).value == pytest.approx(VOLTS / THICKNESS, rel=1e-12)
        assert row(rows, CLOSED).state == "fail"
    held = ev.check(screen, set={"drive.amplitude": LARGEST})
    assert (row(held.rows, CLOSED).state, held.failed) == ("pass", ())


def test_saturation_counts_and_gain_and_offset_do():
    for amplifier, factor in (({"gain": 2}, 2), ({"gain": -2, "saturation": "350 V"}, 350 / VOLTS)):
        rows = ev.check(SCREEN, set={"circuit.amplifier": amplifier}).rows
        assert row(rows, CLOSED).value == pytest.approx(factor * VOLTS / THICKNESS, rel=1e-9)
    rows = ev.check(SCREEN, set={"drive": {"model": "Square", "low": -350, "high": 10, "frequency": 50}}).rows
    assert row(rows, CLOSED).value == pytest.approx(350 / THICKNESS)
    driven = {"drive": {"model": "CurrentSine", "amplitude": "20 uA", "frequency": "1 kHz"}}
    found = ev.check(SCREEN, set=driven)
    assert row(found.rows, CLOSED).value == pytest.approx(found.value("peak voltage") / THICKNESS)


def test_runs_sweeps_studies_and_comparisons(screen):
    found = closed(ev.simulate(screen))
    assert (found.state, found.value, found.limit) == ("warning", pytest.approx(VOLTS / THICKNESS), STRENGTH)
    assert "with the gap closed by a ridge or by sweat" in found.text
    assert closed(ev.sweep(screen, OVER)).state == "warning"
    assert closed(ev.compare(screen)).state == "warning"
    own = ev.compare_materials(screen, materials=["alumina_ald"]).entries[0]
    assert own.closed_margin == pytest.approx(STRENGTH * THICKNESS / VOLTS)
    assert own.margin > 8
    assert own.breakdown == "warning"


def test_designs_stay_within_the_strength_with_the_gap_closed(screen):
    want, free = "mean electrostatic_force", "drive.amplitude = 10 V:1 kV"
    at_most = ev.simulate(screen.replace({"drive.amplitude": LARGEST}))
    over = 2 * float(at_most.electrostatic_force.max())
    found = ev.find_value(screen, want={want: over}, free=free)
    assert not found.is_achieved
    assert found.obtainable.value == pytest.approx(LARGEST, rel=1e-6)
    assert CLOSED in found.obtainable.row.quantity
    plate = ev.plan_plate(screen, OVER, refine=0)
    assert [each.is_allowed for each in plate.candidates] == [True, True, False, False]
    assert plate.best.at["drive.amplitude"] == 150
    assert plate.check.state == "pass"
    space = {"stack.gap.thickness": {"model": "LogNormal", "median": GAP, "factor": 1.2}}
    asked = {"free": free, "space": space, "seed": 1, "share": 0.9}
    shared = ev.value_for_share(screen, want={want: over}, **asked)
    assert CLOSED in {each.quantity for each in shared.failed}
    assert shared.within.value <= LARGEST * (1 + 1e-9)
    driven = ev.drive_for_force(screen, target="sine 20 Hz 1 N", method="carrier", carrier="2 kHz")
    assert driven.check.value("peak voltage") > LARGEST
    assert CLOSED in {each.quantity for each in driven.check.forbidding}
    assert not driven.is_achieved


@pytest.mark.parametrize("door", ["waveform", "netlist is only a model", "texture", "stream", "bench"])
def test_nothing_leaves_that_would_break_the_film(door, screen, tmp_path):
    if door == "waveform":
        with pytest.raises(InputError, match="with the gap closed"):
            ev.export_waveform(screen, tmp_path / "drive.csv", rate=50e3, edge="line")
    elif door == "texture":
        texture = {"model": "Grating", "period": "2 mm", "amplitude": "600 mN"}
        with pytest.raises(InputError, match="with the gap closed"):
            ev.texture_drive(screen, texture=texture, path="30 mm/s")
    elif door == "stream":
        texture = {"model": "Grating", "period": "2 mm", "amplitude": "600 mN"}
        with pytest.raises(InputError, match="with the gap closed"):
            ev.texture_stream(screen, texture=texture)
    elif door == "bench":
        from electrovib.bench.run import plan_bench

        burst = {
            "drive": {"model": "Trapezium", "high": VOLTS, "rise": "5 ms", "hold": "10 ms", "fall": "5 ms"}
        }
        content = plan_bench("vezzoli_2014/fig6").settings.to_dict()
        with pytest.raises(InputError, match="with the gap closed"):
            plan_bench(screen.replace(burst), bench=content)
    else:
        found = export_netlist(screen, tmp_path / "screen.cir")
        assert closed(found).state == "warning"
    assert not (tmp_path / "drive.csv").exists()


def test_the_page_says_exceeded(screen):
    found = compute(screen)
    further = with_answers(Further(check=ev.check(screen)), found)
    figure = answers(further)[LIMIT]
    assert (figure.value, figure.state) == ("exceeded", "fail")
    assert CLOSED in figure.note
    said, below = answer_words(further.check.document, further.check.state)
    assert said.startswith('<p class="ev-warning">exceeded: ')
    assert CLOSED in said
    assert CLOSED in below
    rough = {"model": "PerssonSurface", "modulus": 2e7, "rms_slope": 1.0, "rms_gap": 1e-5}
    factors = {"pressure_factor": 0.1, "decay_factor": 0.46}
    check = ev.check(screen, set={"contact.surface": rough | factors})
    share = f"(on {100 * row(check.rows, CLOSED).area:.3g} % of the area)"
    assert share in answers(with_answers(Further(check=check), found))[LIMIT].note
    assert share in "".join(answer_words(check.document, check.state))
    assert "% of the contact area by PerssonSurface, not corrected" in "".join(
        answer_words(check.document, check.state)
    )


def test_states_of_a_growing_contact_are_judged_with_the_gap_closed():
    surface = {"contact.surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"}}
    found = ev.equilibrium(ev.load(SCREEN).replace(surface), voltage=VOLTS)
    assert closed(found).value == pytest.approx(VOLTS / THICKNESS)


OUTCOMES = {
    "within all limits": ({"drive.amplitude": "100 V"}, 0),
    "exceeded": ({}, 1),
    "not shown to be safe": ({"stack.insulator.breakdown_field": "1 GV/m"}, 5),
}


@pytest.mark.parametrize("outcome", OUTCOMES)
def test_three_outcomes_each_with_its_code(outcome, tmp_path):
    """At 300 V the field of the gap is above that of field emission, whose standing is uncertain: no pass."""
    changes, code = OUTCOMES[outcome]
    scenario = tmp_path / "screen.toml"
    scenario.write_text(ev.load(SCREEN).replace(changes).to_toml(), encoding="utf-8")
    done = CliRunner().invoke(app, ["check", str(scenario), "-o", str(tmp_path / "check.json")])
    assert done.exit_code == code, done.output
    assert done.output.startswith(outcome)
    assert json.loads((tmp_path / "check.json").read_text(encoding="utf-8"))["outcome"] == outcome
    if outcome == "not shown to be safe":
        assert "field emission" in done.output.splitlines()[0]
        assert "look for discharges in the gap" in done.output


def test_each_shipped_scenario_has_the_outcome_that_its_limits_and_its_film_leave(scenario):
    """By another route: voltage over thickness of a single film, and what is declared; `scenario` runs over all of them."""
    found = ev.check(scenario)
    exceeded = any(each.limit and each.value > each.limit and each.state == "fail" for each in found.rows)
    asked = scenario.drive.largest() if scenario.drive.quantity == "voltage" else found.value("peak voltage")
    plate = [name for name, role in scenario.stack.roles.items() if role == "plate"]
    judged = [each for each in found.rows if each.quantity == f"film strength, {''.join(plate)}, gap closed"]
    if len(plate) == 1 and judged:
        amplifier = scenario.circuit.supply
        asked = min(asked * abs(amplifier.gain), amplifier.saturation or asked * abs(amplifier.gain))
        assert judged[0].value == pytest.approx(asked / scenario.stack.layers[plate[0]].thickness, rel=1e-6)
    declared = scenario.limits.voltage is not None and scenario.limits.current is not None
    uncertain = any(
        each.limit
        and each.state == "unknown"
        and (each.value > each.limit or each.quantity.startswith("film"))
        for each in found.rows
    )
    no_strength = any(each.quantity.startswith("film") and each.limit is None for each in found.rows)
    no_strength |= not plate
    expected = "fail" if exceeded else "pass" if declared and not uncertain and not no_strength else "unknown"
    assert found.state == expected


def test_a_plate_without_a_film_is_never_shown_to_be_safe():
    """Where the gap closes, the finger touches the electrode."""
    stack = {name: layer for name, layer in SCREEN["stack"].items() if name != "insulator"}
    found = ev.check({**SCREEN, "stack": stack})
    assert found.state == "unknown"
    assert found.headline == "not shown to be safe: field emission; bare electrode"
    assert any("--series-resistor" in line for line in found.document.sentences)
