"""Ways round a limit that were open once: what was not judged is no pass, and nothing states less than was met."""

from dataclasses import replace

import numpy as np
import pytest
from tests.contract.test_closed_gap import CLOSED, FILM, SCREEN, STRENGTH, THICKNESS, row

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Smooth
from electrovib.physics.drive.sines import Oscillation, Sine
from electrovib.physics.safety import emission_diagnostic
from electrovib.studies.check.result import CheckRow, breakdown_row


def spike(self):
    """Return a formula that is a hundred thousand times faster than its stated frequency."""

    def formula(time):
        return self.amplitude * np.exp(-(((np.asarray(time) - 2.345e-3) / 1e-8) ** 2))

    return (Smooth(formula, lambda time: 0 * np.asarray(time), 0.0, 1.0, 100.0),)


@pytest.mark.parametrize("kind", ["stated", "formula"])
@pytest.mark.parametrize("gain", [None, -1.0])
def test_a_drive_that_states_too_little_is_judged_by_the_voltage_that_it_has(kind, gain, monkeypatch):
    """Of a user's model: 1 V and 0 V were judged, while fields and currents were those of 300 V."""
    if kind == "stated":
        monkeypatch.setattr(Sine, "extremes", lambda *_: (-1.0, 1.0))
    else:
        monkeypatch.delattr(Oscillation, "extremes")
        monkeypatch.setattr(Sine, "parts", spike)
    amplifier = {} if gain is None else {"circuit.amplifier": {"gain": gain}}
    changes = {"limits.voltage": 100.0, "time.duration": 4.69e-3, "drive.frequency": 100.0, **amplifier}
    found = ev.check(SCREEN, set=changes)
    assert row(found.rows, "peak voltage").value == pytest.approx(300, rel=1e-2)
    assert row(found.rows, CLOSED).value == pytest.approx(300 / THICKNESS, rel=1e-2)
    assert {each.quantity for each in found.failed} >= {"peak voltage", CLOSED}


def test_a_charged_body_is_a_voltage_too():
    """100 nC on 150 pF are 667 V between body and plate at 1 V of the drive; of either sign, and the drive adds to it."""
    for charge, reached in ((1e-7, 1e-7 / 150e-12 + 1), (-1e-7, 1e-7 / 150e-12 + 1), (0.0, 1.0)):
        circuit = {"return_path": {"model": "Floating", "capacitance": 150e-12, "charge": charge}}
        found = ev.check(SCREEN, set={"drive.amplitude": 1.0, "circuit": circuit})
        assert row(found.rows, CLOSED).value == pytest.approx(reached / THICKNESS, rel=1e-9)
        assert found.state == ("fail" if charge else "pass")
        assert row(found.rows, FILM).state == "pass"
    circuit = {"return_path": {"model": "Floating", "capacitance": 150e-12, "charge": -1e-8}}
    square = {"model": "Square", "low": 0.0, "high": 50.0, "frequency": 120, "edge": "1 ms"}
    found = ev.check(SCREEN, set={"drive": square, "circuit": circuit})
    assert row(found.rows, CLOSED).value == pytest.approx((50 + 1e-8 / 150e-12) / THICKNESS, rel=1e-9)
    circuit["return_path"]["charge"] = 1e-8  # of the sign of the drive: the body may have lost it
    found = ev.check(SCREEN, set={"drive": square | {"high": 100.0}, "circuit": circuit})
    assert row(found.rows, CLOSED).value == pytest.approx(100 / THICKNESS, rel=1e-9)


REST = "drive after the checked time"
PARTS = {
    "a sine cut short": ({"time.duration": 1e-6}, 300.0),
    "a beat": (
        {
            "drive": {
                "model": "Sum",
                "drives": [
                    {"model": "Sine", "amplitude": 150.0, "frequency": 120},
                    {"model": "Sine", "amplitude": 150.0, "frequency": 121, "phase": np.pi},
                ],
            }
        },
        300.0,
    ),
    "samples cut short": (
        {
            "drive": {"model": "Sampled", "time_samples": [0, 0.05, 0.1], "voltage_samples": [0, 10, 300]},
            "time.duration": 0.05,
        },
        300.0,
    ),
}


@pytest.mark.parametrize("part", PARTS)
def test_a_part_of_a_drive_is_no_pass(part):
    """The largest value comes after the last output time; with all of the drive the film fails."""
    changes, largest = PARTS[part]
    found = ev.check(SCREEN, set=changes)
    assert (found.state, found.failed) == ("unknown", ())
    assert row(found.rows, REST).value == pytest.approx(largest, rel=1e-4)
    assert f"{REST}" in found.headline
    assert "set time.duration to" in str(found)
    whole = ev.check(SCREEN, set={**changes, "time.duration": 1.0 if part == "a beat" else 0.1})
    assert CLOSED in {each.quantity for each in whole.failed}
    assert REST not in {each.quantity for each in whole.rows}


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"time.duration": 1 / 240},
        {"time.duration": 1e-6, "time.initial_state": {"model": "PeriodicState"}},
        {"drive": {"model": "Step", "level": 100.0}, "time.duration": 1e-6},
        {"drive": {"model": "CurrentSine", "amplitude": "1 uA", "frequency": 120}, "time.duration": 0.1},
    ],
)
def test_nothing_is_said_where_the_largest_value_was_checked(changes):
    assert REST not in {each.quantity for each in ev.check(SCREEN, set=changes).rows}


