"""Signals at many points with the same output times: those of a scenario by itself, and of its mechanics in small steps."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.discovery import find_members, papers
from electrovib.core.errors import ElectrovibError
from electrovib.core.paths import value_at
from electrovib.physics.drive.parts import Linear
from electrovib.physics.force import ForceLaw
from electrovib.solve import expanded
from electrovib.solve.electrics.straight import SharedModes, periodic_state
from electrovib.solve.expanded import Expanded
from electrovib.solve.mechanics import closed_form, mechanical
from electrovib.solve.prepare import Prepared

ELECTRICS, MECHANICS = 1e-9, 1e-6
"""Largest difference over the largest value: of electrical signals, and of the mechanics in steps, which states it."""
READING = "lateral_force_measured"
BEHIND = {"lateral_force", "skin_displacement", "skin_speed", READING}
OFFERED = BEHIND | {"current", "stack_voltage", "effective_voltage", "electrostatic_force"}
find_members(ForceLaw)  # imports all physics and papers
SHIPPED = [
    (paper, name) for paper, module in papers().items() for name in getattr(module, "scenarios", dict)()
]
ROOTS = {"drive", "stack", "contact", "friction", "circuit", "load", "motion", "finger", "rig", "force"}
LATERAL = {"model": "LateralSensor", "natural_frequency": "400 Hz", "damping_ratio": 0.1}
NORMAL = LATERAL | {"model": "PiezoSensor", "damping_ratio": 0.02, "time_constant": "10 s"}
PULSE = {"model": "Trapezium", "high": "100 V", "rise": "100 us", "hold": "4 ms", "fall": "100 us"}
STEP = {"model": "Step", "level": "80 V"}
SQUARE = {"model": "Square", "low": "-50 V", "high": "70 V"}
GIVEN = {
    "drive": PULSE,
    "time": {"model": "TimeGrid", "duration": "10 ms"},
    "stack.gap.material.conductivity": "2e-9 S/m",
    "rig": {"model": "Tribometer", "lateral": LATERAL, "normal": NORMAL},
    "finger": {"model": "MassSpringDamper", "mass": 1.5e-4, "stiffness": 1e3, "damping": 0.1},
}
DEBYE = {"model": "Debye", "permittivity_high": 100.0, "strength": 2000.0, "relaxation_time": "50 us"}
RELAXATIONS = [{"share": 0.2, "time": "4 ms"}, {"share": 0.1, "time": "70 ms"}]
CREEP = {"model": "Creep", "steady": {"model": "Coulomb", "coefficient": 0.5}, "relaxations": RELAXATIONS}
FREE = ("friction.coefficient", "contact.area", "stack.stratum_corneum.thickness")
FREE += ("rig.lateral.natural_frequency", "finger.mass")
NAMES = ("electrostatic_force", "current", "stack_voltage", "lateral_force", "skin_speed")
NAMES += (READING,)


def chain(**changes):
    """Return a pulse on three layers, with friction, a fingertip and a sensor behind the attraction."""
    return ev.load("bau_2010/sine").replace(GIVEN | changes)


def by_itself(scenario, point, names, times):
    """Return signals of a scenario that is built from the beginning, its mechanics in steps, or the kind of error."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(expanded, "attraction_in_pieces", lambda *_, **__: None)
        try:
            made = Prepared(scenario, free=list(point)).scenario(point)
            found = Expanded(made, times).at(times).signals
        except ElectrovibError as error:
            return type(error)
    return {name: found[name][1] for name in names}


def differences(scenario, points, names, times):
    """Return the largest difference of both ways over the largest value of each signal."""
    prepared = Prepared(scenario, free=list(points[0]))
    largest = dict.fromkeys(names, 0.0)
    for point in points:
        expected = by_itself(scenario, point, names, times)
        if isinstance(expected, type):
            with pytest.raises(expected):
                prepared.signals(point, names=names, time=times)
            continue
        found = prepared.signals(point, names=names, time=times)
        for name in names:
            np.testing.assert_array_equal(np.isnan(found[name]), np.isnan(expected[name]))
            scale = np.nanmax(np.abs(expected[name]), initial=0.0) or 1.0
            off = np.nanmax(np.abs(found[name] - expected[name]), initial=0.0) / scale
            largest[name] = max(largest[name], float(off))
    return largest


