"""Where two features meet, each by its closed form; what a user sets counts, or is refused, or a diagnostic says so."""

import functools
import itertools

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.motion import Motion
from electrovib.scenario import load
from electrovib.solve.diagnostics.assumptions import settled_charge
from electrovib.solve.electrics import renewal
from electrovib.solve.electrics.solution import LEAK, Question, linear_quantities
from electrovib.solve.electrics.without_modes import follow_all
from electrovib.solve.expanded import Expanded
from electrovib.solve.mechanics.sliding import not_negative
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.keys import FieldOf

CLOSES = {
    "contact.surface": {"model": "LinearSpring", "stiffness": 1e9, "free_gap": "10 um"},
    "motion.distance": None,
    "contact.closing": {"damping": 1e6},
    "stack.stratum_corneum.material.conductivity": 0.0,
    "load.normal_force": 0.5,
}
BARE = {"circuit.return_path.resistance": 0.0}


@pytest.fixture(scope="module")
def suspended():
    return load("vezzoli_2014/fig2")


@pytest.fixture(scope="module")
def founding():
    return load("vezzoli_2014/fig6_gap")


def assert_same(found, expected, names, share):
    for name in names:
        size = float(np.abs(expected[name]).max())
        np.testing.assert_allclose(found[name], expected[name], rtol=0, atol=share * size, err_msg=str(name))


def test_bridges_take_their_share_of_the_pull_that_closes_a_gap(suspended):
    """At rest the surface topography carries load and attraction, the attraction that the Trace reports."""
    bridged = {"stack.gap.material": {"model": "BridgedAir", "bridged_share": 0.4, "spot_conductivity": 0.0}}
    held = {"drive": {"model": "Step", "level": 400.0}}
    trace = simulate(suspended.replace(CLOSES | bridged | held), time=np.linspace(0, 0.05, 11))
    carried = 1e9 * (10e-6 - trace.gap.values[-1]) * 1e-4
    pull = float(trace.electrostatic_force[-1])
    assert pull > 0.01
    assert carried == pytest.approx(0.5 + pull, rel=1e-9)
    second = {"circuit.return_path": {"model": "SecondElectrode", "area": "0.5 cm2"}}
    with pytest.raises(InputError, match=r"contact\.closing: .*use Grounded or Floating"):
        simulate(suspended.replace(CLOSES | second))  # two contacts do not close as one


def test_a_closing_gap_draws_its_current_on_every_stretch_of_the_drive(suspended):
    """Without resistance the current is the rate of change of the charge, before the last break of the drive too."""
    steps = {"drive": {"model": "Trapezium", "high": 600.0, "rise": 4e-3, "hold": 3e-3, "fall": 1e-3}}
    time = np.linspace(0, 12e-3, 1201)
    trace = simulate(suspended.replace(CLOSES | BARE | steps), time=time)
    charge = trace.displacement.sel(layer="insulator").values * 1e-4
    mean = (charge[2:] - charge[:-2]) / (time[2:] - time[:-2])
    found = trace.current.values[1:-1]
    smooth = np.min(np.abs(time[1:-1, None] - np.array([4e-3, 7e-3, 8e-3])), axis=1) > 2e-5
    assert np.max(np.abs(found - mean)[smooth]) < 1e-4 * np.max(np.abs(found))


DEBYE = {
    "model": "Debye",
    "permittivity_high": 100.0,
    "strength": 900.0,
    "relaxation_time": 0.5e-3,
    "conductivity": 1e-5,
}


def test_an_amplifier_that_just_cannot_follow_does_not_chatter(founding, monkeypatch):
    """A chirp that needs the largest current at one moment, within rounding: it used to change without end."""
    monkeypatch.setattr("electrovib.solve.electrics.amplifier.MOST_CHANGES", 1000)
    changes = {
        "drive": {"model": "Chirp", "amplitude": 60.0, "first": 50.0, "last": 500.0, "length": 7e-3},
        "stack.insulator.thickness": 2e-6,
        "stack.gap": {"thickness": 2e-6, "material": {"model": "Constant", "permittivity": 1.0}},
        "stack.stratum_corneum.material": DEBYE,
        "circuit.amplifier": {"gain": 1.5, "source_current": 15e-6, "stray_capacitance": 5e-11},
        "circuit.return_path.resistance": 2e4,
    }
    trace = simulate(founding.replace(changes), time=np.linspace(0, 8e-3, 81))
    assert "9 changes" in trace.attrs["solver_reason"]
    assert float(np.abs(trace.amplifier_current).max()) <= 15e-6 * (1 + 1e-9)


