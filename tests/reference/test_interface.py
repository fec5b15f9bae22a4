"""The field where plate and finger separate: by role and not by name, and in the limit of a vanishing gap."""

from __future__ import annotations

import json

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.physics.force import gap_field
from electrovib.scenario import Scenario, load
from electrovib.solve.nonlinear.finger import follow_finger
from electrovib.solve.simulate import simulate
from electrovib.solve.stack.expand import phasors
from electrovib.solve.stack.keys import FieldOf
from electrovib.solve.stack.layer_states import stack_states

EPS0 = 8.8541878128e-12
AREA = 1e-4
LEAKY = {
    "thickness": 5e-6,
    "material": {"model": "Constant", "permittivity": 5.0, "conductivity": 20e-9},
}
SKIN = {
    "thickness": 200e-6,
    "material": {"model": "Constant", "permittivity": 1560.0, "conductivity": 1.79e-6},
}
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
    return finger.build(drive={"model": "Step", "level": level}, stack=layers, **more)


def diagnostics(trace):
    return {diagnostic["name"]: diagnostic for diagnostic in json.loads(trace.attrs["validity"])}


def test_over_a_plate_that_conducts_the_limit_is_that_of_small_gaps(finger):
    """Johnsen and Rahbek: the force rises while the voltage is held, and so does that of every small gap."""
    limit = simulate(stack(finger, LEAKY), time=LATE).electrostatic_force.values
    assert limit == pytest.approx([0.870, 17.33], abs=5e-3)
    nearest = simulate(stack(finger, LEAKY, 1e-9), time=LATE).electrostatic_force.values
    assert nearest[-1] == pytest.approx(17.23, abs=5e-3)


def test_a_layer_is_what_its_role_says(finger):
    """The same air under another name gives the same digits; without a role the name is refused."""
    scenario = load("vezzoli_2014/fig6_gap")
    drive = {"drive": {"model": "Step", "level": 1000.0}}
    tables = scenario.replace(drive | {"force": {"model": "MaxwellStressInGap"}}).to_dict()
    names = {"insulator": ("film", "plate"), "gap": ("air_gap", "gap"), "stratum_corneum": ("skin", "finger")}
    renamed = {names[old][0]: layer | {"role": names[old][1]} for old, layer in tables["stack"].items()}
    time = np.array([0.0, 1e-3, 0.1])
    ours = simulate(read_model(Scenario, tables), time=time)
    theirs = simulate(read_model(Scenario, tables | {"stack": renamed}), time=time)
    for name in (
        "electrostatic_force",
        "interface_field",
        "field",
        "displacement",
        "mean_force",
        "lateral_force",
    ):
        assert np.array_equal(ours[name].values, theirs[name].values), name
    layers = tables["stack"]
    layers = {"insulator": layers["insulator"], "air_gap": layers["gap"], "skin": layers["stratum_corneum"]}
    with pytest.raises(InputError) as caught:
        read_model(Scenario, tables | {"stack": layers})
    assert len(caught.value.problems) == 2
    assert "stack.air_gap.role" in str(caught.value)


@pytest.mark.parametrize(
    "law",
    ["MaxwellStressInInsulator", "MaxwellStressInStratumCorneum", "EffectiveMedium", "Vezzoli2014Causal"],
)
def test_every_law_follows_the_roles(finger, law):
    scenario = load("vezzoli_2014/fig6").replace({"force": {"model": law}})
    tables = scenario.to_dict()
    film, skin = tables["stack"].values()
    renamed = {"a": film | {"role": "plate"}, "b": skin | {"role": "finger"}}
    time = np.linspace(0, 0.1, 21)
    ours = simulate(scenario, time=time)
    theirs = simulate(read_model(Scenario, tables | {"stack": renamed}), time=time)
    assert np.array_equal(ours.electrostatic_force.values, theirs.electrostatic_force.values)
    assert np.array_equal(ours.mean_force.values, theirs.mean_force.values)