def points_of(scenario, paths, *, seed, count=3):
    """Return points at random, and after each the same with one parameter as in the scenario."""
    rng = np.random.default_rng(seed)
    begin = {path: value_at(scenario, path) for path in paths}
    found = []
    for _ in range(count):
        point = {path: begin[path] * float(rng.uniform(0.8, 1.25)) for path in paths}
        kept = str(rng.choice(list(paths)))
        found += [point, point | {kept: begin[kept]}]
    return found


def agree(off):
    """Check the differences of electrical signals and of those behind a sensor or a skin."""
    for name, each in off.items():
        assert each <= (MECHANICS if name in BEHIND else ELECTRICS), (name, each)


@pytest.mark.parametrize(
    ("paper", "name"),
    [pytest.param(*each, marks=pytest.mark.slow if each[1] == "fig2_tremor" else ()) for each in SHIPPED],
)
def test_a_shipped_scenario_gives_the_signals_of_the_same_by_itself(paper, name):
    scenario = papers()[paper].scenarios()[name]
    rng = np.random.default_rng(len(name))
    offered = [path for path, value, _ in scenario.parameters() if value and path.split(".")[0] in ROOTS]
    paths = sorted(rng.choice(offered, min(4, len(offered)), replace=False).tolist())
    end = scenario.time.duration or scenario.drive.duration
    times = np.unique(np.append(0.0, rng.uniform(0, end, 12)))
    known = Expanded(scenario, times).at(times).signals
    names = sorted(OFFERED & known.keys())
    agree(differences(scenario, points_of(scenario, paths, seed=1, count=1)[:1], names, times))


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"drive": STEP},
        {"drive": SQUARE | {"frequency": "300 Hz"}},
        {"drive": PULSE | {"rise": "0 s", "delay": "1 ms"}},
        {"circuit.return_path.resistance": "0 ohm"},
        {"circuit.return_path": {"model": "SecondElectrode", "area": "2 cm2"}},
        {"rig.lateral.damping_ratio": 3.0},
        {"rig.lateral.damping_ratio": 1.0},
        {"rig.lateral.bandwidth": "1 kHz"},
        {"rig.lateral.creep": {"share": -0.02, "time": "5 ms"}},
        {"force": {"model": "MaxwellStressInInsulator"}},
        {"force": {"model": "MaxwellStressInStratumCorneum"}},
        {"force": {"model": "EffectiveMedium"}},
        {"friction": CREEP},
        {"stack.stratum_corneum.material": DEBYE | {"conductivity": "1 uS/m"}},
    ],
    ids=str,
)
def test_the_closed_form_gives_the_signals_of_small_steps(changes, monkeypatch):
    scenario = chain(**changes)
    times = np.unique(np.append(np.linspace(0, 10e-3, 31), [100e-6, 4.1e-3, 4.2e-3]))
    free = [path for path in FREE if path in {name for name, *_ in scenario.parameters()}]
    points = points_of(scenario, free, seed=2)
    expected = differences(scenario, points, NAMES, times)
    agree(expected)
    monkeypatch.setattr(mechanical, "respond_mechanically", None)  # nothing is stepped
    Prepared(scenario, free=free).signals(points[0], names=NAMES, time=times)


@pytest.mark.parametrize(
    "changes",
    [
        {"friction": {"model": "PowerLaw", "coefficient": 0.6, "at_force": 1.0, "exponent": -0.2}},
        {"load.time_profile": {"model": "Press", "rise": "3 ms"}},
        {"contact": {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.6}},
        {"drive": SQUARE | {"frequency": "300 Hz"}, "time.initial_state": {"model": "PeriodicState"}},
    ],
    ids=["friction", "load", "area", "settled"],
)
def test_what_is_no_quadratic_form_of_straight_pieces_is_followed_in_steps(changes):
    scenario, names = chain(**changes), ("electrostatic_force", "skin_speed", READING)
    point = {"stack.gap.thickness": 2.5e-6}
    agree(differences(scenario, [point], names, np.linspace(0, 3e-3, 7)))


