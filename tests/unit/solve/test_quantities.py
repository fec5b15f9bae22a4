"""Numbers that answer a question, by their names."""

import math

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.physics.rig import Tribometer
from electrovib.scenario import load
from electrovib.solve.expanded import Expanded
from electrovib.solve.quantities.answer import answer, of_record
from electrovib.solve.quantities.names import DEFAULTS, Named, read_name
from electrovib.solve.quantities.resolve import (
    Mesh,
    extremes,
    first_mesh,
    last_value,
    mean,
    mean_square,
    relative_tails,
    resolve,
    solved,
    tails,
    window,
)
from electrovib.solve.simulate import simulate

LAYERS = ("insulator", "stratum_corneum")
PERIODIC = {"time.initial_state": {"model": "PeriodicState"}}
GAP, FILM = load("vezzoli_2014/fig2"), load("vezzoli_2014/fig6")
SQUARE = {"model": "Square", "high": 100, "frequency": 50}
SINE = {"model": "Sine", "amplitude": 100.0, "frequency": 125.0}
MEAN = "mean electrostatic_force"


def asked(scenario, *names, solution=None):
    layers = tuple(scenario.stack.layers)
    return answer(solution or solved(scenario), [read_name(name, layers) for name in names])


def of_signal(found):
    """Values by what was taken of the signal."""
    return {name.split()[0]: value for name, value in found.values.items()}


def test_names():
    assert read_name("mean electrostatic_force", LAYERS) == Named("mean", "electrostatic_force")
    assert read_name("  mean electrostatic  force ", LAYERS).name == "mean electrostatic_force"
    layered = read_name("peak field in stratum corneum", LAYERS)
    assert (layered.name, layered.unit) == ("peak field in stratum_corneum", "V/m")
    assert "largest magnitude: electric field in a layer 'stratum_corneum'" in layered.meaning
    assert [read_name(name, LAYERS).name for name in DEFAULTS] == list(DEFAULTS)


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("largest current", "Did you mean 'peak current'?"),
        ("maximal current", "Did you mean 'maximum current'?"),
        ("lateral force", "Did you mean 'peak lateral_force'?"),
        ("mean curent", "Did you mean 'current'?"),
        ("mean impedance", "not a signal over time"),
        ("", "for instance 'mean electrostatic_force'"),
        ("peak field", "'peak field in insulator'"),
        ("peak field in gap", "Known: insulator, stratum_corneum"),
        ("peak current in insulator", "omit 'in insulator'"),
        ("peak skin_displacement", "has no signal 'skin_displacement'"),
    ],
)
def test_an_unknown_name_answers_with_the_nearest(name, words):
    with pytest.raises(InputError) as error:
        asked(FILM, name)
    assert words in str(error.value)


def test_numbers_of_polynomials_are_exact():
    mesh = Mesh(np.array([0.0, 1.0, 4.0]), 8)
    time = mesh.times()
    assert np.all(np.diff(time) > 0)
    assert (time[0], time[-1], len(time)) == (0.0, 4.0, 19)
    series = mesh.series((time - 1.5) ** 2 * (4.2 - time))
    exact = np.polynomial.Polynomial.fromroots([1.5, 1.5, 4.2]) * -1
    whole, square = exact.integ(), (exact * exact).integ()
    assert mean(mesh, series) == pytest.approx((whole(4) - whole(0)) / 4, rel=1e-13)
    assert mean_square(mesh, series) == pytest.approx((square(4) - square(0)) / 4, rel=1e-13)
    low, high = extremes(series)
    assert low == pytest.approx(0.0, abs=1e-13)  # between the nodes
    assert high == pytest.approx(exact(0.0), rel=1e-12)  # at the edge
    assert last_value(series) == pytest.approx(exact(4.0), rel=1e-12)
    assert np.all(tails(series) < 1e-13)
    np.testing.assert_array_equal(mesh.halved(np.array([False, True])).edges, [0, 1, 2.5, 4])
    values = time.copy()
    values[3] = np.nan  # nothing is known of a signal with a gap
    unknown = mesh.series(values)
    assert np.all(np.isnan([mean(mesh, unknown), mean_square(mesh, unknown), *extremes(unknown)]))


