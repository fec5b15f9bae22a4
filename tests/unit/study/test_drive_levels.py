"""Both pairs of a drive's levels in scenarios: files, changes, sweeps, free parameters, the list of models."""

from __future__ import annotations

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import papers
from electrovib.core.errors import InputError
from electrovib.physics.drive.levels import LevelledDrive, Swing
from electrovib.scenario import preset
from electrovib.scenario.toml import to_toml
from electrovib.study.catalogue.described import parameters

MEAN = "mean electrostatic_force"
BASE = "bau_2010/sine"
REST = {
    "Sine": {"frequency": 125},
    "Burst": {"frequency": 250, "cycles": 3},
    "Chirp": {"first": 10, "last": 200, "length": 0.05},
    "AmplitudeModulation": {"carrier": 1000, "modulation": 100, "depth": 0.5},
    "SquareRootModulation": {"carrier": 1000, "modulation": 100, "depth": 0.5},
    "Square": {"frequency": 60},
    "PulseTrain": {"frequency": 60, "width": 5e-3},
    "Trapezium": {"rise": 1e-3, "hold": 5e-3, "fall": 1e-3, "repeat": 0.02},
}


def scenario(name, **pair):
    state = {} if name in {"Burst", "Chirp"} else {"time.initial_state": {"model": "PeriodicState"}}
    drive = {"model": name} | REST[name] | pair
    return ev.load(BASE, changes={"drive": drive, "time.initial_state": {"model": "AtRest"}} | state)


@pytest.mark.parametrize("name", REST)
def test_sweeps_and_free_parameters_take_either_pair(name):
    start = scenario(name, high=100, low=-100)
    crest = start.drive.high / start.drive.amplitude
    levels = [75.0, 50.0]
    expected = [
        float(ev.sweep(scenario(name, high=level, low=-level), {}, quantities=[MEAN])[MEAN])
        for level in levels
    ]
    assert expected[0] == pytest.approx(
        expected[1] * 1.5**2, rel=1e-6
    )  # the attraction is that of the squared voltage
    by_path = {"drive.high": levels, "drive.amplitude": [level / crest for level in levels]}
    for path, values in by_path.items():
        found = ev.sweep(start, {path: values}, quantities=[MEAN])
        assert found[path].attrs["units"] == "V"
        np.testing.assert_allclose(found[MEAN], expected, rtol=1e-9)
        ready = ev.prepare(start, free=[path], quantities=[MEAN])
        through_0 = [ready([value])[MEAN] for value in (values[0], 0.0, values[1])]
        np.testing.assert_allclose(through_0, [expected[0], 0.0, expected[1]], rtol=1e-9, atol=1e-15)
    both = ev.prepare(start, free=["drive.high", "drive.low"], quantities=[MEAN])
    np.testing.assert_allclose([both([75, -75])[MEAN], both([50, -50])[MEAN]], expected, rtol=1e-9)
    assert both([50, -75])[MEAN] == pytest.approx(
        float(ev.sweep(scenario(name, high=50, low=-75), {}, quantities=[MEAN])[MEAN]), rel=1e-9
    )
    pair = ev.sweep(start, {"drive.high": levels, "drive.low": [-75.0, -50.0]}, quantities=[MEAN])[MEAN]
    np.testing.assert_allclose(np.diag(pair), expected, rtol=1e-9)


@pytest.mark.parametrize("state", ["AtRest", "PeriodicState"])
@pytest.mark.parametrize("name", ["Sine", "AmplitudeModulation", "CurrentSine"])
def test_an_offset_is_the_constant_that_the_drive_of_that_name_adds(name, state):
    """Also beside sines without an offset, which a sweep answers together."""
    size = 1e-6 if name == "CurrentSine" else 1.0
    inner = {"model": name, "amplitude": 50 * size} | REST.get(name, {"frequency": 125})
    changes = {"time.initial_state": {"model": state}, "time.samples": 101}
    shifted = ev.load(BASE, changes=changes | {"drive": inner | {"offset": 30 * size}})
    if name == "CurrentSine":
        assert shifted.drive.voltage(0.002) == pytest.approx(size * (30 + 50 * np.sin(2 * np.pi * 0.25)))
        with pytest.raises(InputError, match="must be a voltage"):
            ev.load(BASE, changes={"drive": {"model": "Offset", "level": 30, "drive": inner}})
        return
    wrapped = ev.load(BASE, changes=changes | {"drive": {"model": "Offset", "level": 30, "drive": inner}})
    found, expected = ev.simulate(shifted), ev.simulate(wrapped)
    np.testing.assert_array_equal(found.electrostatic_force, expected.electrostatic_force)
    swept = ev.sweep(shifted, {"drive.offset": [0.0, -10.0, 30.0]}, quantities=[MEAN])[MEAN]
    alone = float(ev.sweep(wrapped, {}, quantities=[MEAN])[MEAN])
    assert float(swept[2]) == pytest.approx(alone, rel=1e-12)
    assert float(swept[2]) > 1.05 * float(swept[0]) > 0


def presets():
    for name, module in papers().items():
        for key, found in getattr(module, "scenarios", dict)().items():
            yield f"{name}/{key}", found