WRONG = {
    "no role": ({"film": LEAKY}, r"stack\.film\.role.*missing.*'plate', 'gap' or 'finger'"),
    "contradicts its name": (
        {"insulator": LEAKY | {"role": "finger"}},
        r"stack\.insulator\.role.*contradicts",
    ),
    "gap behind the finger": (
        {"insulator": LEAKY, "stratum_corneum": SKIN, "gap": {"thickness": 1e-6}},
        r"stack\.gap\.role.*in the order plate, gap, finger",
    ),
    "two gaps": (
        {"insulator": LEAKY, "gap": {"thickness": 1e-6}, "air": {"thickness": 1e-6, "role": "gap"}},
        r"stack\.air\.role.*already the role of 'gap'",
    ),
    "unknown role": (
        {"insulator": LEAKY | {"role": "skin"}},
        r"stack\.insulator\.role.*'plate', 'gap' or 'finger'",
    ),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_role_that_cannot_be_is_refused(finger, case):
    layers, words = WRONG[case]
    with pytest.raises(InputError, match=words):
        finger.build(drive={"model": "Step", "level": 1}, stack=layers)


def random_case(random, finger):
    """One or two layers of the plate, leaky or not, and a skin, over decades."""

    def layer(thickness, conductivity):
        model = {"model": "Constant", "permittivity": float(10 ** random.uniform(0.3, 3.2))}
        if random.random() < 0.4:
            model = {
                "model": "Debye",
                "permittivity_high": float(10 ** random.uniform(0.3, 2)),
                "strength": float(10 ** random.uniform(0, 3)),
                "relaxation_time": float(10 ** random.uniform(-5, -1)),
            }
        return {"thickness": thickness, "material": model | {"conductivity": conductivity}}

    def conductivity():
        return 0.0 if random.random() < 0.4 else float(10 ** random.uniform(-12, -6))

    stack = {"insulator": layer(float(10 ** random.uniform(-6, -4)), conductivity())}
    if random.random() < 0.3:
        first = layer(float(10 ** random.uniform(-6, -4)), conductivity())
        stack = {"base": first | {"role": "plate"}, **stack}
    if random.random() < 0.4:
        stack["insulator"]["initial_charge"] = float(random.uniform(-3e-5, 3e-5))
    stack["stratum_corneum"] = layer(200e-6, float(10 ** random.uniform(-9, -5)))
    path = {"model": "Grounded", "resistance": float(random.choice([0.0, 1e3, 1e6]))}
    if random.random() < 0.3:
        path = {"model": "Floating", "capacitance": 150e-12, "leak": 1e9 if random.random() < 0.5 else None}
    return stack, path


def with_gap(layers, thickness):
    plate = {name: layer for name, layer in layers.items() if name != "stratum_corneum"}
    return plate | {
        "air": {"thickness": thickness, "role": "gap"},
        "stratum_corneum": layers["stratum_corneum"],
    }


def check_limit(seed, finger):
    """Check that the difference from the limit is proportional to the gap and extrapolates to it; return the numbers checked."""
    random = np.random.default_rng(seed)
    layers, path = random_case(random, finger)
    frequency = np.geomspace(1.0, 1e5, 6)
    time = np.concatenate([[0.0], np.geomspace(1e-5, 1.0, 12)])
    level = 100.0

    def found(stack):
        scenario = finger.build(drive={"model": "Step", "level": level}, stack=stack, return_path=path)
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


@pytest.mark.parametrize("path", ["grounded", "floating", "charged body"])
@pytest.mark.parametrize("seed", range(6))
def test_the_general_solver_has_the_same_limit(seed, path, finger):
    """Charge passed up to the interface, by states that know no modes."""
    random = np.random.default_rng(seed)
    layers, _ = random_case(random, finger)
    paths = {
        "grounded": {"model": "Grounded", "resistance": 1e3},
        "floating": {"model": "Floating", "capacitance": 150e-12},
        "charged body": {"model": "Floating", "capacitance": 150e-12, "charge": 2e-9, "leak": 1e8},
    }
    drive = {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 5e-3, "fall": 1e-3}
    scenario = finger.build(drive=drive, stack=layers, return_path=paths[path])
    stack = scenario.stack.layers
    debye = {name: layer.material.debye() for name, layer in stack.items()}
    space = stack_states(stack, debye, area=AREA, element=scenario.circuit.element())
    time = np.linspace(0, 9e-3, 19)
    expected = follow_finger(space, scenario.drive, time, tolerance=1e-10).found[FieldOf("interface")]
    found = simulate(scenario, time=time).interface_field.values
    assert np.max(np.abs(found - expected)) < 1e-7 * np.max(np.abs(expected))
    assert np.max(np.abs(expected)) > 0


def test_charge_reaches_the_interface_behind_an_amplifier_too(finger):
    """A pole and a gain before a plate that conducts: the integral of the current keeps its digits."""
    amplifier = {"gain": 2.0, "bandwidth": 500.0, "stray_capacitance": 1e-10}
    circuit = {"return_path": {"model": "Grounded", "resistance": 1e3}, "amplifier": amplifier}
    scenario = stack(finger, LEAKY, level=25.0).replace({"circuit": circuit})
    time = np.linspace(0, 9e-3, 19)
    layers = scenario.stack.layers
    debye = {name: layer.material.debye() for name, layer in layers.items()}
    space = stack_states(layers, debye, area=AREA, element=scenario.circuit.element())
    followed = follow_finger(
        space, scenario.drive, time, amplifier=scenario.circuit.amplifier, tolerance=1e-10
    )
    expected = followed.found[FieldOf("interface")]
    found = simulate(scenario, time=time).interface_field.values
    assert np.max(np.abs(found - expected)) < 1e-7 * np.max(np.abs(expected))


@pytest.mark.parametrize(("thickness", "permittivity", "share"), [(90e-6, 3.35, 0.995), (1e-6, 3.9, 0.667)])
def test_a_charge_on_the_film_leaves_its_share_in_the_gap(thickness, permittivity, share, finger):
    """The rest of its lines end on the skin's electrode: (T_i/eps_i)/K of the charge is in the gap at 0 V."""
    film = finger.film(thickness, permittivity) | {"initial_charge": 1e-5}
    skin = SKIN if permittivity == 3.35 else SKIN | {"material": SKIN["material"] | {"conductivity": 1e-9}}
    trace = simulate(stack(finger, film, skin=skin, level=0.0), time=np.array([0.0, 1e-9]))
    electrical = thickness / permittivity
    expected = electrical / (electrical + 200e-6 / 1560)
    assert expected == pytest.approx(share, abs=5e-4)
    assert trace.interface_field.values * EPS0 / 1e-5 == pytest.approx(expected, rel=1e-6)
    assert trace.current.values == pytest.approx(0.0, abs=1e-9)  # the plate holds the image before time 0


def test_a_neutral_body_that_floats_begins_neutral(finger):
    """Charge on the film lifts a floating body; a body that gave the charge is drawn down by as much."""
    film = finger.film() | {"initial_charge": 1e-5}
    floating = {"model": "Floating", "capacitance": 150e-12}
    drive = {"model": "Step", "level": 0.0}
    layers, time = {"insulator": film, "stratum_corneum": SKIN}, np.array([0.0, 1.0])
    neutral = simulate(finger.build(drive=drive, stack=layers, return_path=floating), time=time)
    C_i = EPS0 * 3.35 * AREA / 90e-6
    assert -neutral.stack_voltage.values[-1] == pytest.approx(1e-5 * AREA / (C_i + 150e-12), rel=1e-9)
    given = floating | {"charge": -1e-5 * AREA}
    rubbed = simulate(finger.build(drive=drive, stack=layers, return_path=given), time=time)
    assert abs(rubbed.stack_voltage.values[-1]) < 1e-9


PERIODIC = {"model": "Square", "high": 50.0, "low": -50.0, "frequency": 100.0, "edge": 1e-4}


def test_in_the_periodic_state_the_charge_at_the_interface_repeats(finger):
    layers = {"insulator": LEAKY, "stratum_corneum": SKIN}
    settled = finger.build(drive=PERIODIC, stack=layers, resistance=1000.0, settled=True)
    late = finger.build(drive=PERIODIC, stack=layers, resistance=1000.0)
    time = np.linspace(0, 0.01, 41)
    expected = simulate(settled, time=time).interface_field.values
    found = simulate(late, time=time + 4.0).interface_field.values
    found = found - (np.max(found) + np.min(found)) / 2  # from rest it keeps the charge of the beginning
    assert np.max(np.abs(expected - found)) < 1e-9 * np.max(np.abs(expected))


def test_a_periodic_state_with_a_mean_current_into_a_vanishing_gap_is_refused(finger):
    layers = {"insulator": LEAKY, "stratum_corneum": SKIN}
    mean = PERIODIC | {"low": 0.0}
    scenario = finger.build(drive=mean, stack=layers, settled=True)
    with pytest.raises(InputError, match=r"PeriodicState: the drive has a mean of 25 V.*role = 'gap'"):
        simulate(scenario)
    other = simulate(
        scenario.replace({"force": {"model": "MaxwellStressInInsulator"}})
    )  # it does not read the interface
    assert "interface_field" not in other
    gap = finger.build(
        drive=mean,
        stack=with_gap(layers, 1e-6),
        settled=True,
    )
    assert np.all(np.isfinite(simulate(gap).electrostatic_force.values))


def test_a_diagnostic_says_when_no_real_gap_is_small_enough(finger):
    time = np.linspace(0, 0.1, 101)
    trace = simulate(stack(finger, LEAKY), time=time)
    diagnostic = diagnostics(trace)["vanishing gap"]
    share = trace.interface_field.values * 1e-9 / 50.0
    first = time[np.flatnonzero(share > 0.01)[0]]
    assert diagnostic["state"] == "warning"
    assert f"from {1e3 * first:.3g} ms on" in diagnostic["text"]
    assert diagnostic["value"] == pytest.approx(np.max(share), rel=1e-2)
    blocking = diagnostics(simulate(stack(finger, finger.film()), time=time))["vanishing gap"]
    assert blocking["state"] == "ok"
    pulse = {"model": "Trapezium", "high": 50.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}
    layers = {"insulator": LEAKY, "stratum_corneum": SKIN}
    ended = simulate(finger.build(drive=pulse, stack=layers, resistance=1e3), time=np.linspace(0, 5e-3, 51))
    assert 0 < abs(ended.stack_voltage.values[-1]) < 0.1  # the share is that of the largest voltage so far
    assert diagnostics(ended)["vanishing gap"]["state"] == "ok"


def test_a_negative_attraction_says_why(finger):
    """After a discharge the slow part of the skin's polarisation keeps the sign that its field has lost."""
    slow = {
        "model": "Debye",
        "permittivity_high": 100.0,
        "strength": 1500.0,
        "relaxation_time": 1e-3,
        "conductivity": 1e-9,
    }
    drive = {"model": "Trapezium", "high": 100.0, "rise": 1e-5, "hold": 2e-2, "fall": 1e-5}
    layers = {"insulator": finger.film(1e-6, 3.9), "stratum_corneum": {"thickness": 200e-6, "material": slow}}
    scenario = finger.build(drive=drive, stack=layers, force="MaxwellStressInStratumCorneum")
    trace = simulate(scenario, time=np.linspace(0, 0.03, 301))
    assert trace.electrostatic_force.values.min() < 0
    assert (
        "convention of evaluating the stress inside a layer"
        in diagnostics(trace)["negative attraction"]["text"]
    )
    assert "negative attraction" not in diagnostics(
        simulate(scenario.replace({"force": {"model": "MaxwellStressInGap"}}))
    )