@pytest.mark.parametrize("end", [2e-3, 2.3e-3])
def test_the_last_time_of_a_record_is_like_any_other(founding, end):
    """Behind a limit, the current at the end of a record is that of a longer one."""
    amplifier = {"circuit.amplifier": {"saturation": 50.0, "stray_capacitance": 5e-11}}
    sine = {"drive": {"model": "Sine", "amplitude": 60.0, "frequency": 200.0}}
    scenario, time = founding.replace(BARE | sine | amplifier), np.array([0.0, 1e-3, end])
    ends, goes_on = simulate(scenario, time=time), simulate(scenario, time=np.append(time, 2 * end))
    assert_same(ends, goes_on.isel(time=slice(3)), ("current", "amplifier_current", "plate_voltage"), 5e-3)
    assert abs(float(ends.current[-1])) > 0.01 * float(np.abs(goes_on.current).max())


def test_a_long_record_behind_a_limit_is_a_short_one_at_more_times(founding):
    """Beyond 10,000 times a law's amplitude and the field share a row: what the limit takes counts once in it."""
    limits = {"gain": 1.8, "bandwidth": 1500.0, "source_current": 8e-6, "stray_capacitance": 3e-11}
    sine = {"model": "Sine", "amplitude": 60.0, "frequency": 200.0}
    scenario = founding.replace({"drive": sine, "circuit.amplifier": limits})
    time = np.linspace(0, 8e-3, 12_001)
    long, short = simulate(scenario, time=time), simulate(scenario, time=time[::40])
    assert "changes between them" in long.attrs["solver_reason"]
    assert "; 0 changes" not in long.attrs["solver_reason"]
    assert_same(long.isel(time=slice(None, None, 40)), short, ("field", "electrostatic_force"), 1e-12)


PLATES = {
    "friction": {"model": "Coulomb", "coefficient": 0.5},
    "contact": {"model": "FixedArea", "area": 1e-4},
    "load": {"normal_force": 0.5},
    "time": {"duration": 8e-3, "samples": 161},
}


def test_the_largest_current_behind_a_limit_is_resolved():
    """One film behind a resistor and a pole of the amplifier: V C a b/(a - b) (exp(-b t) - exp(-a t)) after a step."""
    capacitance = 3.9 * eps0 * 1e-4 / 10e-6
    a, b = 1 / (1e5 * capacitance), 2 * np.pi * 800.0
    crest = np.log(a / b) / (a - b)
    largest = 100.0 * capacitance * a * b / (a - b) * (np.exp(-b * crest) - np.exp(-a * crest))
    amplifier = {"bandwidth": 800.0, "saturation": 100.0}
    film = {"thickness": 10e-6, "role": "plate", "material": {"model": "Constant", "permittivity": 3.9}}
    table = PLATES | {
        "drive": {"model": "PulseTrain", "high": 120.0, "width": 1.1e-3, "frequency": 100.0},
        "force": {"model": "MaxwellStressInInsulator"},
        "circuit": {"return_path": {"model": "Grounded", "resistance": 1e5}, "amplifier": amplifier},
        "stack": {"insulator": film},
    }
    assert ev.check(table).value("peak current") == pytest.approx(largest, rel=1e-5)


def test_one_conducting_layer_that_moves_adds_its_conduction():
    """Whatever conducts, the field is V/g, and the current of the charge and sigma E add."""
    distance = {"model": "TremblingDistance", "mean": 3e-6, "amplitude": 1e-6, "frequency": 150.0}
    dry, leaky = (
        ev.simulate(
            PLATES
            | {
                "drive": {"model": "Sine", "amplitude": 50.0, "frequency": 200.0},
                "force": {"model": "MaxwellStressInGap"},
                "motion": {"distance": distance},
                "circuit": {"return_path": {"model": "Grounded", "resistance": 0.0}},
                "stack": {
                    "gap": {
                        "thickness": 3e-6,
                        "material": {"model": "Constant", "permittivity": 1.0, "conductivity": conductivity},
                    }
                },
            }
        )
        for conductivity in (0.0, 1e-8)
    )
    field = dry.drive_voltage.values / dry.gap.values
    np.testing.assert_allclose(leaky.field.values[0], field, rtol=1e-12)
    found, conducted = leaky.current.values - dry.current.values, 1e-8 * field * 1e-4
    np.testing.assert_allclose(found, conducted, rtol=0, atol=1e-9 * conducted.max())


