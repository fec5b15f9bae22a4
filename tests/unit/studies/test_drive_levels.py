"""Both pairs of a drive's levels in scenarios: files, changes, sweeps, free parameters, the list of models."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import offers
from electrovib.core.errors import InputError
from electrovib.physics.drive.levels import LevelledDrive, Swing
from electrovib.scenario import preset
from electrovib.scenario.toml import to_toml
from electrovib.studies.catalogue.pages import parameters

MEAN, BASE = "mean electrostatic_force", "bau_2010/sine"
MODULATION = {"carrier": 1000, "modulation": 100, "depth": 0.5}
REST = {
    "Sine": {"frequency": 125},
    "Burst": {"frequency": 250, "cycles": 3},
    "Chirp": {"first": 10, "last": 200, "length": 0.05},
    "AmplitudeModulation": MODULATION,
    "SquareRootModulation": MODULATION,
    "Square": {"frequency": 60},
    "PulseTrain": {"frequency": 60, "width": 5e-3},
    "Trapezium": {"rise": 1e-3, "hold": 5e-3, "fall": 1e-3, "repeat": 0.02},
}
BESIDE = r"drive.high: is given beside 'amplitude'"


def scenario(name, **pair):
    state = {} if name in {"Burst", "Chirp"} else {"time.initial_state": {"model": "PeriodicState"}}
    drive = {"model": name} | REST[name] | pair
    return ev.load(BASE, changes={"drive": drive, "time.initial_state": {"model": "AtRest"}} | state)


SQUARE = scenario("Square", high=100, low=-100)


def mean(made):
    return float(ev.sweep(made, {}, quantity=[MEAN])[MEAN])


@pytest.mark.parametrize("name", REST)
def test_sweeps_and_free_parameters_take_either_pair(name):
    start, levels = scenario(name, high=100, low=-100), [75.0, 50.0]
    crest = start.drive.high / start.drive.amplitude
    expected = [mean(scenario(name, high=level, low=-level)) for level in levels]
    squared = expected[1] * 1.5**2  # the attraction is that of the squared voltage
    assert expected[0] == pytest.approx(squared, rel=1e-6)
    for path, values in {"drive.high": levels, "drive.amplitude": [each / crest for each in levels]}.items():
        found = ev.sweep(start, {path: values}, quantity=[MEAN])
        assert found[path].attrs["units"] == "V"
        np.testing.assert_allclose(found[MEAN], expected, rtol=1e-9)
        ready = ev.prepare(start, free=[path], quantity=[MEAN])
        through_0 = [ready([value])[MEAN] for value in (values[0], 0.0, values[1])]
        np.testing.assert_allclose(through_0, [expected[0], 0.0, expected[1]], rtol=1e-9, atol=1e-15)
    both = ev.prepare(start, free=["drive.high", "drive.low"], quantity=[MEAN])
    ends = {(75, -75): expected[0], (50, -50): expected[1], (50, -75): mean(scenario(name, high=50, low=-75))}
    np.testing.assert_allclose([both([*pair])[MEAN] for pair in ends], [*ends.values()], rtol=1e-9)
    pair = ev.sweep(start, {"drive.high": levels, "drive.low": [-75.0, -50.0]}, quantity=[MEAN])[MEAN]
    np.testing.assert_allclose(np.diag(pair), expected, rtol=1e-9)


@pytest.mark.parametrize("state", ["AtRest", "PeriodicState"])
@pytest.mark.parametrize("name", ["Sine", "AmplitudeModulation"])
def test_an_offset_is_the_constant_that_the_drive_of_that_name_adds(name, state):
    """Also beside sines without an offset, which a sweep answers together."""
    inner = {"model": name, "amplitude": 50} | REST[name]
    changes = {"time.initial_state": {"model": state}, "time.samples": 101}
    shifted = ev.load(BASE, changes=changes | {"drive": inner | {"offset": 30}})
    wrapped = ev.load(BASE, changes=changes | {"drive": {"model": "Offset", "level": 30, "drive": inner}})
    found, expected = ev.simulate(shifted), ev.simulate(wrapped)
    np.testing.assert_array_equal(found.electrostatic_force, expected.electrostatic_force)
    swept = ev.sweep(shifted, {"drive.offset": [0.0, -10.0, 30.0]}, quantity=[MEAN])[MEAN]
    assert float(swept[2]) == pytest.approx(mean(wrapped), rel=1e-12)
    assert float(swept[2]) > 1.05 * float(swept[0]) > 0


def test_an_offset_of_a_current_has_no_drive_of_that_name():
    inner = {"model": "CurrentSine", "amplitude": 50e-6, "frequency": 125}
    shifted = ev.load(BASE, changes={"drive": inner | {"offset": 30e-6}})
    assert shifted.drive.voltage(0.002) == pytest.approx(1e-6 * (30 + 50 * np.sin(2 * np.pi * 0.25)))
    with pytest.raises(InputError, match="must be a voltage"):
        ev.load(BASE, changes={"drive": {"model": "Offset", "level": 30, "drive": inner}})


def test_the_file_of_every_preset_keeps_its_meaning(tmp_path):
    """As written today, and as it was written before a sine had an offset."""
    seen = set()
    for name, found in offers(("scenarios",)).items():
        text = to_toml(found)
        before = "\n".join(line for line in text.splitlines() if not line.startswith("offset = "))
        for written in (text, before):
            (tmp_path / "a.toml").write_text(written, encoding="utf-8")
            again = ev.load(tmp_path / "a.toml")
            assert again == found, name
            assert again.digest() == found.digest()
        drive = found.drive
        seen.add(type(drive).__name__)
        if not isinstance(drive, LevelledDrive):
            continue
        higher = found.replace({"drive.high": drive.high * 1.25})
        louder = found.replace({"drive.amplitude": drive.amplitude * 1.25})
        if drive.offset == 0:
            assert higher.drive.voltage(1e-3) == pytest.approx(1.25 * drive.voltage(1e-3), rel=1e-12)
            assert louder.drive.low == pytest.approx(1.25 * drive.low, rel=1e-12)
        else:
            assert higher.drive.low == pytest.approx(drive.low, rel=1e-12, abs=1e-9)
            assert louder.drive.offset == pytest.approx(drive.offset, rel=1e-12)
        stored = "drive.high" if "high" in type(drive).model_fields else "drive.amplitude"
        assert higher.sources[stored] == "set by the user"
    assert {"Sine", "Square", "Trapezium"} <= seen


def test_a_level_that_is_set_is_that_of_either_pair_and_stays_beside_a_swept_one():
    changed = ev.scenario_of(ev.run(SQUARE, set=["drive.high=75 V"])).drive
    assert (changed.high, changed.low, changed.amplitude, changed.offset) == (75, -75, 75, 0)
    with pytest.raises(InputError, match=f"{BESIDE}, of the other pair; give amplitude and"):
        ev.run(SQUARE, set=["drive.high=75 V", "drive.amplitude=50 V"])
    with pytest.raises(InputError, match=BESIDE):
        ev.sweep(SQUARE, {"drive.high": [1.0, 2.0], "drive.amplitude": [1.0, 2.0]})
    with pytest.raises(InputError, match=BESIDE):
        ev.run(SQUARE, set={"drive.high": 75}, over={"drive.amplitude": [1.0, 2.0]})
    lows = [-75.0, 0.0]  # of the drive; the stack loses less than 1e-4 of it in the resistance
    alone = ev.run(SQUARE, over={"drive.low": [-75.0, -30.0]}, quantity=["peak stack_voltage"])
    np.testing.assert_allclose(alone["peak stack_voltage"], [75, 30], rtol=1e-4)
    asked = ["maximum stack_voltage", "minimum stack_voltage"]
    for set_, over in (
        ({"drive.high": 75}, {"drive.low": lows}),
        (["drive.high=75 V"], ["drive.low=-75:0:2"]),
    ):
        trace = ev.run(SQUARE, set=set_, over=over, quantity=asked)
        assert trace["drive.high"].values.tolist() == [75]
        np.testing.assert_allclose(trace[asked[0]].squeeze(), [75, 75], rtol=1e-4)
        np.testing.assert_allclose(trace[asked[1]].squeeze(), lows, rtol=1e-4, atol=1e-2)
    offset = ev.run(SQUARE, set={"drive.offset": 10}, over={"drive.amplitude": [1.0, 2.0]})
    assert set(offset.dims) == {"drive.amplitude"}
    assert ev.scenario_of(offset).drive.offset == 10


def test_another_drive_takes_nothing_from_the_levels_of_the_former_and_a_level_keeps_its_source():
    sine = scenario("Sine", amplitude=100)
    found = sine.replace({"drive.model": "Square", "drive.high": 75, "drive.frequency": 60}).drive
    assert (found.high, found.low) == (75, 0)
    with pytest.raises(InputError, match="needs 'low' beside it"):
        scenario("Square", high=100).replace({"drive.model": "Sine", "drive.high": 75, "drive.frequency": 60})
    whole = {"drive": {"model": "Square", "high": 100, "low": -100, "frequency": 60}, "drive.high": 75}
    found = sine.replace(whole).drive
    assert (found.high, found.low) == (75, -100)  # both are given
    for start, path in ((sine, "drive.amplitude"), (SQUARE, "drive.low")):
        made = preset(start, title="x", changes={"drive.high": 75}, sources={"drive.high": "table 2"})
        assert (made.drive.high, made.drive.low, made.sources[path]) == (75, -75, "table 2")


def test_the_list_of_models_shows_both_pairs():
    pairs = ("amplitude", "offset"), ("high", "low")
    for name in REST:
        kind = type(scenario(name, high=100, low=-100).drive)
        rows = {row[0]: row for row in parameters(kind).rows}
        stored, derived = pairs if issubclass(kind, Swing) else reversed(pairs)
        for each in derived:
            assert (rows[each][1], rows[each][5]) == ("V", f"in place of {' and '.join(stored)}")
        assert set(rows) >= {*stored, *derived}
    notes = {"Sine": "or both high and low", "Square": "or amplitude and offset (0 unless given)"}
    for name, note in notes.items():
        page = " ".join(str(ev.models(name)).split())
        assert note in page
        assert "a drive that is symmetric about 0 stays symmetric" in page
