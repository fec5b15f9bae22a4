"""Swipes of known friction through offsets, drifts, wraps and rates; and recordings that are none."""

import json
import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.rig import TribometerChannels
from electrovib.recordings.recording import calibrated, read_recording
from electrovib.recordings.swipe.reduce import (
    block_means,
    over_baselines,
    reduce_swipe,
    reduce_swipes,
    standard_error,
)

STEP = 0.5e-6


def channels(rate=2000.0, normal=-0.31, lateral=0.444, *, encoder=4, **changes):
    content = {
        "normal": {"column": 1, "sensitivity": normal},
        "lateral": {"column": 0, "sensitivity": lateral},
        "encoder": {"column": encoder, "step": STEP},
        "clock": {"model": "EvenSamples", "rate": rate},
    }
    content |= changes
    if encoder is None:
        del content["encoder"]
    return read_model(TribometerChannels, content)


def swiped(columns, **known):
    return reduce_swipe(calibrated(columns, channels(**known)))


def near(friction, rel=5e-3):
    return pytest.approx(friction, rel=rel)


SENSORS = {"normal": -0.31, "lateral": 0.444, "zeros": (5.4, -0.3), "drifts": (0.0, 0.0), "noise": 2e-3}
FINGER = {"load": 0.5, "friction": 0.4, "touch": (2.0, 6.0), "slide": (3.0, 5.0), "distance": 80e-3}
RIG = {"rate": 2000.0, "direction": 1, "register": 2**32, "start": 0, "stride": 1.0, "seed": 0}


def made(**changes):
    """Make the columns of a swipe [V, V, 1] of a finger that presses, slides and leaves.

    `stride` stretches the whole experiment in time; drifts are in N/s of that time.
    """
    of = SimpleNamespace(**SENSORS | FINGER | RIG | changes)
    random = np.random.default_rng(of.seed)
    time = np.arange(round(8.0 * of.stride * of.rate)) / of.rate
    at = time / of.stride
    begin, end = of.touch
    pressed = of.load * np.interp(at, [begin - 0.1, begin, end, end + 0.1], [0, 1, 1, 0])
    position = of.direction * np.interp(at, of.slide, [0, of.distance])
    begin, end = of.slide
    moving = np.interp(at, [begin, begin + 0.02, end, end + 0.02], [0, 1, 1, 0])
    pulled = of.direction * of.friction * pressed * moving
    wobble = of.noise * random.standard_normal((2, len(time)))
    return {
        "normal": (pressed + of.drifts[0] * at + wobble[0]) / of.normal + of.zeros[0],
        "lateral": (pulled + of.drifts[1] * at + wobble[1]) / of.lateral + of.zeros[1],
        "encoder": (of.start + np.rint(position / STEP)) % of.register,
    }


@pytest.mark.slow
@given(
    rate=st.sampled_from([500.0, 1000.0, 3210.0, 10_000.0]),
    load=st.floats(0.1, 3.0),
    friction=st.floats(0.05, 2.0),
    direction=st.sampled_from([1, -1]),
    zeros=st.tuples(st.floats(-8, 8), st.floats(-8, 8)),
    drifts=st.tuples(st.floats(-0.004, 0.004), st.floats(-0.02, 0.02)),
    signs=st.tuples(st.sampled_from([1, -1]), st.sampled_from([1, -1])),
    register=st.sampled_from([2**31, 2**32]),
    start=st.integers(0, 2**31),
    stride=st.sampled_from([0.6, 1.0, 1.7]),
    seed=st.integers(0, 2**32 - 1),
)
@settings(deadline=None, max_examples=60)
def test_known_friction_lies_in_the_stated_interval(signs, seed, **swipe):
    """With zeros that drift proportionally to time, either sign, either direction, any rate, the line returns the friction."""
    sensitivities = {"normal": signs[0] * 0.31, "lateral": signs[1] * 0.444}
    columns = made(seed=seed, **sensitivities, **swipe)
    found = reduce_swipe(calibrated(columns, channels(swipe["rate"], **sensitivities)))
    low, high = found.friction.ends
    # ten blocks put a mean outside of the stated 2.26 standard errors one time in twenty (Student's t, 9 degrees
    # of freedom) where no drift widens the interval; beyond ten it is one in 500 000
    more = 8 * found.friction.standard_error
    assert low - more <= swipe["friction"] <= high + more
    assert found.friction.value == pytest.approx(swipe["friction"], abs=10 * found.friction.standard_error)
    normal = found.normal_force
    assert normal.value == pytest.approx(swipe["load"], abs=10 * normal.standard_error)
    # and the error is small: 2 mN over 200 samples or more, three times, of which 10 standard errors
    assert found.friction.standard_error < 1e-3 * (1 + swipe["friction"]) / swipe["load"]
    assert found.direction == swipe["direction"]
    assert found.distance == pytest.approx(80e-3, rel=0.02)
    assert found.speed == pytest.approx(40e-3 / swipe["stride"], rel=1e-3)


