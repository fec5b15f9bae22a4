"""Amplitude and offset, or high and low: every drive between two levels takes either pair and gives both."""

from __future__ import annotations

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


def turns(count):
    return 2 * np.pi * count * TIME


def square_wave(share):
    return np.where(share > (TIME * RATE) % 1, 1.0, -1.0)


WAVES = {
    Sine: lambda: np.sin(turns(RATE) + 0.3),
    CurrentSine: lambda: np.sin(turns(RATE)),
    Burst: lambda: np.where((TIME >= 0.004) & (TIME < 0.004 + 2 / RATE), np.sin(turns(RATE) - 2 * np.pi * RATE * 0.004), 0),
    Chirp: lambda: np.where(TIME < 0.04, np.sin(2 * np.pi * (10 * TIME + 190 / 0.04 * TIME**2 / 2)), 0),
    AmplitudeModulation: lambda: (1 + DEPTH * np.cos(turns(20))) * np.cos(turns(300)),
    SquareRootModulation: lambda: np.sqrt(1 + DEPTH * np.cos(turns(20))) * np.cos(turns(300)),
    Square: lambda: square_wave(0.5),
    PulseTrain: lambda: square_wave(0.004 * RATE),
    Trapezium: lambda: np.interp(TIME % 0.015, [0.001, 0.005, 0.01, 0.012], [-1, 1, 1, -1]),
}  # fmt: skip
"""Each of amplitude 1 about 0, in closed form."""
KINDS = list(REST)


def scale(kind):
    return 1e-2 if kind is CurrentSine else 1.0


def build(kind, **pair):
    return read_model(kind, REST[kind] | {name: value * scale(kind) for name, value in pair.items()})


def tables(kind, amplitude, offset):
    """Give every table of one drive: with either pair, and with one parameter where the other has a default."""
    crest = CREST.get(kind, 1.0)
    found = [
        {"amplitude": amplitude, "offset": offset},
        {"high": offset + crest * amplitude, "low": offset - crest * amplitude},
    ]
    if offset == 0:
        found.append({"amplitude": amplitude})
    if offset == amplitude and "high" in kind.model_fields:
        found.append({"high": 2 * amplitude})
    return found


def test_every_drive_with_an_amplitude_or_a_level_is_one_of_them():
    members = {kind for kind in find_members(Drive).values() if not kind.__module__.startswith("tests")}
    assert {kind for kind in members if issubclass(kind, LevelledDrive)} == set(KINDS)
    others = {kind.__name__ for kind in members} - {kind.__name__ for kind in KINDS}
    assert {"Step", "Offset", "Sum", "Sampled", "CurrentAmplifier"} <= others
    for kind in members - set(KINDS):
        assert not {*SWING, *LEVELS} & set(kind.model_fields)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("amplitude", "offset"), [(75, 0), (75, 75), (30, -12)])
def test_every_table_of_a_drive_gives_the_closed_form(kind, amplitude, offset):
    expected = (offset + amplitude * WAVES[kind]()) * scale(kind)
    away = np.ones(len(TIME), bool)
    if kind in (Square, PulseTrain):  # the closed form's own edges are rounded
        away = np.abs(np.diff(WAVES[kind](), append=1.0)) + np.abs(np.diff(WAVES[kind](), prepend=1.0)) == 0
    crest = CREST.get(kind, 1.0)
    for pair in tables(kind, amplitude, offset):
        drive = build(kind, **pair)
        error = np.abs(drive.voltage(TIME) - expected)[away]
        assert np.max(error) < 1e-9 * 150 * scale(kind), pair
        read = [drive.amplitude, drive.offset, drive.high, drive.low]
        wanted = [amplitude, offset, offset + crest * amplitude, offset - crest * amplitude]
        assert read == pytest.approx(np.array(wanted) * scale(kind), abs=1e-12)


@pytest.mark.parametrize("kind", KINDS)
def test_high_and_low_are_the_extremes(kind):
    lowest, highest = build(kind, amplitude=30, offset=50).extremes()
    drive = build(kind, amplitude=30, offset=50)
    assert highest == pytest.approx(drive.high, rel=1e-9)
    if kind in CREST:  # the carrier meets the crest of its envelope from above only
        assert lowest == pytest.approx(drive.low, rel=0.1, abs=1)
        assert lowest >= drive.low
    else:
        assert lowest == pytest.approx(drive.low, rel=1e-9)


@pytest.mark.parametrize("kind", KINDS)
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
    crest, size = CREST.get(kind, 1.0), scale(kind)
    drive = (
        build(kind, high=40, low=-20)
        if "high" in change or "low" in change
        else build(kind, amplitude=30, offset=10)
    )
    amplitude = wanted[0] / crest if "high" in change or "low" in change else wanted[0]
    for written in (float, lambda value: format_quantity(value, quantity_at(drive, "high").unit, digits=12)):
        changed = drive.replace({name: written(value * size) for name, value in change.items()})
        assert (changed.amplitude, changed.offset) == pytest.approx(
            (amplitude * size, wanted[1] * size), abs=1e-12
        )
        assert changed == drive.replace(drive.stored({name: value * size for name, value in change.items()}))
    for name in (*SWING, *LEVELS):
        assert value_at(changed, name) == getattr(changed, name)
        declared = quantity_at(changed, name)
        assert declared.unit == ("A" if kind is CurrentSine else "V")
        assert declared == (kind.derived.get(name) or quantity_of(kind, name))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("level", [75, 0, -75, 130])