def test_an_extreme_between_the_places_looked_at_is_found():
    mesh = Mesh(np.linspace(0.0, 1.0, 5), 16)
    low, high = extremes(mesh.series(np.sin(11.0 * mesh.times() + 0.3) + 0.1))
    assert (low, high) == (pytest.approx(-0.9, rel=1e-11), pytest.approx(1.1, rel=1e-11))


def test_tails_are_relative_to_the_largest_value_of_each_case():
    series = np.zeros((2, 3, 8))
    series[:, :, 0], series[:, 1, -1] = np.array([[1.0], [1e6]]), 1e-3
    series[0, 2] = np.nan
    expected = [[0.0, 1e-3 / 1.001, 0.0], [0.0, 1e-9 / (1 + 1e-9), 0.0]]
    np.testing.assert_allclose(relative_tails(series), expected, rtol=1e-12)


def test_numbers_of_one_sine_are_those_of_its_formula():
    """Without dispersion the displacement is one sine, and the force its square; it is looked at once."""
    band = {"frequency": {"low": 125.0, "high": 250.0, "samples": 2}}
    scenario = GAP.replace({"drive": SINE} | band | PERIODIC)
    level = float(simulate(scenario).mean_force[0])
    expected = {"mean": level, "peak": 2 * level, "swing": 2 * level, "rms": level * math.sqrt(1.5)}
    expected["minimum"] = 0.0
    found = asked(scenario, *(f"{taken} electrostatic_force" for taken in expected))
    assert of_signal(found) == pytest.approx(expected, rel=1e-12, abs=1e-12 * level)
    assert max(found.errors.values()) < 1e-10
    solution = Expanded(FILM.replace({"drive": SINE} | PERIODIC))
    assert len(resolve(solution, [("electrostatic_force", "")]).record.times) < 100


def test_a_drive_and_its_voltage():
    drive = {"model": "Trapezium", "low": -10, "high": 40, "rise": 0.01, "hold": 0.02, "fall": 0.03}
    scenario = FILM.replace({"drive": drive})
    assert window(scenario) == (pytest.approx(0.08), "the whole time")
    ramps = (40**2 - 40 * 10 + 10**2) / 3
    expected = {"peak": 40, "maximum": 40, "minimum": -10, "swing": 50, "final": -10}
    expected["mean"] = (15 * 0.04 + 40 * 0.02 - 10 * 0.02) / 0.08
    expected["rms"] = math.sqrt((ramps * 0.04 + 1600 * 0.02 + 100 * 0.02) / 0.08)
    found = asked(scenario, *(f"{taken} drive_voltage" for taken in expected))
    assert of_signal(found) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("scenario", [FILM, GAP], ids=["film", "gap"])
@pytest.mark.parametrize("state", ["AtRest", "PeriodicState"])
def test_stiff_edges_agree_with_a_record_as_fine_as_it_gets(scenario, state):
    drive = {"model": "Square", "high": 100, "low": -50, "frequency": 100, "edge": 1e-5}
    case = scenario.replace({"drive": drive, "time": {"initial_state": {"model": state}}})
    found = asked(case, MEAN, "rms electrostatic_force", "peak current", "final lateral_force")
    end = window(case)[0]
    time = np.unique(np.concatenate([np.linspace(0, end, 400_001), np.linspace(0, 1e-5, 2001)]))
    record = simulate(case, time=time)
    for taken in ("mean", "rms"):
        expected = of_record(taken, time, record.electrostatic_force.values)
        assert found.values[f"{taken} electrostatic_force"] == pytest.approx(expected, rel=1e-6)
    assert found.values["peak current"] == pytest.approx(np.max(np.abs(record.current.values)), rel=1e-5)
    before_the_end = simulate(case, time=np.array([end * (1 - 1e-12)])).lateral_force.values[0]
    assert found.values["final lateral_force"] == pytest.approx(before_the_end, rel=1e-8)
    assert max(found.errors.values()) < 1e-8