@pytest.mark.parametrize(
    ("changes", "calls"),
    [({}, 0), ({"contact": {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.6}}, None)],
    ids=["closed form", "steps"],
)
@pytest.mark.parametrize("also", ["skin_speed", "lateral_force"])
def test_only_a_friction_without_memory_needs_the_attraction_at_its_own_times(
    monkeypatch, changes, calls, also
):
    scenario, times = chain(**changes), np.linspace(0, 3e-3, 7)
    expected, whole, asked = Expanded(scenario, times).at(times).signals, expanded.solve, []

    def counted(*arguments, **options):
        asked.append(arguments[2])
        return whole(*arguments, **options)

    assert ("gross_contact_area" in expected) == ("contact" in changes)
    monkeypatch.setattr(expanded, "solve", counted)
    found = Prepared(scenario, free=[]).signals({}, names=(READING, also), time=times)
    for name in (READING, also):
        np.testing.assert_allclose(found[name], expected[name][1], rtol=1e-12)
    assert sum(np.array_equal(each, times) for each in asked) == (also == "lateral_force")
    assert calls is None or len(asked) == calls + (also == "lateral_force")


GAP = "stack.gap.material.conductivity"


@pytest.mark.parametrize("edge", [100e-6, 1e-6, 1e-8])
@pytest.mark.parametrize("conductivity", [2e-9, 1e-10, 2e-12])
def test_a_slow_mode_behind_a_steep_edge_is_no_difference_of_large_numbers(edge, conductivity):
    scenario = chain().replace({"drive.rise": edge, "drive.fall": edge, GAP: conductivity})
    point = {"friction.coefficient": value_at(scenario, "friction.coefficient")}
    agree(differences(scenario, [point], NAMES, np.linspace(0, 10e-3, 31)))


@pytest.mark.parametrize(
    ("drive", "conductivity", "is_closed"),
    [(PULSE, 1.6e-9, True), (PULSE, 8e-10, False), (STEP, 1.6e-11, True), (STEP, 8e-12, False)],
)
def test_the_closed_form_is_used_up_to_its_limit(drive, conductivity, is_closed):
    """Modes of 13 and 7/s under a slope of 1e6 V/s; of 0.14 and 0.07/s in 10 ms."""
    scenario, times = chain(drive=drive).replace({GAP: conductivity}), np.linspace(0, 10e-3, 3)
    found = closed_form.attraction_in_pieces(scenario, Expanded(scenario, times).section, end=10e-3)
    assert (found is not None) == is_closed


def test_a_law_of_two_amplitudes_has_no_product_of_both(monkeypatch):
    law = type(chain().force)
    both = {"gap": 1.0, "insulator": 3.0}
    monkeypatch.setattr(law, "amplitudes", lambda _, section: {name: section[name].field for name in both})
    monkeypatch.setattr(
        law, "pressure", lambda _, **E: eps0 / 2 * sum(both[name] * each**2 for name, each in E.items())
    )
    names, free, times = (
        ("electrostatic_force", READING),
        ("contact.area", "stack.gap.thickness"),
        np.linspace(0, 10e-3, 9),
    )
    points = points_of(chain(), free, seed=3)
    agree(differences(chain(), points, names, times))
    monkeypatch.setattr(mechanical, "respond_mechanically", None)  # nothing is stepped
    Prepared(chain(), free=free).signals(points[0], names=names, time=times)


def test_a_law_of_the_current_follows_the_slope_of_the_drive(monkeypatch):
    """Without resistance the current has a part that is proportional to the rate of change of the drive."""
    scenario = chain(**{"circuit.return_path.resistance": 0.0, "circuit.source_resistance": 0.0})
    law = type(scenario.force)
    monkeypatch.setattr(law, "amplitudes", lambda _, section: {"flow": section.current_density})
    monkeypatch.setattr(law, "pressure", lambda _, flow: 1e4 * flow**2)
    point, times = {"friction.coefficient": 0.5}, np.linspace(0, 10e-3, 41)
    agree(differences(scenario, [point], ("electrostatic_force", READING), times))
    monkeypatch.setattr(mechanical, "respond_mechanically", None)  # nothing is stepped
    Prepared(scenario, free=list(point)).signals(point, names=[READING], time=times)


def test_a_signal_alone_is_that_among_all():
    scenario, times = chain(), np.linspace(0, 10e-3, 11)
    known = Expanded(scenario, times).at(times).signals
    assert {"field", "displacement", "interface_field", "drive_voltage", "current"} <= known.keys()
    for name, (_, row) in known.items():
        found = Prepared(scenario, free=["contact.area"]).signals({}, names=[name], time=times)[name]
        np.testing.assert_allclose(found, row, rtol=0, atol=1e-12 * np.max(np.abs(row)))


