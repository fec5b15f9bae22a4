"""A layer in two pieces of the same material is the same layer: no signal and no answer at any door changes."""

import functools

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.discovery import offers
from electrovib.core.errors import InputError
from electrovib.recordings.fit.of_scenario import fit_scenario
from electrovib.scenario import load
from electrovib.solve.simulate import simulate

SAME = 1e-9
"""Largest change of a signal over its peak."""
SHARE = 0.3
"""Share of the thickness that the piece towards the plate has."""
AS_IT_IS = {"vezzoli_2014/fig2_tremor": "gap"}
"""Layers that have no two pieces: a gap that moves, whose thickness is that of one layer."""


SHIPPED = offers(("scenarios",))
LAYERS = [
    (name, layer)
    for name, scenario in SHIPPED.items()
    for layer in scenario.stack.layers
    if AS_IT_IS.get(name) != layer
]


def split(scenario, *names):
    """Cut layers in two; of a gap the piece towards the plate is air on the plate, because an interface has one gap."""
    found = {}
    for name, layer in scenario.stack.layers.items():
        if name in names:
            role = scenario.stack.roles[name].replace("gap", "plate")
            first = {
                "thickness": SHARE * layer.thickness,
                "initial_charge": 0.0,
                "role": role,
                "material": layer.material,
            }
            found[f"{name}_outside"] = layer.model_copy(update=first)
        left = (1 - SHARE if name in names else 1) * layer.thickness
        found[name] = layer.model_copy(update={"thickness": left})
    return scenario.replace({"stack": type(scenario.stack).model_validate(found)})


def changes(whole, cut):
    """Largest change of each signal over its peak; voltages of pieces add up, fields are equal."""
    found = {}
    for name, row in whole.data_vars.items():
        if "layer" not in row.dims:
            found[name] = change(row.values, cut[name].values)
            continue
        for layer in row.layer.values:
            pieces = [each for each in (f"{layer}_outside", layer) if each in cut.layer]
            rows = [cut[name].sel(layer=each).values for each in pieces]
            rows = [sum(rows)] if name == "field_gain" else rows
            found[f"{name} {layer}"] = max(change(row.sel(layer=layer).values, each) for each in rows)
    return found


def change(one, other):
    known = np.isfinite(one)
    assert np.array_equal(known, np.isfinite(other))
    peak = np.max(np.abs(one[known]), initial=0.0)
    return float(np.max(np.abs(one[known] - other[known]), initial=0.0) / (peak or 1.0))


@functools.cache
def whole(name):
    return simulate(SHIPPED[name])


def check(name, *layers):
    found = changes(whole(name), simulate(split(SHIPPED[name], *layers)))
    assert {signal: size for signal, size in found.items() if not size <= SAME} == {}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name.endswith(("_positive", "_negative")) else ())
        for name in SHIPPED
    ],
)
def test_a_shipped_scenario_simulates_and_all_of_its_layers_in_two_change_no_signal(name):
    """Without a warning, which is an error here, and without a number that is not finite."""
    trace = whole(name)
    for signal, row in trace.data_vars.items():
        rests = signal == "lateral_force" and "friction at rest" in trace.attrs["validity"]
        assert np.all(np.isnan(row.values) if rests else np.isfinite(row.values)), signal
        assert row.attrs["units"]
    assert float(np.max(trace.electrostatic_force)) > 0
    assert trace.attrs["solver"]
    assert trace.attrs["solver_reason"]
    check(name, *(layer for layer in SHIPPED[name].stack.layers if AS_IT_IS.get(name) != layer))


@pytest.mark.slow
@pytest.mark.parametrize(("name", "layer"), LAYERS)
def test_one_layer_of_a_scenario_in_two_changes_no_signal(name, layer):
    check(name, layer)


def test_only_a_gap_that_moves_is_not_cut():
    moving = [name for name, scenario in SHIPPED.items() if scenario.motion.moved_gap is not None]
    assert moving == list(AS_IT_IS)
    assert len(LAYERS) == sum(len(scenario.stack.layers) for scenario in SHIPPED.values()) - 1


