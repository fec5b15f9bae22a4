"""The field where plate and finger separate: by role and not by name, and in the limit of a vanishing gap."""

import numpy as np
import pytest
import scenario_parts as parts

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.force import gap_field
from electrovib.scenario import Scenario, load
from electrovib.solve.nonlinear.finger import follow_finger
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.solve.stack.keys import FieldOf
from electrovib.solve.stack.layer_states import stack_states

LEAKY = parts.layer(5e-6, parts.constant(5.0, 20e-9))
SKIN = parts.layer(200e-6, parts.constant(1560.0, 1.79e-6))
LAYERS = {"insulator": LEAKY, "stratum_corneum": SKIN}
LATE = np.array([0.0, 9e-3])
EXTRAPOLATION = 5e-3
"""Of the limit from gaps of 10 and 1 nm: what is left out is the square of a share of at most 1 % and 10 %."""

ORDER = 0.1
"""Departure of the measured order of convergence from 1, while a gap changes the field by less than 5 %: the second order, and
more of it where the differences of a charged film have just passed zero."""
ROUNDING = 1e-9
"""Of the field, which a difference has to exceed by far to be compared."""


def stack(finger, film, gap=None, skin=SKIN, level=50.0, **more):
    between = {} if gap is None else {"gap": {"thickness": gap}}
    layers = {"insulator": film, **between, "stratum_corneum": skin}
    return finger.build(drive=parts.step(level), stack=layers, **more)


def test_over_a_plate_that_conducts_the_limit_is_that_of_small_gaps(finger):
    """Johnsen and Rahbek: the force rises while the voltage is held, and so does that of every small gap."""
    limit = simulate(stack(finger, LEAKY), time=LATE).electrostatic_force.values
    assert limit == pytest.approx([0.870, 17.33], abs=5e-3)
    nearest = simulate(stack(finger, LEAKY, 1e-9), time=LATE).electrostatic_force.values
    assert nearest[-1] == pytest.approx(17.23, abs=5e-3)


ROLES = {"insulator": "plate", "gap": "gap", "stratum_corneum": "finger"}
LAWS = ["MaxwellStressInInsulator", "MaxwellStressInStratumCorneum", "EffectiveMedium", "Vezzoli2014Causal"]


@pytest.mark.parametrize(
    ("preset", "law"), [("fig6_gap", "MaxwellStressInGap"), *[("fig6", law) for law in LAWS]]
)
def test_a_layer_is_what_its_role_says(preset, law):
    """The same layers under other names give the same digits; without a role a name is refused."""
    changes = {"drive": parts.step(1000.0)} if preset == "fig6_gap" else {}
    tables = load(f"vezzoli_2014/{preset}").replace(changes | {"force": {"model": law}}).to_dict()
    layers = tables["stack"]
    renamed = {f"my_{name}": given | {"role": ROLES[name]} for name, given in layers.items()}
    time = np.linspace(0, 0.1, 21)
    ours = simulate(read_model(Scenario, tables), time=time)
    theirs = simulate(read_model(Scenario, tables | {"stack": renamed}), time=time)
    for name in set(ours.data_vars):
        assert np.array_equal(ours[name].values, theirs[name].values), name
    assert {"electrostatic_force", "field", "displacement", "mean_force", "lateral_force"} <= set(ours)
    if "gap" in layers:
        unknown = {f"my_{name}" if name != "insulator" else name: given for name, given in layers.items()}
        with pytest.raises(InputError, match=r"stack\.my_gap\.role") as caught:
            read_model(Scenario, tables | {"stack": unknown})
        assert len(caught.value.problems) == 2


