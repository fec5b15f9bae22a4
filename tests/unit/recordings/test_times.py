"""Times between levels against closed forms and synthetic records, with and without a sensor."""

import math
from pathlib import Path

import numpy as np
import pytest
import xarray
from scipy.integrate import solve_ivp

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.physics.drive.readback import OneOfTwoInAntiphase
from electrovib.physics.relaxation import stretched_exponential, stretched_seen_by_sensor
from electrovib.physics.resonance import release_seen_by_sensor
from electrovib.recordings.transitions import Sensor, measure_ring, measure_times
from electrovib.recordings.transitions.relaxation import RelaxationForm
from electrovib.recordings.transitions.sensor import read_sensor

SHARED = Path(__file__).resolve().parents[3].parent / "shared" / "data" / "clutch"
TAU = 6e-3
BETWEEN = TAU * math.log(9)


def record(relaxation, *, edges=4, noise=0.01, seed=0, rate=12_800.0, period=0.2, correlated=0.0, **signals):
    """Make a signal that rises and falls alternately by 1 N, each change with the relaxation of its time."""
    random = np.random.default_rng(seed)
    time = np.arange(0, period * (edges + 0.5), 1 / rate)
    force, drive = np.zeros_like(time), np.zeros_like(time)
    for number in range(edges):
        at = (number + 0.6) * period + random.uniform(0, 1 / rate)
        force += (1 - 2 * (number % 2)) * (1 - relaxation(time - at))
        drive[time > at] = 100.0 * (1 - number % 2)
    white = random.standard_normal(time.size)
    for place in range(1, time.size if correlated else 0):
        white[place] = correlated * white[place - 1] + math.sqrt(1 - correlated**2) * white[place]
    names = {"lateral_force_measured": force + noise * white, "drive_voltage": drive} | signals
    return xarray.Dataset({name: ("time", values) for name, values in names.items()}, coords={"time": time})


def exponential(tau=TAU):
    return lambda t: np.exp(-np.maximum(t, 0) / tau)


def seen(tau, frequency=380.0, quality=3.0):
    return lambda t: release_seen_by_sensor(t, start=0.0, fall_time=tau, frequency=frequency, quality=quality)


def measured(trace, **options):
    """Measure a record, of which no edge is skipped unless the drive is not declared."""
    found = measure_times(trace, signal="lateral_force_measured", **{"exponentials": 1, **options})
    assert not found.skipped or "by" in options
    return found


@pytest.mark.parametrize("levels", [(0.1, 0.9), (0.2, 0.9)])
def test_an_exponential_takes_its_time_constant_times_a_logarithm(levels):
    found = measured(record(exponential(), noise=1e-4), levels=levels)
    low, high = levels
    wanted = {"rising": math.log((1 - low) / (1 - high)), "falling": math.log(high / low)}
    for each in found.directions:
        exact = TAU * wanted[each.direction]
        assert each.recorded.value == pytest.approx(exact, rel=2e-3)
        assert each.without_sensor.value == pytest.approx(exact, rel=3e-4)
        assert each.recorded.count == 2
        assert each.parameters["time_constant"].value == pytest.approx(TAU, rel=3e-4)
        assert "no sensor was taken out" in " ".join(each.words)


@pytest.mark.parametrize(("frequency", "quality"), [(380.0, 3.0), (640.0, 10.0), (50.0, 0.8)])
def test_the_shortest_time_of_a_sensor_is_that_of_its_differential_equation(frequency, quality):
    natural = 2 * math.pi * frequency

    def rate(time, state):
        return [state[1], natural**2 * (1 - state[0]) - natural / quality * state[1]]

    def passing(level):
        event = lambda _, state: state[0] - level  # noqa: E731
        event.direction = 1
        return event

    solved = solve_ivp(
        rate, (0, 2 / frequency), [0.0, 0.0], events=[passing(0.1), passing(0.9)], rtol=1e-10, atol=1e-12
    )
    first, last = (times[0] for times in solved.t_events)
    assert Sensor(frequency=frequency, quality=quality).shortest_time() == pytest.approx(
        last - first, rel=1e-5
    )