@pytest.mark.parametrize(
    "given", [{"limits": {"voltage": 2e3}, "current": 1e-9}, {"limits": {}, "voltage": 1.0}]
)
def test_a_limit_beside_a_table_of_limits_is_not_dropped(given):
    with pytest.raises(InputError, match=r"limits\.(current|voltage).*beside a table"):
        ev.check(SCREEN, limits=given)
    assert ev.check(SCREEN, set={"drive.amplitude": 1.0}, limits=SCREEN).state == "pass"


def test_a_film_in_two_is_no_way_round():
    """Of the same material with a trace of charge between, of another one, or conducting: what 300 V do to 1 um."""
    film = SCREEN["stack"]["insulator"] | {"role": "plate", "thickness": THICKNESS / 2}
    other = film | {"material": {"model": "Constant", "permittivity": 3.91}}
    for first in (
        film | {"initial_charge": 1e-12},
        other,
        film | {"material": {"model": "Constant", "permittivity": 3.9, "conductivity": 1e-12}},
    ):
        stack = {"first": first, "second": film} | {
            name: SCREEN["stack"][name] for name in ("gap", "stratum_corneum")
        }
        found = ev.check(SCREEN | {"stack": stack})
        for name in ("first", "second"):
            assert row(found.rows, f"film strength, {name}, gap closed").value >= 299 / THICKNESS
        assert len(found.failed) == 2
        plate = ev.plan_plate(SCREEN | {"stack": stack}, {"drive.amplitude": [90.0, 300.0]}, refine=0)
        assert [each.is_allowed for each in plate.candidates] == [True, False]


def test_charge_that_faces_the_gap_is_neutralised_where_the_gap_is_closed():
    """What lies on the outer face of the last film meets a conductor; with the gap open its field counts."""
    film = SCREEN["stack"]["insulator"] | {"role": "plate"}
    other = film | {"material": {"model": "Constant", "permittivity": 7.8}, "initial_charge": 1e-3}
    stack = {"first": film, "second": other} | {
        name: SCREEN["stack"][name] for name in ("gap", "stratum_corneum")
    }
    rows = ev.check(SCREEN | {"stack": stack}).rows
    for name, share in (("first", 2 / 3), ("second", 1 / 3)):
        value = row(rows, f"film strength, {name}, gap closed").value
        assert value == pytest.approx(300 * share / THICKNESS, rel=1e-9)


def test_a_field_without_a_bound_is_not_shown_to_be_safe():
    found = breakdown_row(emission_diagnostic(field=np.inf))
    assert (found.state, found.value, bool(found.remedy)) == ("unknown", None, True)


@pytest.mark.parametrize("name", [FILM, "field emission"])
def test_what_forbids_a_design_or_a_file(name):
    """A film above a doubtful strength, or of an unknown field; nothing at exactly the limit, and no doubtful limit of air."""
    for value, is_forbidden in ((199e6, False), (200e6, False), (201e6, name == FILM), (None, name == FILM)):
        doubtful = CheckRow(
            quantity=name, value=value, limit=200e6, unit="V/m", source="", state="unknown", text=""
        )
        assert doubtful.forbids == is_forbidden
        assert doubtful.is_refused == (is_forbidden or value is None)
        assert not replace(doubtful, limit=None).forbids
        assert replace(doubtful, state="fail").forbids


def test_the_check_says_which_values_are_those_of_the_declared_gap():
    assert any("those of the gap as declared" in each for each in ev.check(SCREEN).notes)
    bare = {name: SCREEN["stack"][name] for name in ("insulator", "stratum_corneum")}
    assert not any("gap as declared" in each for each in ev.check(SCREEN | {"stack": bare}).notes)


def test_a_share_is_that_of_films_of_which_the_thinnest_holds():
    """The gap decides which draws have the largest force, and none of those has the thinnest film."""
    space = {
        "stack.insulator.thickness": {"model": "LogNormal", "median": THICKNESS, "factor": 1.5},
        "stack.gap.thickness": {"model": "LogNormal", "median": 3e-6, "factor": 2.0},
    }
    thinnest = ev.read_space(SCREEN, space).draw(2, 0, 40)["stack.insulator.thickness"].min()
    asked = {"free": "drive.amplitude = 100 V:140 V", "space": space, "seed": 2, "n": 40, "share": 0.9}
    found = ev.value_for_share(SCREEN, want={"mean electrostatic_force": 0.01}, **asked)
    assert found.top.value > STRENGTH * thinnest
    assert [each.quantity for each in found.failed] == [CLOSED]
    assert found.failed[0].value == pytest.approx(found.top.value / thinnest, rel=1e-9)


def test_a_file_of_samples_that_is_refused_says_why(tmp_path):
    """The sentence was once the name of a generator."""
    place = tmp_path / "drive.csv"
    place.write_text("time,voltage\n0,0\n0,0\n0.1,5\n", encoding="utf-8")
    with pytest.raises(InputError, match="time must increase"):
        ev.check(place, SCREEN)