GAP = {"thickness": 1e-6}
WRONG = [
    ({"film": LEAKY}, r"stack\.film\.role.*missing.*'plate', 'gap' or 'finger'"),
    ({"insulator": LEAKY | {"role": "finger"}}, r"stack\.insulator\.role.*contradicts"),
    (LAYERS | {"gap": GAP}, r"stack\.gap\.role.*in the order plate, gap, finger"),
    (
        {"insulator": LEAKY, "gap": GAP, "air": GAP | {"role": "gap"}},
        r"stack\.air\.role.*already the role of 'gap'",
    ),
    ({"insulator": LEAKY | {"role": "skin"}}, r"stack\.insulator\.role.*'plate', 'gap' or 'finger'"),
]


@pytest.mark.parametrize(("layers", "words"), WRONG)
def test_a_role_that_cannot_be_is_refused(finger, layers, words):
    with pytest.raises(InputError, match=words):
        finger.build(drive=parts.step(1), stack=layers)


def random_case(random, finger):
    """One or two layers of the plate, leaky or not, and a skin, over decades."""

    def power(low, high):
        return float(10 ** random.uniform(low, high))

    def conductivity():
        return 0.0 if random.random() < 0.4 else power(-12, -6)

    def drawn(thickness, conductivity):
        material = parts.constant(power(0.3, 3.2), conductivity)
        if random.random() < 0.4:
            material = parts.debye(power(0.3, 2), power(0, 3), power(-5, -1), conductivity)
        return parts.layer(thickness, material)

    stack = {"insulator": drawn(power(-6, -4), conductivity())}
    if random.random() < 0.3:
        stack = {"base": drawn(power(-6, -4), conductivity()) | {"role": "plate"}, **stack}
    if random.random() < 0.4:
        stack["insulator"]["initial_charge"] = float(random.uniform(-3e-5, 3e-5))
    stack["stratum_corneum"] = drawn(200e-6, power(-9, -5))
    path = parts.grounded(float(random.choice([0.0, 1e3, 1e6])))
    if random.random() < 0.3:
        path = parts.floating(leak=1e9 if random.random() < 0.5 else None)
    return stack, path


def with_gap(layers, thickness):
    *plate, (skin, own) = layers.items()
    return dict(plate) | {"air": {"thickness": thickness, "role": "gap"}, skin: own}


def check_limit(seed, finger):
    """Check that the difference from the limit is proportional to the gap and extrapolates to it; return the numbers checked."""
    random = np.random.default_rng(seed)
    layers, path = random_case(random, finger)
    frequency = np.geomspace(1.0, 1e5, 6)
    time = np.concatenate([[0.0], np.geomspace(1e-5, 1.0, 12)])
    level = 100.0

    def found(stack):
        scenario = finger.build(drive=parts.step(level), stack=stack, return_path=path)
        trace = simulate(scenario, time=time)
        assert trace.attrs["solver"] == "transient"
        return trace.interface_field.values, gap_field(phasors(scenario, frequency))

    limits = found(layers)
    at = {gap: found(with_gap(layers, gap)) for gap in (1e-7, 1e-8, 1e-9)}
    held = proportional = 0
    for domain, size in ((0, level), (1, 1.0)):
        limit, hundred, ten, one = limits[domain], *(at[gap][domain] for gap in (1e-7, 1e-8, 1e-9))
        narrow = np.abs(one) * 1e-9 < 0.01 * size
        scale = np.maximum(np.abs(limit), 1e-3 * np.max(np.abs(limit)))  # the field may cross zero
        extrapolated = (10 * one - ten) / 9
        assert np.all((np.abs(extrapolated - limit) < EXTRAPOLATION * scale)[narrow]), seed
        for wide, fine in ((hundred, ten), (ten, one)):
            change, rest = np.abs(wide - limit) / scale, np.abs(fine - limit) / scale
            shown = narrow & (rest > 1e4 * ROUNDING) & (change < 0.05)
            if np.any(shown):  # together: where a difference passes zero, its own ratio says nothing
                ratio = float(np.linalg.norm(change[shown]) / np.linalg.norm(rest[shown]))
                assert abs(np.log10(ratio) - 1) < ORDER, seed
                proportional += np.count_nonzero(shown)
        held += np.count_nonzero(narrow)
    return held, proportional


