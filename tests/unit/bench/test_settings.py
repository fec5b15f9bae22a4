"""The bench file, the plan, and what is refused before anything is sent."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.bench.settings import default_text, read_settings
from electrovib.core.errors import InputError
from electrovib.core.parsing import read_toml

SCENARIO = "vezzoli_2014/fig6"


def tables(**changes):
    found = read_toml(default_text())
    for path, value in changes.items():
        place, names = found, path.split("__")
        for name in names[:-1]:
            place = place.setdefault(name, {})
        if value is None:
            del place[names[-1]]
        else:
            place[names[-1]] = value
    return found


def test_the_default_is_the_set_up_of_the_paper():
    found = read_settings()
    assert (found.limits.voltage, found.limits.current) == (1000, 250e-6)
    assert found.current_limiter.current == 250e-6
    assert (found.generator.driver, found.oscilloscope.driver) == ("hp_33120a", "tektronix_tds3014b")
    assert found.amplifier.enable is None
    assert set(found.channels()) == {"voltage", "current", "lateral", "normal"}
    assert set(found.resources.values()) == {""}


REFUSED = {
    "no limiter": ({"current_limiter": None}, r"\[current_limiter\] name ="),
    "no voltage": ({"limits__voltage": None}, r"add: \[limits\] voltage ="),
    "no current": ({"limits__current": None}, r"add: \[limits\] current ="),
    "limiter too large": ({"current_limiter__current": "1 mA"}, "allows more than the largest current"),
    "no driver": ({"generator__driver": "hp_33120"}, "Did you mean 'hp_33120a'"),
    "another schema": ({"schema": 2}, "schema = 2"),
    "one input twice": ({"forces__normal__input": 2}, "share an input"),
    "no gain": ({"amplifier__gain": 0}, "a gain of 0"),
    "no ratio": ({"oscilloscope__voltage__ratio": 0}, "a ratio of 0"),
    "no sensitivity": ({"forces__lateral__sensitivity": 0}, "a sensitivity of 0"),
    "range turned over": ({"forces__lateral__low": "1 N"}, "low must be below high"),
    "gain too small": ({"amplifier__gain": 20}, "100 V in the full one"),
    "first burst too small": ({"burst__low_voltage": "1 V"}, "0.01 V in the first burst"),
    "too long": ({"burst__longest": "0.2 s"}, "longer than burst.longest = 200 ms"),
    "too coarse": ({"burst__resampling_error": 1e-5}, "has an error of 0.0099 %"),
    "strictest voltage": ({"limits__voltage": "900 V"}, "reaches 1 kV, above 900 V"),
    "strictest current": (
        {"limits__current": "0.5 uA", "current_limiter__current": "0.5 uA"},
        "reaches 1.6.* uA, above 500 nA",
    ),
    # one code, 1 kV/2047, in an edge of 10 us
    "slew rate": ({"limits__slew_rate": 48e3}, "reaches 48.85.* kV/s, above 48 kV/s"),
    "rms voltage": ({"limits__rms_voltage": 675.0}, "the root-mean-square voltage of the plate reaches 675.1"),
    "rms current": ({"limits__rms_current": 1e-7}, "the root-mean-square current into the contact"),
    "the limiter alone": ({"current_limiter__current": "0.5 uA"}, "above 500 nA: .*the current limiter"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_is_not_safe_is_refused_before_anything_is_sent(name):
    changes, words = REFUSED[name]
    with pytest.raises(InputError, match=words):
        ev.plan_bench(SCENARIO, bench=tables(**changes))


NOTHING = [
    "none",
    "NONE",
    "  No  ",
    "n/a",
    "---",
    "   ",
    "not there yet",
    "(keine)",
    "sans résistance",
    "нет",
    "\uff4e\uff4f\uff4e\uff45",
]


@pytest.mark.parametrize("place", ["current_limiter__name", "edge__source"])
@pytest.mark.parametrize("text", NOTHING)
def test_a_part_that_is_not_there_protects_nobody(place, text):
    changes = {"edge__time": "10 us"} if place.startswith("edge") else {}
    with pytest.raises(InputError, match=rf"{place.replace('__', '.')}.*(names nothing|at least 3)"):
        ev.plan_bench(SCENARIO, bench=tables(**changes, **{place: text}))


def spiked(top, spike, *, wide=20e-9, gain=1.0):
    """A trapezium of 0.1 s to `top` [V], with a spike of another height and a width [s] in its hold."""
    pulse = {"model": "Trapezium", "high": top / gain, "rise": 0.02, "hold": 0.06, "fall": 0.02}
    more = {"high": (spike - top) / gain, "delay": 0.0502, "rise": wide / 2, "hold": 0.0, "fall": wide / 2}
    return {"model": "Sum", "drives": [pulse, {"model": "Trapezium", **more}]}


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ((900.0, 1200.0), "reaches 1.2 kV for less than a point"),
        ((980.0, 1001.0), "reaches 1.001 kV, above 1 kV"),  # too little to be called lost
        ((900.0, -1200.0), "reaches -1.2 kV for less than a point"),
        ((0.0, 1200.0), "reaches 1.2 kV for less than a point"),
        ((0.0, 500.0), "reaches 500 V for less than a point"),
        ((900.0, 400.0), "reaches 400 V for less than a point"),
        ((-900.0, -1200.0), "reaches -1.2 kV for less than a point"),
    ],
)
def test_what_is_between_two_points_of_the_generator_is_judged(drive, words):
    with pytest.raises(InputError, match=words):
        ev.plan_bench(SCENARIO, set={"drive": spiked(*drive), "time.duration": 0.1})
    amplified = {
        "drive": spiked(*drive, gain=50.0),
        "time.duration": 0.1,
        "circuit.amplifier": {"gain": 50.0},
    }
    with pytest.raises(InputError, match=words):
        ev.plan_bench(SCENARIO, set=amplified)


def test_what_lasts_for_several_points_is_played():
    plan = ev.plan_bench(SCENARIO, set={"drive": spiked(900.0, 990.0, wide=2e-4), "time.duration": 0.1})
    assert plan.codes.max() > 0.98 * 2047
    assert plan.peak == 990


SINE = {"model": "Sine", "amplitude": "1 V", "frequency": "100 Hz"}
PULSE = {"model": "Trapezium", "high": "100 V", "rise": "10 ms", "hold": "10 ms", "fall": "1 ms"}


@pytest.mark.parametrize(
    ("drive", "words"),
    [
        ({"model": "Step", "level": "100 V"}, "begins at 100 V"),
        ({"model": "Step", "level": "-100 V"}, "begins at -100 V"),
        ({**PULSE, "hold": "1 s", "fall": 0}, "ends at 100 V"),
        ({**PULSE, "high": "0 V"}, "0 V throughout"),
        ({"model": "CurrentAmplifier", "sense_resistance": "1 Mohm", "command": SINE}, "is a current"),
    ],
)
def test_only_a_finite_voltage_from_0_v_to_0_v_is_played(drive, words):
    with pytest.raises(InputError, match=words):
        ev.plan_bench(SCENARIO, set={"drive": drive, "time.duration": 0.05})


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"limits.voltage": "700 V"}, "reaches 1 kV, above 700 V"),
        ({"drive.high": 2000.0, "circuit.amplifier": {"saturation": 1000.0}}, "reaches 2 kV, above 1 kV"),
        ({"drive.high": 2000.0, "circuit.amplifier": {"source_current": 1e-9}}, "reaches 2 kV, above 1 kV"),
        ({"drive.high": 2000.0, "circuit.amplifier": {"bandwidth": 0.1}}, "reaches 2 kV, above 1 kV"),
        ({"drive.rise": 1e-6, "circuit.amplifier": {"source_current": 1e-6}}, "mA, above 250 uA"),
        ({"drive.rise": 1e-6, "circuit.amplifier": {"bandwidth": 1.0}}, "mA, above 250 uA"),
    ],
)
def test_no_amplifier_of_the_scenario_hides_voltage_or_current_from_the_limits(changes, words):
    """And the limits of the scenario count too."""
    with pytest.raises(InputError, match=words if "limits.voltage" in changes else f"{words}.*do not count"):
        ev.plan_bench(SCENARIO, set=changes)


def test_the_plan_plays_the_drive_in_the_sign_of_the_amplifier():
    plan = ev.plan_bench(SCENARIO)
    turned = ev.plan_bench(SCENARIO, bench=tables(amplifier__gain=-200))
    assert plan.codes[0] == plan.codes[-1] == 0
    assert plan.codes.max() == 2047
    np.testing.assert_array_equal(turned.codes, -plan.codes)
    assert plan.amplitude == pytest.approx(10)  # 5 V times 200
    slow = ev.plan_bench(SCENARIO, bench=tables(limits__slew_rate=49e3))
    assert "slew rate 49 kV/s" in repr(slow)
    times = (np.arange(10 * plan.codes.size) + 0.5) * plan.duration / (10 * plan.codes.size)
    played = np.repeat(plan.codes, 10) / 2047 * plan.amplitude / 2 * 200
    error = np.sqrt(np.mean((played - plan.voltage(times)) ** 2)) / 1000
    assert error == pytest.approx(plan.resampling_error, rel=0.05)
    assert plan.voltage([-1e-3, plan.duration + 1e-3]).tolist() == [0, 0]
    steep = {**SINE, "amplitude": "100 V", "frequency": "1 kHz"}
    codes = ev.plan_bench(SCENARIO, set={"drive": steep, "time.duration": 0.01}).codes
    assert codes[[0, -1]].tolist() == [0, 0]
    assert abs(codes[[1, -2]]).min() > 0


@pytest.mark.parametrize("gain", [100.0, -100.0])
def test_the_gain_of_the_scenarios_own_amplifier_counts(gain):
    changes = {"drive.high": "10 V", "circuit.amplifier": {"gain": gain}}
    plan = ev.plan_bench(SCENARIO, set=changes)
    assert plan.peak == pytest.approx(1000)
    assert plan.voltage(0.1) == pytest.approx(10 * gain)
    assert plan.codes[np.argmax(np.abs(plan.codes))] == 2047 * np.sign(gain)
    played = np.sign(gain) * ev.run_bench(SCENARIO, simulate=True, set=changes).plate_voltage
    assert float(played.max()) == pytest.approx(1000, rel=0.01)


def test_the_range_of_an_input_is_that_of_its_quantity():
    """What the ends of the range on the oscilloscope stand for, with the zero of the sensor and in either sign.

    The record of a drive of one sign holds twice the plan, and 40 % of the peak on the other side of 0 V.
    """
    for high, sign in (("1 kV", 1), ("-1 kV", -1)):
        plan = ev.plan_bench(SCENARIO, set={"drive.high": high})
        channel = plan.settings.channels()["voltage"]
        ends = channel.quantity(np.array(plan.ranges()[channel.input])) * sign
        assert sorted(ends) == pytest.approx([-400.0, 2000.0])
    for sensitivity in (2.0, -2.0):
        changes = {"forces__lateral__zero": "0.7 V", "forces__lateral__sensitivity": sensitivity}
        plan = ev.plan_bench(SCENARIO, bench=tables(**changes))
        lateral = plan.settings.channels()["lateral"]
        low, high = plan.ranges()[lateral.input]
        assert low < high
        ends = lateral.quantity(np.array([low, high]))
        assert sorted(ends) == pytest.approx([lateral.low, lateral.high], abs=1e-12)
        assert lateral.quantity(np.array([0.7])) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({}, "without them only the plan is shown"),
        ({"simulate": True, "arm": True}, "both were given"),
        ({"arm": True}, r"amplifier\.enable: without an enable line an operator"),
        ({"arm": True, "confirm": lambda _: True}, r"generator\.resource: the bench file states no address"),
    ],
)
def test_nothing_is_played_unasked_or_without_address_and_operator(options, words):
    with pytest.raises(InputError, match=words):
        ev.run_bench(SCENARIO, **options)


def test_a_settings_file_that_is_missing_or_no_toml(tmp_path):
    file = tmp_path / "my.toml"
    with pytest.raises(InputError, match=r"my\.toml: No such file.*bench init"):
        read_settings(file)
    file.write_text("schema = ", encoding="utf-8")
    with pytest.raises(InputError, match="not valid TOML"):
        read_settings(file)


def test_a_step_of_several_points_is_no_lost_feature():
    step = {"model": "Trapezium", "high": 20.0, "delay": 0.02, "rise": 0.0, "hold": 0.05, "fall": 0.0}
    assert ev.plan_bench(SCENARIO, set={"drive": step, "time.duration": 0.1}).peak == 20