def test_bristles_begin_without_a_load_though_an_attraction_is_rounded_below_0(founding):
    """Field times displacement of the skin is 0 at time 0, or -1e-36 N, which was refused as a negative strength."""
    swipe = {"model": "Swipe", "begin": 0.4e-3, "rise": 1e-3, "hold": 3e-3, "fall": 1.2e-3}
    bristles = {"model": "Dahl", "steady": {"model": "Coulomb", "coefficient": 0.5}, "stiffness": 1e3}
    skin = {"model": "Constant", "permittivity": 1500.0, "conductivity": 13e-6}
    changes = {"load.time_profile": swipe, "friction": bristles, "motion.speed": 0.05}
    changes |= {"force.model": "MaxwellStressInStratumCorneum", "stack.stratum_corneum.material": skin}
    changes |= {"circuit.return_path.resistance": 2e6, "drive": {"model": "Step", "level": 89.0}}
    for thickness in (2e-6, 2.2e-6, 4e-6):
        scenario = founding.replace(changes | {"stack.insulator.thickness": thickness})
        assert simulate(scenario, time=np.linspace(0, 8e-3, 41)).lateral_force.values[0] < 1e-9
    with pytest.raises(InputError, match="strength of 0 or above"):
        not_negative(np.arange(2.0), np.array([-1e-6, 1.0]))
    with pytest.raises(InputError, match=r"its strength is nan N at 1 s"):
        not_negative(np.arange(2.0), np.array([1.0, np.nan]))


RECTIFYING = {"model": "PolarityConduction", "conductivity_positive": 4e-9, "conductivity_negative": 1e-9}


@pytest.mark.parametrize("limit", [{}, {"saturation": 1e5}], ids=["gain", "limit"])
def test_an_amplifier_before_a_single_leak_counts(founding, limit):
    """A gain of 2 before a leak, and twice the drive without an amplifier."""
    sine = {"model": "Sine", "amplitude": 50.0, "frequency": 100.0}
    scenario = founding.replace({"stack.gap.leak": RECTIFYING, "drive": sine})
    time = np.linspace(0, 10e-3, 21)
    amplified = simulate(scenario.replace({"circuit.amplifier": {"gain": 2.0} | limit}), time=time)
    doubled = simulate(scenario.replace({"drive.amplitude": 100.0}), time=time)
    assert ("an amplifier with limits before a leak" in amplified.attrs["solver_reason"]) == bool(limit)
    assert_same(amplified, doubled, ("stack_voltage", "current", "electrostatic_force"), 5e-5)


GROWING = {"model": "FieldConduction", "conductivity": 1e-9, "onset_field": 2e6}
LEAKS = {"rectifying": RECTIFYING, "growing": GROWING}
DRIVES = {
    "sine": {"model": "Sine", "amplitude": 50.0, "frequency": 100.0},
    "square": {"model": "Square", "high": 60.0, "low": -20.0, "frequency": 100.0},
    "pulse": {"model": "Trapezium", "high": 80.0, "rise": 2e-3, "hold": 5e-3, "fall": 1e-3},
}
BEFORE_LEAKS = [
    case if place % 13 == 1 else pytest.param(*case, marks=pytest.mark.slow)
    for place, case in enumerate(itertools.product(["gap", "insulator"], LEAKS, DRIVES, [0.0, 1e6]))
]


@pytest.mark.parametrize(("layer", "leak", "drive", "resistance"), BEFORE_LEAKS)
def test_gain_and_pole_before_a_leak_are_those_of_the_general_solver(
    founding, layer, leak, drive, resistance
):
    changes = {
        f"stack.{layer}.leak": LEAKS[leak],
        "drive": DRIVES[drive],
        "circuit.amplifier": {"gain": -1.5, "bandwidth": 1e3, "stray_capacitance": 1e-10},
        "circuit.return_path.resistance": resistance,
    }
    scenario, time = founding.replace(changes), np.linspace(0, 12e-3, 41)
    prepared = Expanded(scenario, time)
    solution = prepared.at(time).solution
    wanted = functools.partial(linear_quantities, scenario)
    question = Question(scenario=scenario, section=prepared.section, times=time, wanted=wanted)
    assert solution.method is LEAK
    fields = map(FieldOf, ("gap", "insulator"))
    names = ["plate_voltage", "current", "amplifier_current", "stack_voltage", *fields]
    assert_same(solution.found, follow_all(question).found, names, 5e-5)