@pytest.mark.parametrize("seed", range(12))
def test_small_gaps_tend_to_the_limit(seed, finger):
    check_limit(seed, finger)


@pytest.mark.slow
def test_small_gaps_of_200_stacks_tend_to_the_limit(finger):
    counts = np.sum([check_limit(seed, finger) for seed in range(1000, 1200)], axis=0)
    assert np.all(counts > 200 * 19 / 2), counts  # most times and frequencies were compared


def check_against_states(scenario):
    """Charge passed up to the interface, by states that know no modes."""
    stack, circuit = scenario.stack.layers, scenario.circuit
    debye_sums = {name: given.material.debye() for name, given in stack.items()}
    space = stack_states(stack, debye_sums, area=parts.AREA, element=circuit.element())
    time = np.linspace(0, 9e-3, 19)
    behind = {"amplifier": circuit.amplifier} if circuit.amplifier else {}
    followed = follow_finger(space, scenario.drive, time, **behind)
    expected = followed.found[FieldOf("interface")]
    found = simulate(scenario, time=time).interface_field.values
    assert np.max(np.abs(found - expected)) < 1e-7 * np.max(np.abs(expected))
    assert np.max(np.abs(expected)) > 0


PATHS = {
    "grounded": parts.grounded(1e3),
    "floating": parts.floating(),
    "charged body": parts.floating(charge=2e-9, leak=1e8),
}


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("seed", [0, *(pytest.param(each, marks=pytest.mark.slow) for each in (1, 2))])
def test_the_general_solver_has_the_same_limit(seed, path, finger):
    layers, _ = random_case(np.random.default_rng(seed), finger)
    drive = parts.trapezium(100.0, 1e-3, 5e-3, 1e-3)
    check_against_states(finger.build(drive=drive, stack=layers, return_path=PATHS[path]))


def test_charge_reaches_the_interface_behind_an_amplifier_too(finger):
    """A pole and a gain before a plate that conducts: the integral of the current keeps its digits."""
    amplifier = {"gain": 2.0, "bandwidth": 500.0, "stray_capacitance": 1e-10}
    circuit = {"return_path": parts.grounded(1e3), "amplifier": amplifier}
    check_against_states(stack(finger, LEAKY, level=25.0).replace({"circuit": circuit}))


@pytest.mark.parametrize(("thickness", "permittivity", "share"), [(90e-6, 3.35, 0.995), (1e-6, 3.9, 0.667)])
def test_a_charge_on_the_film_leaves_its_share_in_the_gap(thickness, permittivity, share, finger):
    """The rest of its lines end on the skin's electrode: (T_i/eps_i)/K of the charge is in the gap at 0 V."""
    film = finger.film(thickness, permittivity) | {"initial_charge": 1e-5}
    skin = parts.layer(200e-6, parts.constant(1560.0, 1.79e-6 if permittivity == 3.35 else 1e-9))
    trace = simulate(stack(finger, film, skin=skin, level=0.0), time=np.array([0.0, 1e-9]))
    electrical = thickness / permittivity
    expected = electrical / (electrical + 200e-6 / 1560)
    assert expected == pytest.approx(share, abs=5e-4)
    assert trace.interface_field.values * parts.EPS0 / 1e-5 == pytest.approx(expected, rel=1e-6)
    assert trace.current.values == pytest.approx(0.0, abs=1e-9)  # the plate holds the image before time 0


def test_a_neutral_body_that_floats_begins_neutral(finger):
    """Charge on the film lifts a floating body; a body that gave the charge is drawn down by as much."""
    layers = {"insulator": finger.film() | {"initial_charge": 1e-5}, "stratum_corneum": SKIN}

    def at_last(path):
        scenario = finger.build(drive=parts.step(0.0), stack=layers, return_path=path)
        return simulate(scenario, time=np.array([0.0, 1.0])).stack_voltage.values[-1]

    film = parts.EPS0 * 3.35 * parts.AREA / 90e-6
    assert -at_last(parts.floating()) == pytest.approx(1e-5 * parts.AREA / (film + 150e-12), rel=1e-9)
    assert abs(at_last(parts.floating(charge=-1e-5 * parts.AREA))) < 1e-9