def test_an_instantaneous_release_through_380_hz_shows_half_a_millisecond():
    assert Sensor(frequency=380.0, quality=3.0).shortest_time() == pytest.approx(0.4894e-3, rel=1e-3)


@pytest.mark.parametrize("stretching", [0.5, 1.0, 1.4])
def test_a_stretched_exponential_through_a_sensor_solves_its_differential_equation(stretching):
    time, tau, frequency, quality = np.linspace(-1e-3, 12e-3, 200), 2e-3, 380.0, 3.0
    natural = 2 * math.pi * frequency

    def rate(at, state):
        force = math.exp(-((at / tau) ** stretching))
        return [state[1], natural**2 * (force - state[0]) - natural / quality * state[1]]

    inside = time[time > 0]
    solved = solve_ivp(rate, (0, time[-1]), [1.0, 0.0], t_eval=inside, rtol=1e-9, atol=1e-11, max_step=2e-5)
    reading = stretched_seen_by_sensor(
        time, time_constant=tau, stretching=stretching, frequency=frequency, quality=quality
    )
    assert np.abs(reading[time > 0] - solved.y[0]).max() < 1e-3
    assert (reading[time <= 0] == 1).all()
    if stretching == 1.0:
        closed = release_seen_by_sensor(time, start=0.0, fall_time=tau, frequency=frequency, quality=quality)
        assert np.abs(reading - closed).max() < 1e-4


def test_a_sensor_taken_out_gives_the_time_of_the_force():
    found = measured(
        record(seen(TAU), edges=2, period=0.15, seed=1), sensor=Sensor(frequency=380.0, quality=3.0)
    )
    for each in found.directions:
        assert each.form == "exponential"
        assert each.without_sensor.value == pytest.approx(BETWEEN, rel=0.01)
        assert each.sensor_limit == pytest.approx(0.4894e-3, rel=1e-3)
        assert each.criteria["instantaneous"] > 100


@pytest.mark.slow
def test_a_fast_release_is_seen_longer_than_it_is():
    tau = 0.25e-3
    found = measured(record(seen(tau), rate=50_000.0), sensor="380 Hz:3")
    for each in found.directions:
        assert each.recorded.value > 1.05 * tau * math.log(9)
        assert each.without_sensor.lower < tau * math.log(9) < each.without_sensor.upper
        assert each.without_sensor.value == pytest.approx(tau * math.log(9), rel=0.05)


@pytest.mark.parametrize("sensor", [pytest.param("380Hz:3", marks=pytest.mark.slow), "estimate"])
def test_an_instantaneous_release_has_an_upper_end_only(sensor):
    found = measured(record(seen(1e-9), edges=2), sensor=sensor)
    for each in found.directions:
        assert each.form == "instantaneous"
        assert each.without_sensor.value == each.without_sensor.lower == 0
        assert 0 < each.without_sensor.upper < 0.25e-3
        assert each.recorded.value == pytest.approx(each.sensor_limit, rel=0.06)
        assert "only an upper end of the time is known" in " ".join(each.words)
        if sensor == "estimate":
            of = each.parameters
            assert of["frequency"].lower < 380 < of["frequency"].upper
            assert of["quality"].lower < 3 < of["quality"].upper


def test_the_uncertainty_of_a_declared_sensor_widens_the_interval():
    trace = record(seen(0.5e-3), edges=2)
    exact = measured(trace, sensor=Sensor(frequency=380.0, quality=3.0), edges="falling").falling
    unsure = measured(
        trace, sensor=Sensor(frequency=380.0, quality=3.0, frequency_error=40.0), edges="falling"
    ).falling
    widths = [each.without_sensor.upper - each.without_sensor.lower for each in (exact, unsure)]
    assert widths[1] > 1.2 * widths[0]
    assert "taken as exact" in " ".join(exact.words)
    assert "taken as exact" not in " ".join(unsure.words)