def test_charge_on_fresh_film_counts_once(founding):
    """Where nothing conducts, film with the same charge comes and goes unseen: the answer is that of a finger at rest."""
    charged = BARE | {
        "stack.insulator.initial_charge": 1e-4,
        "stack.gap.material.conductivity": 0.0,
        "stack.stratum_corneum.material": {"model": "Constant", "permittivity": 300.0},
        "motion.speed": 0.1,
    }
    rest, fresh, without = (
        simulate(founding.replace(charged | more), time=np.linspace(0, 0.3, 31))
        for more in ({}, {"motion.renews_film": True}, {"stack.insulator.initial_charge": 0.0})
    )
    assert (rest.attrs["solver"], fresh.attrs["solver"]) == ("transient", "renewal")
    assert_same(fresh, rest, ("field", "displacement", "electrostatic_force"), 1e-12)
    assert abs(float(rest.electrostatic_force[0] - without.electrostatic_force[0])) > 1e-3


@pytest.mark.parametrize(
    "drive",
    [
        {"model": "Square", "high": 300.0, "low": -100.0, "frequency": 30.0},
        {"model": "Trapezium", "high": 300.0, "rise": 10e-3, "hold": 50e-3, "fall": 10e-3},
    ],
    ids=["jumps", "ramps"],
)
def test_the_mean_over_the_contact_states_its_error(founding, drive, monkeypatch):
    """Twenty times as many places: no signal moves by more than what was stated."""
    scenario = founding.replace({"drive": drive, "motion.speed": 0.3, "motion.renews_film": True})
    trace = simulate(scenario, time=np.linspace(0, 0.08, 41))
    monkeypatch.setattr(renewal, "PANELS", 320)
    fine = simulate(scenario, time=np.linspace(0, 0.08, 41))
    stated = trace.attrs["quadrature_error"]
    assert_same(trace, fine, ("electrostatic_force", "current", "stack_voltage"), stated + 1e-12)
    assert 1e-12 < stated < 1e-3
    assert fine.attrs["quadrature_error"] < stated
    assert f"{stated:.1e} of the largest value" in trace.attrs["solver_reason"]


PRESS = {"model": "Press", "begin": 0.05, "rise": 0.05}
GAPS = {"dry_gap_resistivity": 1e12, "wet_gap_resistivity": 1e6}
MOIST = {"moisture": {"level": 0.5, "dry_coefficient": 0.4, "wet_coefficient": 0.8} | GAPS}
FACTORS = {"pressure_factor": 0.5, "decay_factor": 0.5}
PERSSON = {"model": "PerssonSurface", "modulus": 2e7, "rms_slope": 1.0, "rms_gap": 2e-5} | FACTORS


def told(scenario, changes=None, **how):
    return {each.name: each for each in diagnostics_of(simulate(scenario.replace(changes or {}), **how))}


def test_what_nothing_would_follow_is_refused(founding):
    with pytest.raises(InputError, match="source_current beside it"):
        read_model(Amplifier, {"sink_current": "2 uA"})
    with pytest.raises(InputError, match="time_profile scales the speed and needs one"):
        read_model(Motion, {"time_profile": {"model": "Press", "rise": 0.1}})
    with pytest.raises(InputError, match="ridge_share"):
        founding.replace({"contact.ridge_share": 0.6})  # which no law knows


def test_a_press_has_a_periodic_state_before_no_memory(founding):
    """It is exact: the attraction repeats, the load does not."""
    sine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": 50.0}, "load.time_profile": PRESS}
    settled = founding.replace(sine | {"time.initial_state": {"model": "PeriodicState"}})
    trace = simulate(settled, time=np.linspace(0, 0.2, 201))
    np.testing.assert_allclose(trace.normal_force.values[-1], 0.5)


def test_a_closing_gap_without_a_load_begins_as_declared(founding):
    """A Persson surface topography carries no load only endlessly far away."""
    closing = {"contact.surface": PERSSON, "contact.closing": {"damping": 1e6}, "load.time_profile": PRESS}
    scenario = founding.replace(closing | {"stack.gap.material.conductivity": 0.0})
    trace = simulate(scenario, time=np.linspace(0, 0.2, 41))
    assert trace.gap.values[0] == founding.stack.layers["gap"].thickness
    carried = 0.5e7 * 2 * np.exp(-trace.gap.values[-1] / 1e-5) * 1e-4
    assert carried == pytest.approx(float(trace.normal_force[-1] + trace.electrostatic_force[-1]), rel=0.02)


def test_the_current_that_a_stray_capacitance_takes_is_not_said_to_enter_the_finger(founding):
    stray = {"circuit.amplifier": {"gain": 1.0, "bandwidth": 1e5, "stray_capacitance": 1e-8}}
    assert "into plate, stray capacitance and finger" in told(founding, stray)["current"].text
    assert "into the contact" in told(founding)["current"].text


