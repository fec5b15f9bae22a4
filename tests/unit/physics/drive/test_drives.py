"""Drives where a formula is not enough: at jumps and ends, their periods, either pair of levels, what is refused.

Equations, slopes, shapes, NaN and sums of parts of every drive are held by tests/contract.
"""

import itertools
from types import SimpleNamespace

import numpy as np
import pytest

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.quantity import quantity_of
from electrovib.core.units import format_quantity
from electrovib.physics.drive.base import Drive, common_period
from electrovib.physics.drive.combined import Sum
from electrovib.physics.drive.current import CurrentAmplifier, CurrentSine
from electrovib.physics.drive.edges import PulseTrain, Square, Step, Trapezium
from electrovib.physics.drive.levels import LEVELS, SWING, LevelledDrive
from electrovib.physics.drive.parts import Smooth
from electrovib.physics.drive.sines import AmplitudeModulation, Burst, Chirp, Sine, SquareRootModulation
from electrovib.scenario import read_part

MEMBERS = find_members(Drive)
TIME = np.linspace(0, 0.05, 2003)
ROUNDING = 1e-12
SINE = {"model": "Sine", "amplitude": 3, "frequency": 50}
CURRENT = {"model": "CurrentSine", "amplitude": 1e-3, "frequency": 1e3}
ONCE = {"high": 10, "rise": 1, "hold": 1, "fall": 1}
FULL = {"high": 10, "rise": 0.1, "hold": 0.2, "fall": 0, "repeat": 0.3}


def at(drive, *times):
    return drive.voltage(np.array(times))


def test_a_step_and_a_square_have_the_level_after_a_jump():
    assert np.array_equal(at(Step(level=-5), -1e-12, 0, 1e9), [0, -5, -5])
    square = Square(high=10, low=-4, frequency=0.5)
    assert np.array_equal(at(square, 0, 0.5, 1, 1.5, 2, 2.5, 3), [10, 10, -4, -4, 10, 10, -4])
    pulses = PulseTrain(high=10, width=0.25, frequency=1)
    assert np.array_equal(at(pulses, 0, 0.2, 0.25, 0.9, 1.1), [10, 10, 0, 0, 10])
    always = PulseTrain(high=10, width=1, frequency=1)
    assert np.array_equal(at(always, 0, 0.5, 1.0, 1.5), [10, 10, 10, 10])


def test_a_trapezium_once_and_repeated():
    drive, again = Trapezium(high=10, low=2, delay=1, rise=2, hold=3, fall=4), Trapezium(**ONCE, repeat=5)
    assert at(drive, -1, 0, 1, 2, 3, 6, 8, 99) == pytest.approx([0, 2, 2, 6, 10, 10, 6, 2], abs=1e-14)
    assert (drive.period, drive.duration) == (None, 13)
    assert again.period == again.duration == 5


@pytest.mark.parametrize("edges", [(0, 0.01), (0.01, 0), (0, 0)])
def test_a_trapezium_with_jumps(edges):
    drive = Trapezium(high=10, rise=edges[0], hold=1, fall=edges[1], delay=1)
    assert at(drive, 1 - 1e-9, 1 + edges[0], 1 + edges[0] + 1 - 1e-9, 2.02) == pytest.approx([0, 10, 10, 0])


def test_times_that_fill_the_period_but_for_rounding():
    """0.1 + 0.2 is above 0.3 by a rounding, and still fits."""
    drive = Trapezium(**FULL)
    (part,) = drive.parts()
    assert part.times[-1] == 0.3
    assert np.all(np.diff(part.times) > 1e-3)
    assert at(drive, 0.05, 0.1, 0.29999, 0.35) == pytest.approx([5, 10, 10, 5])
    third = 1 / 3
    pulses = PulseTrain(high=10, width=2 * third, frequency=1, edge=1 - 2 * third)
    assert pulses.parts()[0].times[-1] == 1
    triangle = Square(high=10, frequency=300, edge=1 / 600 * (1 + 1e-15))
    assert triangle.parts()[0].times == pytest.approx([0, 1 / 600, 1 / 300], rel=1e-15)


@pytest.mark.parametrize("cycles", [1, 7])
def test_a_burst_begins_and_ends_at_0_volts(cycles):
    drive = Burst(amplitude=100, frequency=250, cycles=cycles, delay=3.3e-3)
    (part,) = drive.parts()
    assert part.stop - part.start == pytest.approx(cycles / 250, rel=1e-14)
    ends = np.array([part.start, np.nextafter(part.stop, 0), part.stop])
    assert np.max(np.abs(drive.voltage(ends))) < 1e-10 * 100  # phase of 3 ms and seven cycles, rounded
    assert np.all(drive.voltage([0, 3.2e-3, part.stop + 1e-9, 1.0]) == 0)
    assert drive.period is None