def test_the_interval_is_as_wide_as_noise_drift_and_choice_ask_for():
    low, high = swiped(made()).friction.ends
    assert low < 0.4 < high
    # 2 mN over 3600 samples of 0.2 and 0.5 N, and over the baselines: 1e-4 each
    assert high - low < 2e-3
    # 0.5 N on a zero that moves by up to 1.2 N: the line is right, and little is known
    for drift in (0.05, -0.05, 0.15):
        found = swiped(made(drifts=(drift, 0.1)))
        assert found.friction.value == pytest.approx(0.4, abs=10 * found.friction.standard_error)
        assert np.ptp(found.friction.ends) > 0.5
    columns = made()  # a drift that is not in proportion to time is within the choices of the baseline
    columns["lateral"] += 0.1 / 0.444 * np.clip((np.arange(16_000) / 2000 - 4.8) / 0.1, 0, 1)
    found = swiped(columns)
    low, high = found.friction.choice_ends
    assert found.friction.value != near(0.4, rel=0.05)
    assert low < 0.4 < high


def test_the_interval_of_a_mean_of_ten_parts_holds_it_in_95_of_100():
    """White noise in one window and no choice of the baseline, which would widen the interval."""
    noise, inside = np.random.default_rng(1).standard_normal((2000, 20)), 0
    for values in noise:
        error = standard_error(block_means(values, (0, 20)))
        low, high = over_baselines({"mean": float(values.mean())}, "mean", error).ends
        inside += low <= 0 <= high
    assert inside / 2000 == pytest.approx(0.95, abs=0.0146)  # three standard deviations of the count
    # the deviation from a mean that is itself estimated, by hand: sqrt(sum of squares/(9 times 10))
    assert standard_error(np.arange(10.0)) == pytest.approx(math.sqrt(82.5 / 90))


@pytest.mark.parametrize(("missing", "left"), [("before", "after"), ("after", "before")])
def test_one_baseline_is_enough_and_said(missing, left):
    columns = made()
    part = slice(5000, None) if missing == "before" else slice(0, 11_500)
    found = swiped({name: values[part] for name, values in columns.items()})
    assert list(found.friction.choices) == [left]
    assert found.friction.value == near(0.4, rel=1e-2)
    assert any("their drift is unknown" in word for word in found.remarks)


def pressed_by(load, *, friction=0.4, position=None):
    """Make the columns of a finger that presses with any load over time and rubs over any distance."""
    time = np.arange(16_000) / 2000
    position = np.interp(time, [3, 5], [0, 80e-3]) if position is None else position(time)
    pressed = load(time)
    noise = 2e-3 * np.random.default_rng(0).standard_normal((2, len(time)))
    moving = np.sign(np.round(np.gradient(position, time), 6))
    return {
        "normal": (pressed + noise[0]) / -0.31 + 5.0,
        "lateral": (friction * pressed * moving + noise[1]) / 0.444,
        "encoder": np.rint(position / STEP) % 2**32,
    }


@pytest.mark.parametrize(
    "load",
    [
        lambda time: 0.5 * np.interp(time, [1, 2, 6, 7.5], [0, 1, 1, 0]) + 0.05 * time,
        lambda time: 0.5 * np.interp(time, [1.9, 2, 6, 6.1], [0, 1, 1, 0]) * (1 + 0.5 * np.sin(9 * time)),
        lambda time: 0.5 * np.interp(time, [1, 4, 7], [0, 1, 0]),
        lambda time: 0.5 * np.interp(time, [6.9, 7], [1, 0]),
        lambda time: 0.5 * np.interp(time, [0.3, 0.4, 7.6, 7.7], [0, 1, 1, 0]),
        lambda time: 0.5 * ((time > 1) & (time < 7) & (np.abs(time - 2.5) > 0.12)),
    ],
    ids=["slow", "wobbling", "triangle", "from the beginning", "nearly always", "back at once"],
)
def test_any_load_over_time(load):
    drift = 0.05 if load(np.array([0.0, 8.0]))[1] > 0.3 else 0.0
    columns = pressed_by(lambda time: load(time) - drift * time)
    columns["normal"] += drift * np.arange(16_000) / 2000 / -0.31
    found = swiped(columns)
    assert found.friction.value == pytest.approx(0.4, abs=10 * found.friction.standard_error)
    assert found.friction.standard_error < 2e-3
    if load(np.array([2.5]))[0] == 0:  # it has the zeros of its neighbours
        assert set(found.friction.choices) == {"before", "after", "mean", "interpolated"}


