"""The general reference with a fixed gap: the exact linear solver, the march of one leak, and energy."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.discovery import papers
from electrovib.core.errors import InputError
from electrovib.physics.amplifier import Amplifier
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.debye_sum import DebyeSum
from electrovib.physics.material import Constant, Debye
from electrovib.physics.stack import Layer
from electrovib.solve.electrics.leaks import leaky_response
from electrovib.solve.electrics.transient import transient
from electrovib.solve.nonlinear.electrics import Electrics
from electrovib.solve.nonlinear.finger import follow_finger
from electrovib.solve.stack.keys import DisplacementOf, FieldOf
from electrovib.solve.stack.layer_states import stack_states

AREA = 1e-4
END = 30e-3
TIMES = np.linspace(0, END, 61)
EQUAL = 1e-7
"""Of the largest value of each signal, against the exact solver; measured 3e-9, 3e-8 with skins of papers."""
ELEMENTS = ("bare", "body", "floating", "floating without resistance")
QUICK = ("trapezium",)
"""The drive that takes least."""


@pytest.fixture
def both(drive):
    """Answer by the exact solver and by the general one."""

    def answers(held, name, times=TIMES):
        exact = transient(held.wanted, drive(name), times)
        return exact, follow_finger(held.space, drive(name), times).found

    return answers


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize(
    "name",
    [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in ("chirp", "square", "sine", "burst"))],
)
def test_linear_layers_answer_as_the_exact_solver_says(name, element, finger, drive, both, worst):
    expected, found = both(finger(element, charge=1e-5), name)
    assert worst(expected, found) < EQUAL
    without = transient(finger(element).wanted, drive(name), TIMES)
    assert worst(without, found) > 1e3 * EQUAL  # the charge is seen


@pytest.mark.parametrize(
    ("paper", "skin"),
    [
        ("gabriel_1996", "dry"),
        ("palmar_1995", "moist_men"),
        ("plutchik_1963", "skin"),
        ("vezzoli_2014", "surrogate_0.8025"),
    ],
)
def test_dispersive_skins_of_papers(paper, skin, finger, both, worst):
    """Twelve and more Debye terms in the place of a constant phase."""
    expected, found = both(finger("body", skin=papers()[paper].skins()[skin].material), "trapezium")
    assert worst(expected, found) < EQUAL


def test_second_electrode(finger, both, worst):
    expected, found = both(finger("body", second=2.0), "sine")
    assert worst(expected, found) < EQUAL
    single, _ = both(finger("body"), "sine")
    assert worst(single, found) > 0.1
    for more in ({"charge": 1e-5}, {"leak": LEAKS["field"]}):
        with pytest.raises(InputError, match="Grounded or Floating"):
            assert finger("body", second=1.0, **more).space


@pytest.mark.parametrize("element", ELEMENTS)
def test_charge_alone(element, finger, both, worst):
    """No drive: trapped charge on a film, and what flows because of it."""
    times = np.concatenate([[0.0], np.geomspace(1e-6, 1.0, 40)])
    expected, found = both(finger(element, charge=3e-5), {"model": "Step", "level": 0}, times)
    if element == "bare":
        assert np.max(np.abs(found["stack_voltage"])) < 1e-12
        del expected["stack_voltage"]  # rounding, about a plate held at 0 V
    assert worst(expected, found) < EQUAL


LEAKS = {
    "polarity": PolarityConduction(conductivity_positive=5e-6, conductivity_negative=1e-6),
    "field": FieldConduction(conductivity=2e-6, onset_field=1e4),
}


@pytest.mark.slow
@pytest.mark.parametrize("leak", LEAKS)
@pytest.mark.parametrize("name", ["trapezium", "square", "sine"])
@pytest.mark.parametrize("element", ["bare", "floating"])
def test_one_leak_as_the_march_of_one_branch(name, leak, element, finger, drive, worst):
    held, control = finger(element), FieldOf("stratum_corneum")
    leaking = held.signals(held.leaking("stratum_corneum"))
    given_ = {"leak": LEAKS[leak], "control": control}
    marched = leaky_response(held.wanted, leaking, drive(name), TIMES, **given_)
    followed = follow_finger(finger(element, leak=LEAKS[leak]).space, drive(name), TIMES)
    # the march states the error of one field before it extrapolates: seen are 3e-9 to 3e-6, worst where J has its kink
    assert worst(marched.found, followed.found) < 0.3 * marched.errors["step_error"]
    assert marched.errors["step_error"] < 2e-5
    assert followed.events or leak != "polarity" or name == "trapezium"
    assert "events located" in followed.reason


@pytest.mark.slow
def test_a_leak_in_proportion_is_a_conductivity_whichever_layers_leak(finger, drive, both, worst):
    """Two leaks and a kink with equal sides: the exact solver again."""
    leak, gap_leak = (
        PolarityConduction(conductivity_positive=value, conductivity_negative=value) for value in (2e-6, 3e-9)
    )
    skin = Debye(permittivity_high=300, strength=1200, relaxation_time=2e-3, conductivity=1e-6)
    space = finger("body", leak=leak, gap_leak=gap_leak, skin=skin).space
    expected, _ = both(finger("body", gap=4e-9), "square")
    assert worst(expected, follow_finger(space, drive("square"), TIMES).found) < EQUAL


def test_both_signs_of_a_rectifying_skin(finger, drive):
    """Turning the drive and the polarity round turns everything round."""
    found = []
    for sign in (1.0, -1.0):
        sides = (5e-6, 1e-6)[:: int(sign)]
        leak = PolarityConduction(conductivity_positive=sides[0], conductivity_negative=sides[1])
        square = drive({"model": "Square", "high": sign * 50, "low": sign * -20, "frequency": 50})
        found.append(sign * follow_finger(finger(leak=leak).space, square, TIMES).found[FieldOf("gap")])
    assert np.max(np.abs(found[0] - found[1])) < EQUAL * np.max(np.abs(found[0]))


def test_charge_is_conserved(finger, drive):
    """Between the plate and the finger free charge only moves: the current brings what the fields end with."""
    times, space = np.linspace(0, END, 30001), finger("body", gap=0.0, leak=LEAKS["field"]).space
    found = follow_finger(space, drive("trapezium"), times).found
    brought = np.concatenate([[0.0], np.cumsum((found["current"][1:] + found["current"][:-1]) / 2)])
    brought = brought * (times[1] - times[0]) / AREA
    held = found[DisplacementOf("insulator")]
    # the trapezoidal rule over 1 us across the three corners of the drive, where the current steps
    assert np.max(np.abs(brought - held)) < 2e-4 * np.max(held)
    assert np.max(np.abs(found[DisplacementOf("gap")] - held)) < 1e-9 * np.max(held)  # no charge between them


def powers(low, high):
    return st.floats(low, high).map(lambda power: 10.0**power)


kinks = {"conductivity_positive": powers(-10, -4), "conductivity_negative": powers(-10, -4)}
growing = st.builds(FieldConduction, conductivity=powers(-10, -5), onset_field=powers(4, 6))
leaks = st.one_of(st.none(), st.builds(PolarityConduction, **kinks), growing)
air = st.builds(Constant, permittivity=st.just(1.0), conductivity=st.just(0.0) | powers(-9, -4))
layer = st.builds(Layer, thickness=powers(-6, -3.5), role=st.just("plate"), material=air, leak=leaks)
terms = st.tuples(powers(0, 3), powers(-1, 3), powers(-5, -1))


@pytest.mark.slow
@settings(max_examples=12)
@given(
    drawn=st.lists(st.tuples(layer, terms), min_size=1, max_size=3),
    name=st.sampled_from(["trapezium", "sine"]),
)
def test_a_stack_only_stores_and_loses(drawn, name, drive):
    """Passivity: what the source gives is never less than what is stored more, at any time."""
    layers = {f"layer_{index}": one for index, (one, _) in enumerate(drawn)}
    debye = {
        f"layer_{index}": DebyeSum(high, (by,), (tau,)) for index, (_, (high, by, tau)) in enumerate(drawn)
    }
    space = stack_states(layers, debye, area=AREA, element=SeriesElement(resistance=1e3))
    times = np.linspace(0, END, 3001)
    found = follow_finger(space, drive(name), times).found
    power = found["plate_voltage"] * found["current"]
    given_ = np.concatenate([[0.0], np.cumsum((power[1:] + power[:-1]) / 2)]) * times[1]
    stored = np.zeros(len(times))
    for index, key in enumerate(layers):
        field, permittivity = found[FieldOf(key)], space.permittivities[index]
        polarised = found[DisplacementOf(key)] - permittivity * field
        energy = permittivity * field**2 + polarised**2 / space.strengths[index]
        stored += AREA * space.thicknesses[index] * energy / 2
    # the trapezoidal rule of the power over 10 us
    lost = given_ - stored
    assert np.all(lost >= -1e-3 * np.max(stored))
    assert np.all(np.diff(lost) >= -1e-3 * np.max(stored))


ALL = {"bandwidth": 1500.0, "saturation": 70.0, "source_current": 12e-6, "stray_capacitance": 3e-11}
AMPLIFIERS = {
    "voltage": Amplifier(gain=2.0, saturation=70.0),
    "voltage and pole": Amplifier(gain=2.0, bandwidth=800.0, saturation=45.0),
    "current": Amplifier(source_current=12e-6, sink_current=8e-6),
    "all": Amplifier(gain=1.8, **ALL),
}


@pytest.mark.parametrize("amplifier", AMPLIFIERS)
@pytest.mark.parametrize("name", ["square", "sine"])
def test_several_times_at_once_are_one_after_the_other(amplifier, name, finger, drive):
    """The stages of a step are evaluated together: the same rates and switching functions in every mode."""
    space = finger("body", leak=LEAKS["field"], gap_leak=LEAKS["polarity"]).space
    system = Electrics(space, drive(name), end=END, amplifier=AMPLIFIERS[amplifier])
    state, _ = system.begin()
    system.jump(state, time=0.0)
    times = np.array([1e-3, 2e-3, 5e-3])
    states = np.random.default_rng(1).normal(size=(system.scale.size, 3)) * system.scale[:, None]
    for mode in itertools.product((-1, 0, 1), (-1, 0, 1), (-1, 1)):
        clipped, held, _ = mode
        if (clipped and system.volts == 100) or (held and not system.limited):
            continue
        for asked in (system.rate, system.switches):
            every = zip(states.T, times.tolist(), strict=True)
            expected = np.transpose([asked(state, mode, time=time) for state, time in every])
            found = asked(states, mode, time=times)
            size = np.max(np.abs(expected), axis=1, keepdims=True)
            assert np.all(np.abs(found - expected) <= 1e-12 * size)


def test_an_edge_that_has_decayed_costs_no_steps(finger, drive):
    """60 V over 1 kohm fall within microseconds: they are followed to a billionth of themselves, not of the drive's slope."""
    space = finger("body", gap_leak=LEAKS["polarity"]).space
    found = follow_finger(space, drive("square"), TIMES, amplifier=AMPLIFIERS["voltage"])
    edges = len(drive("square").corners(END)[0])
    assert found.steps < 300 * (edges + len(found.events))