def test_several_edges_are_averaged_with_students_t():
    found = measured(record(exponential(), edges=8, noise=0.02, rate=5000.0)).falling
    times = np.array([each.recorded.value for each in found.edges])
    from scipy.stats import t

    half = t.ppf(0.975, 3) * times.std(ddof=1) / 2
    assert found.recorded.value == pytest.approx(times.mean())
    assert found.recorded.upper - found.recorded.value == pytest.approx(half)
    assert found.recorded.scatter == pytest.approx(times.std(ddof=1))


def test_rising_and_falling_edges_are_separate():
    time = np.arange(0, 1.0, 1e-4)
    force = np.where(time < 0.5, 1 - exponential(5e-3)(time - 0.2), exponential(20e-3)(time - 0.5))
    force += 1e-3 * np.random.default_rng(1).standard_normal(time.size)
    found = measured(xarray.Dataset({"lateral_force_measured": ("time", force)}, coords={"time": time}))
    assert found.rising.parameters["time_constant"].value == pytest.approx(5e-3, rel=0.01)
    assert found.falling.parameters["time_constant"].value == pytest.approx(20e-3, rel=0.01)
    assert "does not contain the scatter between edges" in " ".join(found.words)


def test_a_delay_after_the_drive_is_measured():
    found = measured(record(lambda t: exponential()(t - 2e-3)), by="drive_voltage")
    for each in found.directions:
        assert each.parameters["delay"].value == pytest.approx(2e-3, abs=0.1e-3)
        # the edge of the drive is known to half of a sample
        assert each.edges[0].record.reference_error == pytest.approx(1 / 12_800 / math.sqrt(12), rel=1e-3)


def test_a_drive_in_antiphase_has_no_pauses():
    time = np.arange(0, 1.0, 1e-4)
    on = (time > 0.3) & (time < 0.7)
    first = np.where(on & ((time * 50) % 1 < 0.5), 300.0, 0.0)
    force = np.where(time < 0.7, 1 - exponential(5e-3)(time - 0.3), exponential(5e-3)(time - 0.7))
    force += 5e-3 * np.random.default_rng(1).standard_normal(time.size)
    trace = xarray.Dataset(
        {"lateral_force_measured": ("time", force), "drive_voltage": ("time", first)}, coords={"time": time}
    )
    found = measured(trace, by="drive_voltage", readback=OneOfTwoInAntiphase(start=0.3, stop=0.7))
    assert [len(each.edges) for each in found.directions] == [1, 1]
    assert found.falling.parameters["time_constant"].value == pytest.approx(5e-3, rel=0.02)
    # without the declaration every half period counts as a pause
    undeclared = measured(trace, by="drive_voltage")
    assert len(undeclared.skipped) > 20


@pytest.mark.parametrize(
    ("relaxation", "form"),
    [
        (exponential(), "exponential"),
        (lambda t: stretched_exponential(t, time_constant=TAU, stretching=0.5), "stretched exponential"),
        (lambda t: 0.5 * exponential(2e-3)(t) + 0.5 * exponential(20e-3)(t), "2 exponentials"),
    ],
)
def test_the_form_is_chosen_by_criterion(relaxation, form):
    found = measured(record(relaxation, edges=2, noise=0.005, seed=3), exponentials=3).falling
    assert found.form == form
    assert found.criteria[form] <= 2
    wanted = {
        "exponential": {"time_constant": TAU},
        "stretched exponential": {"time_constant": TAU, "stretching": 0.5},
        "2 exponentials": {"time_constant_1": 2e-3, "time_constant_2": 20e-3, "share_1": 0.5},
    }[form]
    for name, value in wanted.items():
        assert found.parameters[name].value == pytest.approx(value, rel=0.08)