def test_a_duration_is_the_time_that_numbers_are_taken_over_and_the_output_grid_does_not_enter():
    short = FILM.replace({"time": {"duration": 0.036}})
    assert window(short) == (0.036, "the whole time")
    assert of_signal(asked(short, "final drive_voltage")) == {"final": pytest.approx(1000.0, rel=1e-9)}
    assert window(FILM.replace({"drive": SQUARE}))[1] == "the whole time from rest"
    settled = FILM.replace({"drive": SQUARE, "time.duration": 0.5} | PERIODIC)
    assert window(settled) == (0.02, "one period of the periodic state")
    names = (MEAN, "swing lateral_force", "rms current")
    assert asked(FILM.replace({"time": {"samples": 3}}), *names).values == asked(FILM, *names).values


def test_a_march_is_asked_too_and_its_error_is_stated():
    finger = {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 1.0}
    lag = FILM.replace({"drive": SQUARE | {"edge": 1e-3}, "motion.speed": 0.05, "finger": finger})
    found = asked(lag, "swing skin_displacement", "mean lateral_force")
    record = simulate(lag, time=np.linspace(0, 0.1, 20_001))
    swing = float(record.skin_displacement.max() - record.skin_displacement.min())
    assert found.values["swing skin_displacement"] == pytest.approx(swing, rel=1e-4)
    assert found.how["mechanics_error"] < 1e-5


def test_what_a_digitiser_reads_is_taken_at_its_readings():
    read = FILM.replace({"rig": {"model": "Tribometer"} | dict(Tribometer.example)})
    names = ["mean lateral_force_measured", "peak lateral_force_measured", "mean lateral_force"]
    found, rate = asked(read, *names).values, read.rig.digitiser.sampling_rate
    time = np.arange(int(read.drive.duration * rate * (1 + 1e-12)) + 1) / rate
    readings = simulate(read, time=time).lateral_force_measured.values
    assert list(found) == names
    assert found[names[0]] == of_record("mean", time, readings)
    assert found[names[1]] == np.max(np.abs(readings))


def followed(monkeypatch, change):
    """Have every record changed."""
    ask = Expanded.at

    def at(self, times, *, wanted=None):
        record = ask(self, times, wanted=wanted)
        change(record, times)
        return record

    monkeypatch.setattr(Expanded, "at", at)


def test_a_number_that_is_not_known_is_told(monkeypatch):
    solution = Expanded(FILM)

    def partly(record, times):
        record.signals["lateral_force"][1][times > 0.1] = np.nan

    followed(monkeypatch, partly)
    found = asked(FILM, "mean lateral_force", MEAN, solution=solution)
    assert math.isnan(found.values["mean lateral_force"])
    assert found.values[MEAN] > 0
    (diagnostic,) = [diagnostic for diagnostic in found.diagnostics if diagnostic.name == "quantities"]
    assert diagnostic.state == "unknown"
    assert diagnostic.text.startswith("mean lateral_force: not known")


def test_what_bends_where_nothing_says_so_is_halved_until_it_is_followed(monkeypatch):
    """A friction that bends at times of its own: corners of no drive. What is resolved is not halved."""

    def bent(record, times):
        values = np.abs(np.sin(40 * times)) + np.exp(-((times - 0.1) ** 2) / 2e-6)
        record.signals["lateral_force"] = (("time",), values)

    followed(monkeypatch, bent)
    found = asked(FILM, "mean lateral_force", "maximum lateral_force")
    end = window(FILM)[0]
    half_turns, rest = divmod(40 * end, np.pi)
    exact = (2 * half_turns + 1 - math.cos(rest)) / (40 * end) + math.sqrt(2e-6 * np.pi) / end
    assert found.values["mean lateral_force"] == pytest.approx(exact, rel=1e-8)
    assert found.errors["mean lateral_force"] < 1e-8
    assert found.values["maximum lateral_force"] > 1.7
    once = resolve(Expanded(FILM), [("drive_voltage", "")])
    assert len(once.record.times) == len(first_mesh(Expanded(FILM)).times())