@pytest.mark.parametrize("depth", [0.1, 0.99, 1])
@pytest.mark.parametrize(("carrier", "modulation"), [(3000, 100), (100, 250), (250, 250)])
def test_the_square_of_a_root_modulation(carrier, modulation, depth):
    """It is (1 + m cos) times the square of the carrier, and the sum of tones has no negative frequency."""
    content = {"amplitude": 10, "carrier": carrier, "modulation": modulation, "depth": depth}
    root = SquareRootModulation(**content)
    envelope = 1 + depth * np.cos(2 * np.pi * modulation * TIME)
    square = envelope * (10 * np.cos(2 * np.pi * carrier * TIME)) ** 2
    assert np.max(np.abs(root.voltage(TIME) ** 2 - square)) < ROUNDING * 200
    parts = [*root.parts(), *AmplitudeModulation(**content).parts()]
    assert all(np.all(part.frequencies >= 0) for part in parts)


def test_a_chirp_knows_its_highest_frequency():
    for first, last in ((10, 1000), (1000, 10), (0, 300)):
        (part,) = Chirp(amplitude=5, first=first, last=last, length=0.04).parts()
        assert part.highest_frequency == max(first, last)


@pytest.mark.parametrize(
    ("periods", "expected"),
    [
        ([], None),
        ([1 / 60, 1 / 50], 0.1),
        ([0.3, 0.2, 0.5], 3.0),
        ([1 / 30_000, 1 / 7], 1.0),
        ([1 / 50, 1 / 49.99], 100.0),
        ([1.0, np.sqrt(2)], None),
    ],
)
def test_common_period(periods, expected):
    found = common_period(periods)
    assert found == (None if expected is None else pytest.approx(expected, rel=1e-9))


@pytest.mark.parametrize(
    ("others", "period"),
    [
        ([SINE | {"frequency": 75}], 0.04),
        ([{"model": "Square", "high": 1, "frequency": 20}], 0.1),
        ([{"model": "Step", "level": 5}, SINE | {"frequency": 25}], 0.04),
        ([{"model": "Burst", "amplitude": 1, "frequency": 25, "cycles": 1}], None),
        ([{"model": "Trapezium", **ONCE}], None),
        ([SINE | {"frequency": 50 * np.sqrt(3)}], None),
    ],
)
def test_the_period_of_a_sum(others, period):
    found = Sum(drives=[SINE, *others]).period
    assert found == (None if period is None else pytest.approx(period, rel=1e-12))


def test_a_sum_of_constants_has_no_period_and_one_of_sines_lasts_as_the_longest():
    constants = Sum(drives=[Step(level=5), Step(level=-2)])
    assert constants.period is None
    assert np.all(constants.voltage(TIME) == 3)
    assert Sum(drives=[SINE, Step(level=1), SINE | {"frequency": 10}]).duration == 0.5


def test_periods_of_modulations():
    content = {"amplitude": 1, "carrier": 3000, "modulation": 70, "depth": 0.5}
    assert AmplitudeModulation(**content).period == pytest.approx(0.1, rel=1e-12)
    assert SquareRootModulation(**content).period == pytest.approx(0.1, rel=1e-12)
    # the smooth branch of the root has half the frequency
    assert SquareRootModulation(**content | {"depth": 1}).period == pytest.approx(0.2, rel=1e-12)
    assert AmplitudeModulation(**content | {"carrier": 1000 * np.sqrt(2)}).period is None


def test_durations():
    assert Drive.duration.fget(SimpleNamespace(period=0.02)) == 0.1  # five periods
    with pytest.raises(NotImplementedError, match="SimpleNamespace does not repeat"):
        Drive.duration.fget(SimpleNamespace(period=None))
    for name, kind in MEMBERS.items():
        drive = read_model(kind, kind.example)
        assert 0 < drive.duration < 1e3, name
        assert np.ptp(drive.voltage(np.linspace(-1e-9, drive.duration, 999))) > 0, name
        if drive.period is None:  # off before time 0
            assert drive.voltage(-1e-3) == drive.slope(-1e-3) == 0, name


def test_a_drive_is_of_voltages_or_of_currents_and_an_amplifier_keeps_the_time_of_its_command():
    sine, same = CurrentSine(amplitude=1e-3, frequency=2e3), Sine(amplitude=1e-3, frequency=2e3)
    assert (sine.quantity, same.quantity) == ("current", "voltage")
    assert (sine.period, sine.duration) == (same.period, same.duration)
    for kind in MEMBERS.values():
        if kind.quantity == "voltage":
            command = read_model(kind, dict(kind.example))
            drive = CurrentAmplifier(command=command, sense_resistance=2e4)
            assert (drive.period, drive.duration) == (command.period, command.duration)
            np.testing.assert_array_equal(drive.time_stamps, command.time_stamps)
    assert {kind.quantity for kind in MEMBERS.values()} == {"voltage", "current"}


def held(edge, times=(0, 1, 2, 5), volts=(1, 10, 4, 0)):
    samples = {"model": "Sampled", "time_samples": list(times), "voltage_samples": list(volts)}
    return read_part(Drive, {"model": "Held", "samples": samples, "edge": edge})