def test_the_time_of_two_exponentials_does_not_depend_on_the_size_of_the_change():
    form = RelaxationForm("2 exponentials", 2)
    time = np.linspace(0, 0.1, 200_001)
    left = 0.5 * np.exp(-time / 2e-3) + 0.5 * np.exp(-time / 20e-3)
    exact = time[left <= 0.1][0] - time[left <= 0.9][0]
    values = {"time_constant_1": 2e-3, "time_constant_2": 20e-3, "change_1": -3.0, "change_2": -3.0}
    assert form.time_between(values, (0.1, 0.9)) == pytest.approx(exact, rel=1e-4)


def test_a_time_from_the_wrong_form_carries_a_warning():
    wave = lambda t: exponential()(t) * np.cos(400 * np.maximum(t, 0))  # noqa: E731
    found = measured(record(wave, edges=2, noise=0.002))
    assert any(text.startswith("Warning") and "residual" in text for text in found.words)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"levels": (0.9, 0.1)}, "levels = "),
        ({"levels": (0.0, 0.9)}, "levels = "),
        ({"exponentials": 0}, "exponentials = 0"),
        ({"window": -1.0}, "window = -1"),
        ({"edges": "up"}, "edges = up"),
        ({"sensor": "380"}, "sensor = 380"),
        ({"sensor": "380 V:3"}, "sensor = 380 V:3"),
        ({"by": "drive"}, "by = drive"),
        ({"signal": "lateral_force"}, "signal = lateral_force"),
        ({"signal": None}, "2 signals over time"),
        ({"readback": OneOfTwoInAntiphase()}, "readback"),
    ],
)
def test_what_cannot_be_used_is_refused(options, words):
    with pytest.raises(InputError, match=words.replace("(", r"\(")):
        measure_times(record(exponential(), edges=2), **{"signal": "lateral_force_measured", **options})


def test_times_that_do_not_increase_are_refused():
    trace = record(exponential(), edges=2)
    again = xarray.concat([trace, trace.isel(time=[5])], "time")
    with pytest.raises(InputError, match="do not increase"):
        measure_times(again, signal="lateral_force_measured")


@pytest.mark.parametrize(("frequency", "quality"), [(0.0, 3.0), (380.0, 0.5), (380.0, math.inf)])
def test_a_sensor_without_a_resonance_is_refused(frequency, quality):
    with pytest.raises(InputError, match="sensor"):
        Sensor(frequency=frequency, quality=quality)


def test_a_sensor_is_read_from_text():
    assert read_sensor("0.38 kHz:3") == read_sensor("380:Q=3") == Sensor(frequency=380.0, quality=3.0)


def test_a_record_without_edges_is_refused():
    quiet = xarray.Dataset(
        {"lateral_force_measured": ("time", np.zeros(500))}, coords={"time": np.arange(500) * 1e-3}
    )
    with pytest.raises(InputError, match="no edge"):
        measure_times(quiet)


def coverage(count, **options):
    """Return the shares of the single-edge intervals that hold the true time: as recorded, and of the fit."""
    inside = np.zeros(2)
    for seed in range(count):
        trace = record(exponential(), edges=1, seed=seed, noise=0.01, rate=5000.0, **options)
        found = measured(trace, edges="rising").rising
        of = (found.recorded, found.edges[0].fitted["exponential"].between)
        inside += [each.lower < BETWEEN < each.upper for each in of]
    return inside / count


@pytest.mark.slow
def test_intervals_hold_the_true_time():
    assert (coverage(20) >= 0.85).all()


@pytest.mark.slow
@pytest.mark.parametrize("correlated", [0.0, 0.6])
def test_intervals_of_200_records_hold_the_true_time(correlated):
    recorded, fitted = coverage(200, correlated=correlated)
    assert 0.90 <= recorded <= 0.995
    assert 0.91 <= fitted <= 0.985