PERIODIC = parts.square(50.0, 100.0, low=-50.0, edge=1e-4)


def test_in_the_periodic_state_the_charge_at_the_interface_repeats(finger):
    settled = finger.build(drive=PERIODIC, stack=LAYERS, resistance=1000.0, settled=True)
    late = finger.build(drive=PERIODIC, stack=LAYERS, resistance=1000.0)
    time = np.linspace(0, 0.01, 41)
    expected = simulate(settled, time=time).interface_field.values
    found = simulate(late, time=time + 4.0).interface_field.values
    found = found - (np.max(found) + np.min(found)) / 2  # from rest it keeps the charge of the beginning
    assert np.max(np.abs(expected - found)) < 1e-9 * np.max(np.abs(expected))


def test_a_periodic_state_with_a_mean_current_into_a_vanishing_gap_is_refused(finger):
    mean = PERIODIC | {"low": 0.0}
    scenario = finger.build(drive=mean, stack=LAYERS, settled=True)
    with pytest.raises(InputError, match=r"PeriodicState: the drive has a mean of 25 V.*role = 'gap'"):
        simulate(scenario)
    other = simulate(scenario.replace({"force": {"model": "MaxwellStressInInsulator"}}))
    assert "interface_field" not in other  # it is not read
    gap = finger.build(drive=mean, stack=with_gap(LAYERS, 1e-6), settled=True)
    assert np.all(np.isfinite(simulate(gap).electrostatic_force.values))


def test_a_diagnostic_says_when_no_real_gap_is_small_enough(finger):
    time = np.linspace(0, 0.1, 101)
    trace = simulate(stack(finger, LEAKY), time=time)
    diagnostic = parts.diagnostics(trace)["vanishing gap"]
    share = trace.interface_field.values * 1e-9 / 50.0
    first = time[np.flatnonzero(share > 0.01)[0]]
    assert diagnostic["state"] == "warning"
    assert f"from {1e3 * first:.3g} ms on" in diagnostic["text"]
    assert diagnostic["value"] == pytest.approx(np.max(share), rel=1e-2)
    blocking = parts.diagnostics(simulate(stack(finger, finger.film()), time=time))["vanishing gap"]
    assert blocking["state"] == "ok"
    pulse = parts.trapezium(50.0, 1e-3, 1e-3, 1e-3)
    ended = simulate(finger.build(drive=pulse, stack=LAYERS, resistance=1e3), time=np.linspace(0, 5e-3, 51))
    assert 0 < abs(ended.stack_voltage.values[-1]) < 0.1  # the share is that of the largest voltage so far
    assert parts.diagnostics(ended)["vanishing gap"]["state"] == "ok"


def test_a_negative_attraction_says_why(finger):
    """After a discharge the slow part of the skin's polarisation keeps the sign that its field has lost."""
    skin = parts.layer(200e-6, parts.debye(100.0, 1500.0, 1e-3, 1e-9))
    layers = {"insulator": finger.film(1e-6, 3.9), "stratum_corneum": skin}
    drive = parts.trapezium(100.0, 1e-5, 2e-2, 1e-5)
    scenario = finger.build(drive=drive, stack=layers, force="MaxwellStressInStratumCorneum")
    trace = simulate(scenario, time=np.linspace(0, 0.03, 301))
    assert trace.electrostatic_force.values.min() < 0
    said = parts.diagnostics(trace)["negative attraction"]["text"]
    assert "convention of evaluating the stress inside a layer" in said
    gap = simulate(scenario.replace({"force": {"model": "MaxwellStressInGap"}}))
    assert "negative attraction" not in parts.diagnostics(gap)