@pytest.mark.parametrize(
    ("edge", "ends", "volts"),
    [
        (0, 5, [1, 1, 1, 10, 10, 10, 4, 4, 4, 0]),
        (0.4, 5.4, [0, 0.5, 1, 1, 5.5, 10, 10, 4, 4, 2]),
        (1, 6, [0, 0.2, 0.9, 1, 2.8, 9.1, 10, 4, 4, 3.2]),
    ],
)
def test_held_samples_and_their_edges(edge, ends, volts):
    drive = held(edge)
    assert at(drive, 0, 0.2, 0.9, 1, 1.2, 1.9, 2, 3, 4.99, 5.2) == pytest.approx(volts, rel=1e-12)
    assert drive.duration == pytest.approx(ends)
    assert (drive.largest(), drive.voltage(6.0)) == (10, 0)


def test_an_edge_of_one_interval_is_a_line_one_interval_later():
    times = np.arange(1000) * 1.7e-5  # not representable: an edge ends where the next begins, to the rounding
    volts = np.sin(np.arange(1000))
    drive = held(float(np.min(np.diff(times))), times, volts)
    moments = np.linspace(1e-4, 0.0169, 5003)
    np.testing.assert_allclose(drive.voltage(moments), np.interp(moments - 1.7e-5, times, volts), atol=1e-8)
    assert len(drive.parts()[0].times) == 1001
    with pytest.raises(InputError, match=r"edge of 1\.1 s is longer than the shortest interval .*, 1 s"):
        held(1.1)


@pytest.mark.parametrize(
    ("kind", "content", "why"),
    [
        ("Trapezium", FULL | {"repeat": 0.3 * (1 - 1e-9)}, "repeat must be at least"),
        ("Trapezium", ONCE | {"repeat": 2}, "at least .* = 3 s"),
        ("Square", {"high": 1, "frequency": 50, "edge": 0.011}, "half a period, 0.01 s"),
        ("PulseTrain", {"high": 1, "width": 1e-3, "frequency": 50, "edge": 2e-3}, "edge <= width"),
        ("PulseTrain", {"high": 1, "width": 0.019, "frequency": 50, "edge": 2e-3}, "width . edge <= period"),
        ("Square", {"high": 1, "frequency": 0}, "frequency = 0: must lie between 1 mHz and 100 MHz"),
        ("Step", {"level": float("nan")}, "must be a finite number"),
        ("Burst", {"amplitude": 1, "frequency": 50, "cycles": 0}, "cycles must be a whole number"),
        ("Burst", {"amplitude": 1, "frequency": 50, "cycles": 2.5}, "cycles"),
        ("AmplitudeModulation", {"carrier": 50, "modulation": 5, "depth": 1.1}, "between 0 and 1"),
        ("Sine", {"amplitude": -1, "frequency": 50}, "amplitude = -1"),
        ("CurrentSine", {"amplitude": "1 V", "frequency": 50}, "expected a current"),
        ("Sum", {"drives": [SINE, CURRENT]}, "CurrentAmplifier"),
        ("Offset", {"level": 1, "drive": CURRENT}, "CurrentAmplifier"),
        ("CurrentAmplifier", {"sense_resistance": 1e3, "command": CURRENT}, "CurrentAmplifier"),
    ],
)
def test_what_is_no_drive_is_refused(kind, content, why):
    with pytest.raises(InputError, match=why):
        read_model(Drive, {"model": kind} | content)


EVEN = np.linspace(0, 0.05, 4001)[:-1]
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
WAVE = Smooth(lambda time: np.cos(9 * time), lambda time: -9 * np.sin(9 * time), 0.0, 0.04, 9 / (2 * np.pi))


@pytest.mark.parametrize(
    "part",
    [
        *(
            one
            for each in MEMBERS.values()
            for one in read_model(Drive, {"model": each.__name__} | dict(each.example)).parts()
        ),
        WAVE,
    ],
)
def test_a_part_is_proportional_to_its_levels(part):
    triple = part.with_levels(-3 * part.levels)
    assert type(triple) is type(part)
    assert all(map(np.array_equal, triple.timing[1:], part.timing[1:]))
    for mine, its in (
        (triple.value, part.value),
        (triple.slope, part.slope),
        (triple.value_before, part.value_before),
    ):
        np.testing.assert_allclose(mine(TIME[1:]), -3 * its(TIME[1:]), rtol=1e-12, atol=1e-12 * part.bound())
    assert triple.bound() == pytest.approx(3 * part.bound(), rel=1e-12)


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
    unit = build(kind, amplitude=1, offset=0).voltage(EVEN)
    crest = CREST.get(kind, 1.0) * amplitude
    for pair in tables(kind, amplitude, offset):
        drive = build(kind, **pair)
        expected = offset * scale(kind) + amplitude * unit
        np.testing.assert_allclose(drive.voltage(EVEN), expected, rtol=0, atol=1e-10 * scale(kind))
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