@pytest.mark.slow
def test_the_number_of_exponentials_is_right_in_nine_of_ten_records():
    right = {1: 0, 2: 0}
    for seed in range(50):
        for count, relaxation in (
            (1, exponential()),
            (2, lambda t: 0.5 * exponential(2e-3)(t) + 0.5 * exponential(20e-3)(t)),
        ):
            found = measured(
                record(relaxation, edges=1, noise=0.005, seed=seed, rate=5000.0),
                edges="rising",
                exponentials=3,
            ).rising
            sums = {"exponential": 1, "2 exponentials": 2, "3 exponentials": 3}
            best = min(sums, key=lambda name: found.criteria.get(name, math.inf))
            right[count] += sums[best] == count
    assert min(right.values()) >= 45, right


@pytest.mark.slow
def test_the_interval_of_a_force_behind_a_sensor_holds_its_time_in_200_records():
    inside = 0
    tau = 0.5e-3
    for seed in range(200):
        trace = record(seen(tau), edges=1, seed=seed, noise=0.02)
        found = measured(trace, edges="rising", sensor="380:3").rising.edges[0].fitted["exponential"].between
        inside += found.lower < tau * math.log(9) < found.upper
    assert 0.91 <= inside / 200 <= 0.985


def clutch(name):
    """Open a recording of a clutch with its declared columns."""
    path = SHARED / f"square_300V_{name}.npy"
    if not path.exists():
        pytest.skip("shared/data/clutch is not here")
    return ev.import_file(path, {"lateral_force_measured": "1 [N]", "drive_voltage": "3 [V]"}, time="0 [us]")


@pytest.mark.parametrize("name", ["10Hz", pytest.param("1kHz", marks=pytest.mark.slow)])
def test_the_release_of_a_clutch_is_faster_than_its_sensor_shows(name):
    options = {"signal": "lateral_force_measured", "by": "drive_voltage", "readback": OneOfTwoInAntiphase()}
    found = measure_times(
        clutch(name), sensor="estimate", edges="falling", window=20e-3, before=10e-3, **options
    ).falling
    assert len(found.edges) == 1
    assert 0.40e-3 < found.recorded.value < 0.60e-3
    assert found.recorded.lower < found.sensor_limit < found.recorded.upper
    assert found.without_sensor.upper < 0.35e-3
    assert 370 < found.parameters["frequency"].value < 400
    assert 2.5 < found.parameters["quality"].value < 4.5
    assert 0.2e-3 < found.exponential["delay"].value < 0.4e-3
    ring = measure_ring(clutch(name), **options)
    assert ring.form == "two modes"
    assert ring.sections[-1].frequency.value < 0.9 * ring.sections[0].frequency.value


def test_a_time_that_the_record_does_not_determine_is_warned_of_first():
    """A slow rise of which the window holds a tenth, in noise of half of that."""
    stamps = np.arange(0, 0.06, 1e-4)
    noise = np.random.default_rng(2).normal(0, 0.03, stamps.size)
    force = np.where(stamps > 0.02, 0.6 * -np.expm1(-(stamps - 0.02) / 0.3), 0) + noise
    signals = {
        "lateral_force_measured": (("time",), force),
        "drive_voltage": (("time",), np.where(stamps >= 0.02, 300.0, 0.0)),
    }
    trace = make_trace(signals, {"time": stamps}, {"title": "slow"})
    found = ev.measure_times(
        trace, signal="lateral_force_measured", by="drive_voltage", window=0.03, before=0.015
    )
    assert found.rising is not None
    assert found.rising.recorded.lower <= 0
    assert found.rising.words[0].startswith("Warning: Rising edges: the record does not determine a time")


def test_a_record_without_noise_states_that_the_error_of_the_fit_is_not_known():
    stamps = np.linspace(0, 0.06, 601)
    force = np.where(stamps > 0.0205, -np.expm1(-(stamps - 0.0205) / 3e-3), 0.0)
    trace = make_trace(
        {"lateral_force_measured": (("time",), force)}, {"time": stamps}, {"title": "computed"}
    )
    found = ev.measure_times(trace, signal="lateral_force_measured")
    assert found.rising is not None
    assert math.isinf(found.rising.misfit)
    assert "the record has no noise before an edge" in found.rising.words[0]
    assert not any("residual of inf" in text for text in found.words)