def test_several_swipes_there_and_back_and_in_one_contact():
    there, back = made(), made(direction=-1, friction=0.6, distance=40e-3)
    columns = {name: np.concatenate([there[name], back[name]]) for name in there}
    columns["encoder"][16_000:] += columns["encoder"][15_999] - columns["encoder"][16_000]
    columns["encoder"] %= 2**32
    found = reduce_swipes(calibrated(columns, channels()))
    assert [swipe.direction for swipe in found] == [1, -1]
    assert [swipe.friction.value for swipe in found] == near([0.4, 0.6], rel=1e-2)
    assert "The recording holds 2 swipes." in found[0].remarks
    assert swiped(columns).direction == 1
    columns = pressed_by(
        lambda time: 0.5 * ((time > 2) & (time < 6)),
        position=lambda time: np.interp(time, [2.5, 3.5, 4.5, 5.5], [0, 0.04, 0.04, 0]),
    )
    found = reduce_swipes(calibrated(columns, channels()))
    assert [swipe.direction for swipe in found] == [1, -1]
    assert [swipe.friction.value for swipe in found] == near([0.4, 0.4])


def test_wrong_counts_spikes_and_a_motion_without_contact_do_no_harm():
    columns = made()
    columns["encoder"][[7000, 9000]] = [10_000, 0]
    columns["normal"][[100, 9000]] = [-9, 9]
    columns["lateral"][1000] = 50
    assert swiped(columns).friction.value == near(0.4)
    columns, time = made(), np.arange(16_000) / 2000
    # a carriage that goes back before the finger comes, as rigs do
    columns["encoder"] = (columns["encoder"] + np.rint(np.interp(time, [0.2, 1.5], [0.08, 0]) / STEP)) % 2**32
    (found,) = reduce_swipes(calibrated(columns, channels()))
    assert 3 < found.window[0] < found.window[1] < 5


def test_a_measurement_is_a_trace(tmp_path):
    found = swiped(made(drifts=(0.0, 0.01)))
    inside = found.trace.sel(time=slice(*found.window))
    assert float(inside.lateral_force_measured.mean()) == pytest.approx(found.lateral_force.value, rel=1e-6)
    assert float(inside.normal_force_measured.mean()) == pytest.approx(found.normal_force.value, rel=1e-6)
    assert float(inside.sliding_speed.mean()) == pytest.approx(40e-3, rel=1e-3)
    assert found.trace.normal_force_measured.attrs["units"] == "N"
    ev.save(found.trace, tmp_path / "swipe.nc")
    stored = json.loads(found.trace.attrs["swipe"])
    assert stored["friction"] == json.loads(json.dumps(found.to_dict()))["friction"]


def test_the_time_is_that_of_stamps_which_increase(tmp_path):
    columns = made(rate=500.0)
    time = np.arange(4000) * 2 + np.random.default_rng(0).uniform(-0.3, 0.3, 4000)
    table = np.column_stack([time, *columns.values()])
    table[:, 2] *= 1e3
    heading = "time [ms],normal [V],lateral [mV],encoder"
    np.savetxt(tmp_path / "swipe.csv", table, delimiter=",", header=heading, comments="", fmt="%.10g")
    rig = channels(encoder="encoder", clock={"model": "TimeColumn", "column": "time"})
    rig = rig.replace({"normal.column": "normal", "lateral.column": "lateral"})
    assert reduce_swipe(read_recording(tmp_path / "swipe.csv", rig)).friction.value == near(0.4, rel=1e-2)
    columns["time"] = np.arange(4000) / 500
    columns = {name: np.repeat(values, 2) for name, values in columns.items()}
    with pytest.raises(InputError, match="4000 of 8000 time stamps do not: sample 1"):
        calibrated(columns, channels(clock={"model": "TimeColumn", "column": 0}))
    kept = {"model": "TimeColumn", "column": 0, "stamps": {"model": "KeepIncreasing"}}
    assert swiped(columns, clock=kept).friction.value == near(0.4, rel=1e-2)
    columns["time"][:] = 0
    with pytest.raises(InputError, match="only 1 samples with increasing time stamps are left"):
        calibrated(columns, channels(clock=kept))


