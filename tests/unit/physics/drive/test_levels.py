"""Amplitude and offset, or high and low: every drive between two levels takes either pair and gives both."""

import itertools

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.quantity import quantity_of
from electrovib.core.units import format_quantity
from electrovib.physics.drive.base import Drive
from electrovib.physics.drive.current import CurrentAmplifier, CurrentSine
from electrovib.physics.drive.edges import PulseTrain, Square, Step, Trapezium
from electrovib.physics.drive.levels import LEVELS, SWING, LevelledDrive
from electrovib.physics.drive.sines import AmplitudeModulation, Burst, Chirp, Sine, SquareRootModulation

TIME = np.linspace(0, 0.05, 4001)[:-1]
RATE, DEPTH = 60.0, 0.6
REST = {
    Sine: {"frequency": RATE, "phase": 0.3},
    CurrentSine: {"frequency": RATE},
    Burst: {"frequency": RATE, "cycles": 2, "delay": 0.004},
    Chirp: {"first": 10, "last": 200, "length": 0.04},
    AmplitudeModulation: {"carrier": 300, "modulation": 20, "depth": DEPTH},
    SquareRootModulation: {"carrier": 300, "modulation": 20, "depth": DEPTH},
    Square: {"frequency": RATE},
    PulseTrain: {"frequency": RATE, "width": 0.004},
    Trapezium: {"delay": 0.001, "rise": 0.004, "hold": 0.005, "fall": 0.002, "repeat": 0.015},
}
CREST = {AmplitudeModulation: 1 + DEPTH, SquareRootModulation: np.sqrt(1 + DEPTH)}
PAIRS = "give amplitude and offset, or high and low"
NAMES = (*SWING, *LEVELS)
each_kind = pytest.mark.parametrize("kind", REST)


def scale(kind):
    return 1e-2 if kind is CurrentSine else 1.0


def build(kind, **pair):
    return read_model(kind, REST[kind] | {name: value * scale(kind) for name, value in pair.items()})


def tables(kind, amplitude, offset):
    """Give every table of one drive: with either pair, and with one parameter where the other has a default."""
    crest = CREST.get(kind, 1.0) * amplitude
    found = [{"amplitude": amplitude, "offset": offset}, {"high": offset + crest, "low": offset - crest}]
    if offset == 0:
        found.append({"amplitude": amplitude})
    if offset == amplitude and "high" in kind.model_fields:
        found.append({"high": 2 * amplitude})
    return found


def test_every_drive_with_an_amplitude_or_a_level_is_one_of_them():
    members = {kind for kind in find_members(Drive).values() if not kind.__module__.startswith("tests")}
    assert {kind for kind in members if issubclass(kind, LevelledDrive)} == set(REST)
    assert {"Step", "Offset", "Sum", "Sampled"} <= {kind.__name__ for kind in members - set(REST)}
    assert not any({*NAMES} & set(kind.model_fields) for kind in members - set(REST))


@each_kind
@pytest.mark.parametrize(("amplitude", "offset"), [(75, 0), (75, 75), (30, -12)])
def test_every_table_of_a_drive_is_the_drive_of_amplitude_1_scaled_and_shifted(kind, amplitude, offset):
    unit = build(kind, amplitude=1, offset=0).voltage(TIME)
    crest = CREST.get(kind, 1.0) * amplitude
    for pair in tables(kind, amplitude, offset):
        drive = build(kind, **pair)
        expected = offset * scale(kind) + amplitude * unit
        np.testing.assert_allclose(drive.voltage(TIME), expected, rtol=0, atol=1e-10 * scale(kind))
        read = [drive.amplitude, drive.offset, drive.high, drive.low]
        wanted = np.array([amplitude, offset, offset + crest, offset - crest]) * scale(kind)
        assert read == pytest.approx(wanted, abs=1e-12), pair
    lowest, highest = drive.extremes()
    assert highest == pytest.approx(drive.high, rel=1e-9)
    if kind in CREST:  # the carrier meets the crest of its envelope from above only
        assert drive.low <= lowest == pytest.approx(drive.low, rel=0.1, abs=1)
    else:
        assert lowest == pytest.approx(drive.low, rel=1e-9)


@each_kind
@pytest.mark.parametrize(
    ("change", "wanted"),
    [
        ({"amplitude": 50}, (50, 10)),
        ({"offset": -20}, (30, -20)),
        ({"amplitude": 50, "offset": -20}, (50, -20)),
        ({"high": 60, "low": 20}, (20, 40)),
        ({"high": 60}, (40, 20)),  # low stays at -20
        ({"low": 0}, (20, 20)),  # high stays at 40
    ],
)
def test_a_change_of_either_pair(kind, change, wanted):
    size, of_levels = scale(kind), not set(change) & set(SWING)
    drive = build(kind, high=40, low=-20) if of_levels else build(kind, amplitude=30, offset=10)
    amplitude = wanted[0] / CREST.get(kind, 1.0) if of_levels else wanted[0]
    given = {name: value * size for name, value in change.items()}
    unit = quantity_at(drive, "high").unit
    assert unit == ("A" if kind is CurrentSine else "V")
    shown = {name: format_quantity(value, unit, digits=12) for name, value in given.items()}
    for changes in (given, shown):
        changed = drive.replace(changes)
        expected = (amplitude * size, wanted[1] * size)
        assert (changed.amplitude, changed.offset) == pytest.approx(expected, abs=1e-12)
        assert changed == drive.replace(drive.stored(given))
    for name in NAMES:
        assert value_at(changed, name) == getattr(changed, name)
        assert quantity_at(changed, name) == (kind.derived.get(name) or quantity_of(kind, name))