def test_moisture_says_what_it_sets_and_what_it_finds_nothing_for(founding):
    found = told(founding, MOIST)["moisture"]
    assert found.state == "ok"
    assert "friction.coefficient = 0.6" in found.text
    shear = {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}, "contact.surface": PERSSON}
    found = told(founding, shear | MOIST)["moisture"]
    assert found.state == "warning"
    assert "no parameter of friction that moisture sets" in found.text
    coefficient, moist = {"friction.coefficient": 0.7}, founding.replace(MOIST)
    with pytest.raises(InputError, match=r"friction\.coefficient: is set by moisture"):
        moist.replace(coefficient)
    assert moist.replace({"moisture": None} | coefficient).friction.coefficient == 0.7


def test_a_load_on_a_finger_held_off_is_told():
    held, time = load("vezzoli_2014/fig2_tremor"), np.linspace(0, 0.05, 11)
    assert "load off the plate" not in told(held, time=time)
    assert told(held, {"load.normal_force": 0.5}, time=time)["load off the plate"].state == "warning"


def test_a_current_in_an_edge_between_two_times_is_not_missed(founding):
    """C dV/dt of the edge, whatever the output times: 3 us between times 5 ms apart."""
    square = {"drive": {"model": "Square", "high": 300.0, "frequency": 20.0, "edge": 3e-6}}
    for time, largest in ((np.arange(13) * 5e-3, (0, 2.5e-6)), (np.linspace(0, 6e-6, 601), (250e-6, np.inf))):
        trace = simulate(founding.replace(square), time=time)
        assert largest[0] < float(np.abs(trace.current).max()) < largest[1]
        assert [each.state for each in diagnostics_of(trace) if each.name == "current"] == ["warning"]


def test_a_quantity_that_is_not_known_is_named_in_words(tmp_path):
    rows = ["frequency,permittivity,loss", "10,2000,1800", "100,1600,1200", "1000,1200,900", "100000,700,300"]
    (tmp_path / "skin.csv").write_text("\n".join(rows), encoding="utf-8")
    table = {"model": "Tabulated", "file": str(tmp_path / "skin.csv"), "conductivity": 1e-6}
    changes = {"stack.stratum_corneum.material": table, "force": {"model": "MaxwellStressInGap"}}
    text = told(load("vezzoli_2014/fig6"), changes)["memory"].text
    assert "; the field of 'stratum_corneum' is not known to 1 % of its remaining amplitude from" in text


CONDUCTIVITY = "stack.insulator.material.conductivity"


@pytest.fixture(scope="module")
def offset():
    """A sine of 100 V on 200 V over a film of permittivity 3.35, in the periodic state."""
    return load("kang_2017/offset")


@pytest.mark.parametrize(
    ("changes", "mean"),
    [
        ({CONDUCTIVITY: 1e-14}, "200 V"),
        ({CONDUCTIVITY: 2.9e-13}, "200 V"),  # just above a hundred seconds
        ({CONDUCTIVITY: 3.0e-13}, None),
        ({CONDUCTIVITY: 1e-14, "drive": {"model": "Step", "level": -50.0}}, "-50 V"),
        ({}, None),
        ({CONDUCTIVITY: 1e-14, "time.initial_state.model": "AtRest"}, None),
        ({CONDUCTIVITY: 1e-14, "drive.level": 0.0}, None),
        ({CONDUCTIVITY: 0.0, "stack.gap.material.conductivity": 1e-14}, None),
    ],
)
def test_a_periodic_state_that_takes_hours_to_reach_is_marked(offset, changes, mean):
    found = settled_charge(offset.replace(changes))
    assert bool(found) == bool(mean)
    for each in found:
        relaxes = 3.35 * eps0 / changes[CONDUCTIVITY]
        assert (each.state, each.value) == ("warning", pytest.approx(relaxes, rel=1e-9))
        assert f"the mean of {mean} has been held" in each.text
        assert "stack.insulator.material.conductivity = 0" in each.text


def test_a_run_and_a_comparison_carry_it(offset):
    assert "settled charge" in told(offset, {"stack.insulator.material": "silica"})
    found = ev.compare_materials(offset, materials=["silica", "pet"])
    cautions = {entry.name: bool(entry.caution) for entry in found.entries}
    assert cautions == {"as it is": False, "silica": True, "pet": False}
    assert found.tables[1].title == "The attraction is reached only after a long time"