def test_a_brief_halt_does_not_end_a_slide():
    """Of 60 ms, shorter than a pause; one of 300 ms ends it."""
    windows = []
    for halt in (0.0, 0.06, 0.3):
        columns, count = made(), round(halt * 2000)
        encoder = columns["encoder"]
        held = np.insert(encoder, 8000, np.full(count, encoder[8000]))
        columns["encoder"] = held[: len(encoder)]
        begin, end = swiped(columns).window
        windows.append(end - begin)
    whole, brief, long = windows
    assert brief == pytest.approx(whole, rel=0.05)
    assert long < 0.6 * whole


@pytest.mark.parametrize("direction", [1, -1])
def test_without_an_encoder_the_lateral_force_tells_the_slide(direction):
    columns = made(direction=direction, drifts=(0.0, 0.01))
    with_it = swiped(columns)
    columns.pop("encoder")
    found = swiped(columns, encoder=None)
    assert found.friction.value == near(0.4)
    assert found.direction == direction
    # 5 % of the time in place of 5 % of the distance, which lasts from 3 to 5 s
    assert found.window == pytest.approx(with_it.window, abs=0.05)
    assert (found.speed, found.distance) == (None, None)
    assert "sliding_speed" not in found.trace
    assert "because no position is recorded" in found.remarks[0]
    assert "the speed is unknown" in found.remarks[0]
    assert json.loads(json.dumps(found.to_dict()))["speed"] is None
    stated = swiped(columns, encoder=None, speed="40 mm/s")
    assert (stated.speed, stated.distance) == (40e-3, None)
    assert "the speed is the declared 40.0 mm/s" in stated.remarks[0]
    # it sticks before it slides: half as much again for 60 ms
    time = np.arange(16_000) / 2000
    columns["lateral"] = columns["lateral"] + direction * 0.5 / 0.444 * ((time > 3.0) & (time < 3.06))
    assert swiped(columns, encoder=None).friction.value == near(0.4, rel=1e-2)
    with pytest.raises(InputError, match="no motion found during contact: the lateral force does not exceed"):
        swiped(made(friction=0.0), encoder=None)