@each_kind
@pytest.mark.parametrize("level", [75, 0, -75, 130])
def test_a_symmetric_drive_stays_symmetric(kind, level):
    """A fault of before: a square of 100 V about 0 V, set to high = 75 V, kept low = -100 V."""
    drive, level = build(kind, high=100, low=-100), level * scale(kind)
    for change in [{"high": level}, {"low": -level}] if level else [{"high": level}]:
        if level < 0 and "amplitude" in kind.model_fields:
            with pytest.raises(InputError, match="must not be below low"):
                drive.replace(change)
        else:
            changed = drive.replace(change)
            assert (changed.high, changed.low) == pytest.approx((level, -level), abs=1e-12)
    told = r"low = 0: high is -low in this drive.*give 'high' as well, for instance high = 1"
    with pytest.raises(InputError, match=told):
        drive.replace({"low": 0})
    both = drive.replace({"low": 0, "high": abs(level)})
    assert (both.high, both.low) == pytest.approx((abs(level), 0), abs=1e-12)


def test_what_is_set_in_a_drive_that_is_off_or_begins_at_0():
    off = build(Square, high=0, low=0).replace({"high": 75})
    assert (off.high, off.low) == (75, 0)  # switched on as a table would
    off = build(Sine, amplitude=0).replace({"high": 75})
    assert (off.amplitude, off.offset) == (75, 0)
    assert build(Trapezium, high=1000).replace({"high": 500}) == build(Trapezium, high=500, low=0)
    assert build(PulseTrain, high=100).replace({"low": -100}) == build(PulseTrain, high=100, low=-100)
    deeper = build(AmplitudeModulation, amplitude=100).replace({"high": 100, "depth": 1})
    assert (deeper.amplitude, deeper.high, deeper.low) == (50, 100, -100)


@each_kind
def test_what_is_refused(kind):
    rest, size = REST[kind], scale(kind)

    def refused(given, match, read=lambda given: read_model(kind, rest | given)):
        with pytest.raises(InputError, match=match):
            read(given)

    for swing, level in itertools.product(SWING, LEVELS):
        mixed, said = (
            {swing: 50 * size, level: 20 * size},
            f"is given beside '{swing}', of the other pair; {PAIRS}",
        )
        refused(mixed, f"{level}.*: {said}")
        refused(mixed, f"{level}: {said}", build(kind, amplitude=1).replace)
    if "amplitude" in kind.model_fields:
        instance = "for instance low = -1 for a drive symmetric about 0"
        refused({"high": 1}, f"^high = 1: needs 'low' beside it, {instance}; {PAIRS}$")
        refused({"low": -1}, f"low = -1: needs 'high' beside it; {PAIRS}")
        refused({"high": 1, "low": 2}, "high = 1: must not be below low, which is 2")
    else:
        refused({"offset": 1}, f"offset = 1: needs 'amplitude' beside it; {PAIRS}")
        refused({"low": 1}, r"high: missing: (high level|voltage of the hold)")
        inverted = build(kind, amplitude=-30, offset=10)
        assert (inverted.high, inverted.low) == (-20, 40)


def paths_told(call, given):
    with pytest.raises(InputError) as caught:
        call(given)
    return [problem.path for problem in caught.value.problems], caught.value.problems


@each_kind
def test_every_mistake_beside_a_pair_is_told(kind):
    first, second = [name for name in NAMES if name in kind.derived]
    wrong = {first: "2 mm", "extra": 1}
    paths, told = paths_told(lambda given: read_model(kind, REST[kind] | given), wrong | {second: 1e9})
    assert sorted(paths) == sorted([first, second, "extra"])
    assert "expected a " in next(each for each in told if each.path == first)
    assert next(each for each in told if each.path == "extra").startswith("extra: unknown parameter")
    assert paths_told(build(kind, amplitude=1).replace, wrong)[0] == [first, "extra"]
    assert paths_told(build(kind, high=100, low=-100).replace, {"high": "2 mm"})[0] == ["high"]


@pytest.mark.parametrize("depth", [{}, {"depth": "2 mm"}])
def test_a_modulation_without_a_valid_depth_says_so(depth):
    table = {"carrier": 300, "modulation": 20, "high": 100, "low": -100} | depth
    assert paths_told(lambda given: read_model(AmplitudeModulation, given), table)[0] == ["depth"]


def test_the_hash_of_older_files():
    """A sine without an offset has the hash that it had before there was one."""
    drive = build(Sine, amplitude=75)
    assert "offset" not in drive.canonical()
    assert drive.to_dict()["offset"] == 0
    assert "offset" in drive.replace({"offset": 1}).canonical()
    assert drive.replace({"offset": 1}) != drive
    command = read_model(CurrentAmplifier, {"command": drive, "sense_resistance": 1e4})
    assert "offset" not in command.canonical()
    assert "low" in build(Square, high=1).canonical()


def test_a_nearest_name_may_be_a_derived_one():
    with pytest.raises(InputError, match=r"unknown parameter 'hihg' of Sine. Did you mean 'high'"):
        read_model(Sine, {"amplitude": 1, "frequency": 50, "hihg": 3})
    with pytest.raises(InputError, match="unknown parameter 'high'"):
        read_model(Step, {"level": 1, "high": 3})