def test_a_signal_that_cannot_be_followed_is_told(monkeypatch):
    monkeypatch.setattr("electrovib.solve.quantities.resolve.MOST_VALUES", 1000)
    drive = {"model": "AmplitudeModulation", "amplitude": 100, "carrier": 50e3, "modulation": 10, "depth": 1}
    found = asked(GAP.replace({"drive": drive} | PERIODIC), MEAN)
    (diagnostic,) = [diagnostic for diagnostic in found.diagnostics if diagnostic.name == "resolution"]
    assert diagnostic.state == "warning"
    assert diagnostic.value == found.errors[MEAN] > diagnostic.limit


def test_numbers_of_a_record_are_those_of_the_straight_lines_between_its_samples():
    time, values = np.array([0.0, 1.0, 3.0]), np.array([0.0, 2.0, -4.0])
    expected = {"mean": (1.0 - 2.0) / 3, "rms": math.sqrt((4 / 3 + 2 * (4 - 8 + 16) / 3) / 3), "peak": 4.0}
    expected |= {"swing": 6.0, "maximum": 2.0, "minimum": -4.0, "final": -4.0}
    assert {taken: of_record(taken, time, values) for taken in expected} == pytest.approx(expected)
    assert math.isnan(of_record("peak", time, np.array([0.0, np.nan, 1.0])))
    one = np.array([1.0]), np.array([-3.0])
    assert [of_record(taken, *one) for taken in ("peak", "mean", "rms", "swing")] == [3.0, -3.0, 3.0, 0.0]


def test_a_record_of_many_samples_is_followed_with_few_nodes():
    """Pieces between 60 000 stamps get 4 nodes; the square of a straight line needs 3."""
    time = np.linspace(0, 0.6, 60_001)
    samples = np.sin(2 * np.pi * 100 * time)
    drive = {"model": "Sampled", "time_samples": time, "voltage_samples": samples}
    # nothing conducts: the force is the square of the drive
    skin = {"model": "Constant", "permittivity": 1560}
    plain = GAP.replace({"drive": drive, "time": {}, "stack.stratum_corneum.material": skin})
    solution = Expanded(plain)
    assert resolve(solution, [("electrostatic_force", "")]).mesh.nodes == 4
    found = asked(plain, MEAN, "peak electrostatic_force", solution=solution)
    mean_force, peak = found.values.values()
    squares = np.mean(samples[1:] ** 2 + samples[1:] * samples[:-1] + samples[:-1] ** 2) / 3
    # resistance of 2 kohm and a skin pole are left
    assert mean_force / peak == pytest.approx(squares, rel=2e-4)
    assert found.errors[MEAN] < 1e-7
    assert not [diagnostic for diagnostic in found.diagnostics if diagnostic.name == "resolution"]


@pytest.mark.parametrize(
    ("limits", "signal", "bound"),
    [
        ({"saturation": 90.0}, "plate_voltage", 90.0),
        ({"source_current": 2e-7, "stray_capacitance": 1e-11}, "amplifier_current", 2e-7),
    ],
    ids=["voltage", "current"],
)
def test_a_signal_behind_a_limit_is_taken_piecewise_between_the_kinks(limits, signal, bound):
    """A polynomial through the time at which a limit is reached would lie above the limit."""
    drive = {"model": "Trapezium", "high": 300.0, "rise": 3e-3, "hold": 5e-3, "fall": 2e-3, "delay": 2e-3}
    changes = {"drive": drive, "circuit.amplifier": {"bandwidth": 2000.0} | limits}
    found = asked(load("vezzoli_2014/fig6_gap", changes=changes), f"maximum {signal}")
    assert of_signal(found) == {"maximum": pytest.approx(bound, rel=1e-9)}