def test_a_few_rows_without_a_number_are_left_out_and_counted(tmp_path):
    columns = made()
    columns["normal"][[5, 9000]], columns["lateral"][8000] = np.nan, np.inf
    for rows, words in (
        ({}, "missing_rows = 3 omits"),
        ({"missing_rows": 2}, "missing_rows = 2 allows fewer"),
    ):
        with pytest.raises(InputError, match=rf"'normal', sample 5: nan .* 3 rows of 16000; {words}"):
            calibrated(columns, channels(**rows))
    recording = calibrated(columns, channels(missing_rows=3))
    assert (recording.missing, len(recording.time)) == (3, 15_997)
    assert recording.time[-1] == 15_999 / 2000  # what is left keeps its time
    found = reduce_swipe(recording)
    assert found.friction.value == near(0.4)
    assert "3 rows that hold a NaN were omitted." in found.remarks
    table = np.column_stack([columns["lateral"], columns["normal"], *3 * [columns["encoder"]]])
    np.save(tmp_path / "swipe.npy", table)
    again = reduce_swipe(read_recording(tmp_path / "swipe.npy", channels(missing_rows=3)))
    assert again.friction == found.friction
    with pytest.raises(InputError, match=r"swipe.npy: column 'normal', sample 5: nan .* missing_rows = 3"):
        read_recording(tmp_path / "swipe.npy", channels())
    rows = [",".join(f"{value:.10g}" for value in row) for row in table]  # empty fields of a text
    rows[5], rows[9000], rows[8000] = rows[5].split(",")[0] + ",,0,0,0", ",,0,0,0", ",,0,0,0"
    (tmp_path / "swipe.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    assert read_recording(tmp_path / "swipe.csv", channels(missing_rows=3)).missing == 3
    rows[7] = "oops,1,0,0,0"
    (tmp_path / "swipe.csv").write_text("\n".join(rows) + "\n", encoding="utf-8")
    with pytest.raises(InputError, match="line 8, column 0: 'oops' is not a number"):
        read_recording(tmp_path / "swipe.csv", channels(missing_rows=3))


def steps(values, step):
    return np.round(values / step) * step


def test_a_sensor_that_sits_at_its_rail_is_refused():
    """A normal force of 749 N was told of a converter at the end of its range."""
    columns = made(load=3.0, normal=1.0, zeros=(0.0, -0.3))
    columns["normal"] = steps(columns["normal"], 1e-3)
    assert not any("rail" in word for word in swiped(columns, normal=1.0).remarks)
    clipped = np.minimum(columns["normal"], 2.0)
    for sign in (1.0, -1.0):  # the other end, and a sensor turned around
        with pytest.raises(InputError, match=r"normal force is at its rail.*100% of the time from 3\.\d\d"):
            swiped(columns | {"normal": sign * clipped}, normal=sign)


def test_a_rail_for_part_of_what_is_used_or_of_a_zero_is_said_first():
    columns = made()
    lateral = columns["lateral"] = steps(columns["lateral"], 1e-4)
    part = lateral.copy()
    part[7000:7400] = part.max() + 0.1  # 400 of the 3600 samples of the window
    recording = calibrated(columns | {"lateral": part}, channels())
    np.testing.assert_array_equal(np.flatnonzero(recording.at_rail["lateral"]), np.arange(7000, 7400))
    assert not np.any(recording.at_rail["normal"])
    said = "Warning: the sensor of the lateral force is at its rail, or in a dead band, for 11.1% of the wi"
    assert reduce_swipe(recording).remarks[0].startswith(said)
    hidden = swiped(columns | {"lateral": np.maximum(lateral, np.median(lateral[:4000]) + 0.02)})
    for side in ("before", "after"):
        assert any(
            f"for 100.0% of the unloaded part {side} the contact" in word for word in hidden.remarks[:2]
        )


def test_a_rail_that_may_be_a_constant_force_is_said():
    """A load cell of coarse resolution at its rail: friction of 0.004 was told of 749 N without a word."""
    columns = made(load=3.0, normal=1.0, zeros=(0.0, -0.3))
    slow = np.clip((np.arange(16_000) - 3000) / 3000, 0, 1) * 3.0  # which shows no noise of the cell
    columns["normal"] = np.minimum(steps(slow, 0.02), 2.0)
    said = "normal force is exactly its highest or lowest reading for 100.0% of the window"
    assert any(said in word for word in swiped(columns, normal=1.0).remarks)


def test_a_sensor_that_is_stuck_within_its_range_is_said():
    columns = made()
    columns["lateral"] = columns["lateral"].copy()
    columns["lateral"][7000:7400] = np.median(columns["lateral"][6500:7000])
    said = "Warning: the lateral force repeats one reading for 11.1% of the window"
    assert any(word.startswith(said) for word in swiped(columns).remarks)
    assert not any("repeats one" in word for word in swiped(made()).remarks)


def altered(**changes):
    columns = made()
    for name, change in changes.items():
        columns[name] = change(columns[name])
    return columns


def with_nan(values):
    values = values.copy()
    values[77] = np.nan
    return values


@pytest.mark.parametrize(
    ("columns", "options", "words"),
    [
        (made(load=0.0), {}, "no contact found: the normal force has no two distinct levels"),
        (altered(normal=lambda v: np.linspace(0, 1, len(v))), {}, "no contact found"),
        (made(distance=20e-6), {}, r"no motion found during contact: the carriage moves by 2e-05 m"),
        (altered(encoder=lambda v: v * 0), {}, "no motion found"),
        (made(slide=(0.2, 1.2)), {}, "no motion found"),
        (made(touch=(2.0, 2.03), slide=(1.9, 2.1)), {"rate": 20_000.0}, "no contact found that lasts"),
        (altered(lateral=with_nan), {}, "column 'lateral', sample 77: nan is not a finite number"),
        (
            altered(normal=lambda v: v * 0 + 5),
            {},
            "column 'normal' holds 5 throughout; is it the right column",
        ),
        (altered(encoder=lambda v: v[:-1]), {}, "the columns differ in length: normal 16000"),
        ({name: values[:50] for name, values in made().items()}, {}, "a row of at least 100 samples"),
        ({"normal": np.ones(200)}, {}, "there is no column 'lateral'"),
        (made(), {"normal": 0.31}, "begins and ends under load.*normal.sensitivity has the wrong sign"),
    ],
)
def test_what_is_no_swipe_is_refused(columns, options, words):
    with pytest.raises(InputError, match=words):
        swiped(columns, **options)