def test_the_file_of_every_preset_keeps_its_meaning(tmp_path):
    """As written today, and as it was written before a sine had an offset."""
    seen = set()
    for name, found in presets():
        text = to_toml(found)
        before = "\n".join(line for line in text.splitlines() if not line.startswith("offset = "))
        (tmp_path / "a.toml").write_text(text, encoding="utf-8")
        (tmp_path / "b.toml").write_text(before, encoding="utf-8")
        for path in ("a.toml", "b.toml"):
            again = ev.load(tmp_path / path)
            assert again == found, name
            assert again.digest() == found.digest()
        seen.add(type(found.drive).__name__)
        if not isinstance(found.drive, LevelledDrive):
            continue
        higher, louder = (found.replace({f"drive.{key}": value}) for key, value in
                          (("high", found.drive.high * 1.25), ("amplitude", found.drive.amplitude * 1.25)))  # fmt: skip
        if found.drive.offset == 0:
            assert higher.drive.voltage(1e-3) == pytest.approx(1.25 * found.drive.voltage(1e-3), rel=1e-12)
            assert louder.drive.low == pytest.approx(1.25 * found.drive.low, rel=1e-12)
        else:
            assert higher.drive.low == pytest.approx(found.drive.low, rel=1e-12, abs=1e-9)
            assert louder.drive.offset == pytest.approx(found.drive.offset, rel=1e-12)
        assert higher.sources[
            "drive.high" if "high" in type(higher.drive).model_fields else "drive.amplitude"
        ] == ("set by the user")
    assert {"Sine", "Square", "Trapezium"} <= seen


def test_a_square_set_to_another_high_level_on_the_command_line():
    square = scenario("Square", high=100, low=-100)
    trace = ev.run(square, set=["drive.high=75 V"])
    changed = ev.scenario_of(trace).drive
    assert (changed.high, changed.low, changed.amplitude, changed.offset) == (75, -75, 75, 0)
    with pytest.raises(
        InputError, match=r"drive.high: is given beside 'amplitude', of the other pair; give amplitude and"
    ):
        ev.run(square, set=["drive.high=75 V", "drive.amplitude=50 V"])
    with pytest.raises(InputError, match=r"drive.high: is given beside 'amplitude'"):
        ev.sweep(square, {"drive.high": [1.0, 2.0], "drive.amplitude": [1.0, 2.0]})


def test_a_level_that_is_set_stays_beside_a_swept_one():
    """A symmetric drive stays symmetric, unless the other level is set with the sweep."""
    square = scenario("Square", high=100, low=-100)
    lows = [-75.0, 0.0]  # of the drive; the stack loses less than 1e-4 of it in the resistance
    alone = ev.run(square, over={"drive.low": [-75.0, -30.0]}, quantities=["peak stack_voltage"])
    np.testing.assert_allclose(alone["peak stack_voltage"], [75, 30], rtol=1e-4)
    for set_, over in (
        ({"drive.high": 75}, {"drive.low": lows}),
        (["drive.high=75 V"], ["drive.low=-75:0:2"]),
    ):
        trace = ev.run(
            square, set=set_, over=over, quantities=["maximum stack_voltage", "minimum stack_voltage"]
        )
        assert trace["drive.high"].values.tolist() == [75]
        np.testing.assert_allclose(trace["maximum stack_voltage"].squeeze(), [75, 75], rtol=1e-4)
        np.testing.assert_allclose(trace["minimum stack_voltage"].squeeze(), lows, rtol=1e-4, atol=1e-2)
    with pytest.raises(InputError, match=r"drive.high: is given beside 'amplitude'"):
        ev.run(square, set={"drive.high": 75}, over={"drive.amplitude": [1.0, 2.0]})
    offset = ev.run(square, set={"drive.offset": 10}, over={"drive.amplitude": [1.0, 2.0]})
    assert set(offset.dims) == {"drive.amplitude"}
    assert ev.scenario_of(offset).drive.offset == 10


def test_another_drive_takes_nothing_from_the_levels_of_the_former():
    sine = scenario("Sine", amplitude=100)
    table = {"drive.model": "Square", "drive.high": 75, "drive.frequency": 60}
    assert (sine.replace(table).drive.high, sine.replace(table).drive.low) == (75, 0)
    with pytest.raises(InputError, match="needs 'low' beside it"):
        scenario("Square", high=100).replace({"drive.model": "Sine", "drive.high": 75, "drive.frequency": 60})
    whole = {"drive": {"model": "Square", "high": 100, "low": -100, "frequency": 60}, "drive.high": 75}
    assert (sine.replace(whole).drive.high, sine.replace(whole).drive.low) == (75, -100)  # both are given


def test_a_ready_made_scenario_keeps_the_source_of_a_converted_level():
    made = preset(scenario("Sine", amplitude=100), title="x", changes={"drive.high": (75, "table 2")})
    assert (made.drive.amplitude, made.sources["drive.amplitude"]) == (75, "table 2")
    made = preset(scenario("Square", high=100, low=-100), title="x", changes={"drive.high": (75, "table 2")})
    assert (made.drive.low, made.sources["drive.low"]) == (-75, "table 2")


def test_the_list_of_models_shows_both_pairs():
    for name in REST:
        kind = type(scenario(name, high=100, low=-100).drive)
        rows = {row[0]: row for row in parameters(kind).rows}
        derived, stored = ("high", "low"), "amplitude and offset"
        if not issubclass(kind, Swing):
            derived, stored = ("amplitude", "offset"), "high and low"
        for each in derived:
            assert rows[each][1] == "V"
            assert rows[each][5] == f"in place of {stored}"
        assert set(rows) >= {"amplitude", "offset", "high", "low"}
    for name, note in (
        ("Sine", "or both high and low"),
        ("Square", "or amplitude and offset (0 unless given)"),
    ):
        page = " ".join(str(ev.models(name)).split())
        assert note in page
        assert "a drive that is symmetric about 0 stays symmetric" in page