def test_over_another_band_the_materials_are_reduced_again():
    skin = papers()["palmar_1995"].skins()["dry_men"].material.to_dict()
    scenario = ev.load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material": skin})
    times = np.linspace(0, 0.05, 11)
    given = {"time": times, "band": np.geomspace(1e-7, 10, 50)}
    prepared = Prepared(scenario, free=["contact.area"])
    own = prepared.signals({}, time=times)["electrostatic_force"]
    found = prepared.signals({}, **given)["electrostatic_force"]
    alone = Prepared(scenario, free=["contact.area"]).signals({}, **given)["electrostatic_force"]
    np.testing.assert_array_equal(found, alone)
    assert not np.array_equal(found, own)
    np.testing.assert_allclose(found, own, atol=1e-3 * own.max())


def test_the_last_points_are_kept_and_friction_needs_no_other_electrics(monkeypatch):
    scenario, times = chain(), np.linspace(0, 10e-3, 11)
    prepared = Prepared(scenario, free=["friction.coefficient", "contact.area"])
    names = ("electrostatic_force", "lateral_force")
    first = prepared.signals({}, names=names, time=times)
    prepared.signals({"contact.area": 2e-4}, names=names, time=times)  # a search returns from here
    monkeypatch.setattr(expanded, "solve", lambda *_, **__: pytest.fail("solved again"))
    doubled = {"friction.coefficient": 2 * prepared.begin["friction.coefficient"]}
    again = prepared.signals(doubled, names=names, time=times)
    np.testing.assert_array_equal(again["electrostatic_force"], first["electrostatic_force"])
    np.testing.assert_allclose(again["lateral_force"], 2 * first["lateral_force"], rtol=1e-12)


def test_a_drive_of_many_pieces_is_not_evaluated_piece_by_piece(monkeypatch):
    fast = chain(drive=SQUARE | {"frequency": "5 kHz"})
    monkeypatch.setattr(closed_form, "Response", None)
    assert fast.drive.count_corners(10e-3) > closed_form.MOST_PIECES
    found = Prepared(fast, free=["contact.area"]).signals({}, time=np.linspace(0, 10e-3, 11), names=[READING])
    assert np.all(np.isfinite(found[READING]))


def straight(part, rates, gains, times, state, *, lag=False):
    """The modes x, or their lags x - v."""
    modes = SharedModes(rates, gains, np.zeros(len(gains)), np.full(len(gains), lag))
    return np.array(modes.straight(part, times, state))


@pytest.mark.parametrize("lag", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_a_period_at_a_time_is_what_all_pieces_say(lag, seed):
    """To rounding: a phase of 40 periods is known to 40 eps, which a mode of 1e4/period turns into 1e-10."""
    rng = np.random.default_rng(seed)
    period, inside = 10 ** rng.uniform(-6, 0), rng.integers(1, 5)
    breaks = np.concatenate([[0], np.sort(rng.uniform(0, period, inside)), [period]])
    before, after = rng.normal(size=(2, len(breaks)))
    if seed % 3 == 0:
        before = after.copy()
    before[0], after[-1] = 0.0, after[0]
    part = Linear(breaks, before, after, period)
    end = period * rng.uniform(0.2, 40)
    starts = np.arange(0, end / period) * period
    times = np.concatenate([rng.uniform(0, end, 50), (starts[:, None] + breaks[:-1]).ravel(), [0.0, end]])
    times = np.unique(times[times <= end])
    rates, gains = 10 ** rng.uniform(-3, 4, 6) / period, rng.normal(size=(2, 6))
    state = rng.normal(size=6) * (seed % 2)
    written_out = straight(part.until(end), rates, gains, times, state, lag=lag)
    found = straight(part, rates, gains, times, state, lag=lag)
    assert found == pytest.approx(written_out, abs=2e-10)
    assert part.count_breaks(end) == len(part.until(end).times)


def test_a_late_period_of_a_fast_square_wave_is_its_periodic_state():
    """100 kHz for 2000 s, 4e8 corners: the beginning is forgotten to 2e-9; the time is rounded to 2e-13 s, 2e-7 of 1/rate."""
    part = chain(drive={"model": "Square", "high": 100, "low": -60, "frequency": 1e5}).drive.parts()[0]
    rates, gains = np.array([1e-2, 1e2, 1e6]), np.eye(3)
    phases = np.linspace(0, 0.95e-5, 20)
    late = straight(part, rates, gains, 2000.0 + phases, np.zeros(3))
    settled = straight(part, rates, gains, phases, periodic_state(part, rates))
    assert late == pytest.approx(settled, abs=1e-4)