def test_a_symmetric_drive_stays_symmetric(kind, level):
    """Today's fault: a square of 100 V about 0 V, set to high = 75 V, kept low = -100 V."""
    drive, level = build(kind, high=100, low=-100), level * scale(kind)
    changes = [{"high": level}] if level == 0 else [{"high": level}, {"low": -level}]
    for change in changes:
        if level < 0 and "amplitude" in kind.model_fields:
            with pytest.raises(InputError, match="must not be below low"):
                drive.replace(change)
            continue
        changed = drive.replace(change)
        assert (changed.high, changed.low) == pytest.approx((level, -level), abs=1e-12)
    with pytest.raises(
        InputError, match=r"low = 0: high is -low in this drive.*give 'high' as well, for instance high = 1"
    ):
        drive.replace({"low": 0})
    both = drive.replace({"low": 0, "high": abs(level)})
    assert (both.high, both.low) == pytest.approx((abs(level), 0), abs=1e-12)


def test_a_drive_that_is_off_is_switched_on_as_a_table_would():
    off = build(Square, high=0, low=0).replace({"high": 75})
    assert (off.high, off.low) == (75, 0)
    off = build(Sine, amplitude=0).replace({"high": 75})
    assert (off.amplitude, off.offset) == (75, 0)


def test_pulses_from_0_keep_their_low_level():
    assert build(Trapezium, high=1000).replace({"high": 500}) == build(Trapezium, high=500, low=0)
    assert build(PulseTrain, high=100).replace({"low": -100}) == build(PulseTrain, high=100, low=-100)


@pytest.mark.parametrize("kind", KINDS)
def test_what_is_refused(kind):
    pairs = "give amplitude and offset, or high and low"
    size, rest = scale(kind), REST[kind]
    for swing, level in itertools.product(SWING, LEVELS):
        mixed = {swing: 50 * size, level: 20 * size}
        with pytest.raises(
            InputError, match=f"{level}.*: is given beside '{swing}', of the other pair; {pairs}"
        ):
            read_model(kind, rest | mixed)
        with pytest.raises(
            InputError, match=f"{level}: is given beside '{swing}', of the other pair; {pairs}"
        ):
            build(kind, amplitude=1).replace(mixed)
    if "amplitude" in kind.model_fields:
        with pytest.raises(InputError) as caught:
            read_model(kind, rest | {"high": 1})
        said = (
            f"high = 1: needs 'low' beside it, for instance low = -1 for a drive symmetric about 0; {pairs}"
        )
        assert str(caught.value) == said
        with pytest.raises(InputError, match=f"low = -1: needs 'high' beside it; {pairs}"):
            read_model(kind, rest | {"low": -1})
        with pytest.raises(InputError, match="high = 1: must not be below low, which is 2"):
            read_model(kind, rest | {"high": 1, "low": 2})
    else:
        with pytest.raises(InputError, match=f"offset = 1: needs 'amplitude' beside it; {pairs}"):
            read_model(kind, rest | {"offset": 1})
        with pytest.raises(InputError, match=r"high: missing: (high level|voltage of the hold)"):
            read_model(kind, rest | {"low": 1})
        inverted = build(kind, amplitude=-30, offset=10)
        assert (inverted.high, inverted.low) == (-20, 40)


@pytest.mark.parametrize("kind", KINDS)
def test_every_mistake_beside_a_pair_is_told(kind):
    first, second = [name for name in (*SWING, *LEVELS) if name in kind.derived]
    wrong = "2 mm"
    with pytest.raises(InputError) as caught:
        read_model(kind, REST[kind] | {first: wrong, second: 1e9, "extra": 1})
    assert [problem.path for problem in caught.value.problems] == [first, second, "extra"]
    assert "expected a " in caught.value.problems[0]
    assert caught.value.problems[2].startswith("extra: unknown parameter")
    with pytest.raises(InputError) as caught:
        build(kind, amplitude=1).replace({first: wrong, "extra": 1})
    assert [problem.path for problem in caught.value.problems] == [first, "extra"]
    with pytest.raises(InputError) as caught:
        build(kind, high=100, low=-100).replace({"high": wrong})
    assert [problem.path for problem in caught.value.problems] == ["high"]


def test_a_modulation_without_a_valid_depth_says_so():
    for depth in ({}, {"depth": "2 mm"}):
        table = {name: value for name, value in REST[AmplitudeModulation].items() if name != "depth"} | depth
        with pytest.raises(InputError) as caught:
            read_model(AmplitudeModulation, table | {"high": 100, "low": -100})
        assert [problem.path for problem in caught.value.problems] == ["depth"]


def test_a_new_depth_counts_for_the_level_that_is_set_with_it():
    drive = build(AmplitudeModulation, amplitude=100).replace({"high": 100, "depth": 1})
    assert (drive.amplitude, drive.high, drive.low) == (50, 100, -100)


def test_the_offset_of_the_hash_is_that_of_older_files():
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