def test_the_force_of_the_film_in_pieces_is_that_of_equation_1():
    """0.5655 mN at 100 V, by arithmetic; it was 0.889, 1.097 and 1.910 mN for film, skin and both in two."""
    base = load("vezzoli_2014/fig6_static").replace({"drive": {"model": "Step", "level": 100.0}})
    expected = 8.8541878e-12 * 1e-4 * 100.0**2 / 2 / (90e-6 / 3.35 + 200e-6 / 1560) / 290e-6
    assert expected == pytest.approx(0.5655e-3, rel=1e-4)
    for layers in ((), ("insulator",), ("stratum_corneum",), ("insulator", "stratum_corneum")):
        trace = simulate(split(base, *layers), time=np.array([0.05]))
        assert float(trace.electrostatic_force[-1]) == pytest.approx(expected, rel=1e-6)


def test_moisture_sets_the_skin_in_pieces_as_the_whole():
    """The conductivity is that of the conductance times the whole thickness: sqrt(0.02 x 0.2) S/m2 x 200 um."""
    ranges = {
        "dry_gap_resistivity": 1e12,
        "wet_gap_resistivity": 1e6,
        "dry_coefficient": 0.4,
        "wet_coefficient": 0.8,
    }
    moist = load("vezzoli_2014/fig6_gap").replace({"moisture": {"level": 0.5} | ranges})
    cut = split(moist, "stratum_corneum")
    pieces = [layer.material.conductivity for layer in list(cut.stack.layers.values())[-2:]]
    assert pieces == pytest.approx([200e-6 * np.sqrt(0.02 * 0.2)] * 2, rel=1e-12)
    found = changes(simulate(moist), simulate(cut))
    assert {signal: size for signal, size in found.items() if not size <= SAME} == {}
    with pytest.raises(
        InputError, match=r"stratum_corneum_outside\.material\.conductivity: is set by moisture"
    ):
        cut.replace({"stack.stratum_corneum_outside.material.conductivity": 1e-6})


BOTH = ("insulator", "stratum_corneum")
AREA = {"contact.area": {"model": "LogNormal", "median": 1e-4, "factor": 1.3}}
SINE = {
    "drive": {"model": "Sine", "amplitude": 100.0, "frequency": 100.0},
    "time": {"duration": 0.02, "samples": 201, "initial_state": {"model": "PeriodicState"}},
    "motion.speed": 0.05,
    "limits": {"voltage": 1e3, "current": 1e-3},
}
GRATING = {"model": "Grating", "period": "2 mm", "amplitude": "1 mN"}
PATH = {"model": "ConstantSpeed", "speed": "50 mm/s", "stroke": "3 mm"}
WANT = {"want": "mean electrostatic_force = 0.3 mN", "free": "drive.amplitude"}
PART = {"share": 0.9, "space": AREA, "seed": 1, "n": 50}


def fitted(one):
    found = fit_scenario(one, recorded(type(one.force).__name__), free=["contact.area"])
    return [*found.estimate.values.values()]


def compared(one):
    return [entry.static for entry in ev.compare(one, models=[type(one.force).__name__]).entries]


DOORS = {
    "texture": lambda one: ev.texture_drive(one, texture=GRATING, path=PATH).voltages,
    "target": lambda one: ev.drive_for_force(one, target="sine 50 Hz 0.5 mN", method="carrier").values,
    "value": lambda one: ev.find_value(one, **WANT).best.value,
    "share": lambda one: ev.value_for_share(one, **WANT, **PART).value,
    "perceive": lambda one: ev.perceive(one).level,
    "compare": compared,
    "study": lambda one: ev.study(one, AREA, n=64, seed=1)["electrostatic_force_mean"].values,
    "fit": fitted,
}


@functools.cache
def founding(law):
    return load("vezzoli_2014/fig6_static").replace({"force.model": law} | SINE)


@functools.cache
def recorded(law):
    """A recording of a finger of 1 cm2, with noise of a hundredth."""
    trace = simulate(founding(law)).copy(deep=True)
    force = trace.electrostatic_force
    noise = np.random.default_rng(1).normal(0.0, 0.01 * float(force.max()), force.shape)
    return trace[["electrostatic_force"]].assign(electrostatic_force=force + noise)


@pytest.mark.parametrize("door", DOORS)
@pytest.mark.parametrize(
    "law", ["EffectiveMedium", pytest.param("Vezzoli2014Causal", marks=pytest.mark.slow)]
)
def test_every_door_answers_the_same_for_layers_in_two(law, door):
    """Texture asked 265.9 V and then 212.1 V, the fit 1 and then 0.636 cm2."""
    whole, cut = DOORS[door](founding(law)), DOORS[door](split(founding(law), *BOTH))
    np.testing.assert_allclose(cut, whole, rtol=1e-6, atol=1e-6 * np.max(np.abs(whole)))
