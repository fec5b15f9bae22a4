"""Every run says what may break down or exceeds a declared limit, whatever output times were asked for."""

import math

import numpy as np
import pytest
from scipy.constants import epsilon_0
from scipy.optimize import brentq

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import InputError
from electrovib.solve.expanded import walked
from electrovib.solve.stack.expand import modes

AREA, FILM, SKIN = 1e-4, 90e-6 / 3.35, 200e-6 / 1560
CAPACITANCE = eps0 * AREA / (FILM + SKIN)
RAMP = {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}
HELD = {"model": "Step", "level": 100.0}
BARE = {"circuit.return_path.resistance": 0.0}
IN_GAP = {"force": {"model": "MaxwellStressInGap"}}
PERIODIC = {"time.initial_state": {"model": "PeriodicState"}}


def told(scenario, changes=None, **how):
    return {each.name: each for each in diagnostics_of(ev.simulate(scenario.replace(changes or {}), **how))}


def second_electrode(area):
    return {"circuit.return_path": {"model": "SecondElectrode", "area": area, "resistance": 0.0}}


def polarity(up, down):
    return {"model": "PolarityConduction", "conductivity_positive": up, "conductivity_negative": down}


@pytest.fixture(scope="module")
def vezzoli():
    """Film and skin; nothing conducts, so that everything is a quotient of thicknesses."""
    return ev.load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material.conductivity": 0.0})


@pytest.fixture(scope="module")
def with_gap(vezzoli):
    stack = vezzoli.to_dict()["stack"]
    names = ["insulator", "gap", "stratum_corneum"]
    return vezzoli.replace({"stack": {name: stack.get(name, {"thickness": 5e-6}) for name in names}})


def test_fifty_kilovolts_on_the_film_of_vezzoli(vezzoli):
    found = told(vezzoli, {"drive.high": "50 kV"})
    film = found["film strength, insulator"]
    assert film.state == "warning"
    assert film.value == pytest.approx(50e3 / (FILM + SKIN) / 3.35, rel=1e-4)  # 1 kohm takes the rest
    assert film.limit == 100e6  # of PET, 100 um
    emission = found["field emission"]
    assert (emission.state, emission.value) == ("warning", pytest.approx(50e3 / (FILM + SKIN), rel=1e-4))
    assert "vanishing" in emission.text


def test_a_film_in_two_is_as_strong_as_in_one(vezzoli):
    """Strength falls with thickness, and that of the slab counts: 27 and 63 um were compared with 157.5 and 115 MV/m."""
    pieces = {}
    for name, layer in vezzoli.to_dict()["stack"].items():
        outside = {"thickness": 0.3 * layer["thickness"], "role": vezzoli.stack.roles[name]}
        pieces[f"{name}_outside"] = layer | outside
        pieces[name] = layer | {"thickness": 0.7 * layer["thickness"]}
    for drive in ({"drive.high": "1 kV"}, {"drive.high": "50 kV"}):
        whole, cut = told(vezzoli, drive), told(vezzoli, drive | {"stack": pieces})
        for kind, name in (("film strength", "insulator"), ("linear skin", "stratum_corneum")):
            for piece in (name, f"{name}_outside"):
                one, two = whole[f"{kind}, {name}"], cut[f"{kind}, {piece}"]
                assert (two.state, two.limit) == (one.state, one.limit)
                assert two.value == pytest.approx(one.value, rel=1e-9)


def test_every_layer_of_the_plate_and_of_the_finger_is_judged(vezzoli):
    """Two films and two layers of finger, of other names; the declared strength of one comes before its kind's."""

    def layer(role, thickness, permittivity, **more):
        material = {"model": "Constant", "permittivity": permittivity}
        return {"role": role, "thickness": thickness, "material": material} | more

    stack = {
        "lower": layer("plate", "45 um", 3.35, breakdown_field="10 MV/m"),
        "upper": layer("plate", "45 um", 3.35),
        "outer": layer("finger", "100 um", 1560),
        "inner": layer("finger", "100 um", 1560, breakdown_field="10 kV/m"),
    }
    found = told(vezzoli, {"stack": stack} | IN_GAP)
    assert found["film strength, lower"].state == "warning"  # 11.06 MV/m
    assert found["film strength, upper"].state == "ok"
    assert found["film strength, inner"].state == "warning"  # 23.7 kV/m
    assert {"linear skin, outer", "linear skin, inner"} <= set(found)
    assert found["electrowetting"].limit == pytest.approx(math.sqrt(2 * 0.072 * FILM / eps0), rel=1e-12)
    assert "Paschen" not in found


def test_a_gap_is_judged_by_paschen_and_field_emission(with_gap):
    wide = {"stack.gap.thickness": "28 um"}
    found = told(with_gap, wide | {"drive.high": 800.0})["Paschen"]
    assert found.value == pytest.approx(800 * 28e-6 / (28e-6 + FILM + SKIN), rel=1e-4)
    assert found.state == "warning"  # from 789 V on, facts of the rig of Vezzoli et al. 2014
    assert told(with_gap, wide | {"drive.high": 780.0})["Paschen"].state == "ok"
    thin = told(with_gap, {"stack.gap.thickness": "1 um"})
    assert (thin["Paschen"].state, thin["field emission"].state) == ("unknown", "ok")


SINE = {"model": "Sine", "amplitude": 300.0, "frequency": 777.0, "phase": 0.123}
BURST = {"model": "Burst", "amplitude": 150.0, "frequency": 3e3, "cycles": 4, "delay": 1e-3}
DRIVES = {
    "pulse": RAMP | {"high": 300.0, "delay": 2e-3, "rise": 1e-6, "hold": 5e-6, "fall": 1e-6},
    "sine": SINE,
    "two": {"model": "Sum", "drives": [SINE | {"amplitude": 200.0, "phase": 0.0}, BURST]},
    "square": {"model": "Square", "high": 300.0, "frequency": 400.0, "edge": 2e-6},
}
AMPLIFIER = {"gain": 1.0, "stray_capacitance": 1e-10}
TREMBLE = {"model": "TremblingDistance", "mean": 20e-6, "amplitude": 15e-6, "frequency": 300.0}
LEAK = {"stack.gap.leak": polarity(1e-8, 2e-8)}
STACKS = {
    "closed form": {},
    "behind an amplifier": {"circuit.amplifier": AMPLIFIER | {"bandwidth": 2e4}},
    "amplifier with limits": {"circuit.amplifier": AMPLIFIER | {"source_current": 1e-4}},
    "leak": LEAK,
    "moving gap": {"motion.distance": TREMBLE},
    "general reference": LEAK | {"stack.insulator.leak": polarity(1e-9, 1e-9)},
}
QUICK = {"closed form": DRIVES, "behind an amplifier": ("pulse", "two"), "leak": ("pulse", "sine")}
QUICK |= {
    "moving gap": ("pulse", "square"),
    "amplifier with limits": ("pulse",),
    "general reference": ("pulse",),
}
CASES = [
    pytest.param(stack, drive, marks=() if drive in drives else pytest.mark.slow)
    for stack, drives in QUICK.items()
    for drive in DRIVES
    if drive == "pulse" or stack not in ("amplifier with limits", "general reference")
]
LIMITS = {"voltage": 100, "current": 1e-4, "charge": 1e-9, "stored_energy": 1e-6, "body_current": 1e-4}


@pytest.mark.parametrize(("stack", "drive"), CASES)
def test_checks_do_not_depend_on_the_output_times(with_gap, stack, drive):
    """Two times that miss everything, and four thousand that do not: the same largest values."""
    skin = {"stack.stratum_corneum.material.conductivity": 2e-6, "circuit.return_path.resistance": 1e4}
    one = with_gap.replace(skin | {"limits": LIMITS} | STACKS[stack] | {"drive": DRIVES[drive]})
    end = 4e-3
    few, trace = told(one, time=[0.9 * end, end]), ev.simulate(one, time=np.linspace(0.0, end, 4001))
    shares, others = (
        {
            each.name: each.value / each.limit
            for each in found
            if each.value is not None and each.name != "sampling"
        }
        for found in (few.values(), diagnostics_of(trace))
    )
    assert {"field emission", "current", "voltage", "charge", "stored energy", "body current"} <= set(shares)
    assert shares == pytest.approx(others, rel=2e-4)
    # ... and no smaller than what the many times show
    largest = float(np.abs(trace.field.sel(layer="gap")).max())
    assert few["field emission"].value >= largest * (1 - 1e-5)
    body = max(found.value for name, found in few.items() if name.startswith("body current"))
    assert body >= float(np.abs(trace.current).max()) * (1 - 1e-5)


def test_a_sines_largest_values_are_met_between_evaluation_times(vezzoli):
    """300 V of 777 Hz from the periodic state: |i| = C V w and E = V/(T eps_film/eps0) to 1e-6."""
    one, time = vezzoli.replace({"drive": SINE} | IN_GAP | PERIODIC | BARE), np.array([0.0, 1e-9])
    peaks = walked(one, modes(one, time)[0], time).peaks.peaks()
    assert peaks["interface"] == pytest.approx(300 / (FILM + SKIN), rel=1e-6)
    assert peaks["current"] == pytest.approx(CAPACITANCE * 300 * 2 * np.pi * 777, rel=1e-6)
    assert peaks["charge"] == pytest.approx(CAPACITANCE * 300, rel=1e-6)
    assert peaks["stored_energy"] == pytest.approx(CAPACITANCE * 300**2 / 2, rel=1e-6)


STRAY, BODY = 50e-12, 20e-12
TWICE = {"gain": 2.0, "stray_capacitance": STRAY}
ACROSS = 200 * BODY / (BODY + CAPACITANCE)
"""Of 200 V: a floating body of 20 pF takes part of the voltage from the layers, and none from plate and cable."""


@pytest.mark.parametrize(
    ("circuit", "expected"),
    [
        (
            {"amplifier": TWICE, "return_path": {"model": "Grounded", "resistance": 0.0}},
            {
                "voltage": 200.0,
                "current": (CAPACITANCE + STRAY) * 200e3,
                "charge": CAPACITANCE * 200,
                "stored energy": (CAPACITANCE + STRAY) * 200**2 / 2,
                "body current": CAPACITANCE * 200e3,
            },
        ),
        (
            {"amplifier": TWICE, "return_path": {"model": "Floating", "capacitance": BODY}},
            {"stored energy": (CAPACITANCE * ACROSS**2 + STRAY * 200**2) / 2},
        ),
        # the second contact of half the area is in series: q^2/2 (1/C_1 + 1/C_2) in both
        (
            {"return_path": {"model": "SecondElectrode", "area": AREA / 2, "resistance": 0.0}},
            {"charge": CAPACITANCE / 3 * 100, "stored energy": CAPACITANCE / 3 * 100**2 / 2},
        ),
    ],
    ids=["grounded", "floating", "two contacts"],
)
def test_each_limit_is_defined(vezzoli, circuit, expected):
    """100 V after 1 ms of ramp: voltage of the plate, Q = C V on it, C V^2/2 in contact and stray."""
    limits = {"voltage": 1.0, "current": 1e-9, "charge": 1e-12, "stored_energy": 1e-12, "body_current": 1e-9}
    found = told(vezzoli, {"drive": RAMP, "circuit": circuit, "limits": limits})
    for name, value in expected.items():
        assert (found[name].state, found[name].value) == ("warning", pytest.approx(value, rel=1e-6)), name


@pytest.mark.parametrize("which", ["first", "second"])
def test_the_smaller_of_two_contacts_is_judged(with_gap, which):
    """Two capacitors in series: that of half the area takes 2/3 of the voltage, on whichever electrode it is."""
    one, other = ("0.5 cm2", "1 cm2") if which == "first" else ("1 cm2", "0.5 cm2")
    contacts = {"contact.area": one} | second_electrode(other)
    scenario = with_gap.replace({"drive": RAMP | {"high": 3000.0}} | contacts)
    found, field = told(scenario), 2000 / (FILM + SKIN + 5e-6)
    expected = {
        "film strength, insulator": field / 3.35,
        "Paschen": field * 5e-6,
        "field emission": field,
        "linear skin, stratum_corneum": field * SKIN,
        "electrowetting": 2000,
    }
    rows = {row.quantity: row for row in ev.check(scenario).rows}
    swept = {each.name: each for each in diagnostics_of(ev.sweep(scenario, {"limits.charge": [1e-3, 2e-3]}))}
    for name, value in expected.items():
        assert found[name].value == pytest.approx(value, rel=1e-6)
        assert found[name].text.endswith(f"; judged at the {which} contact, the smaller of the two")
        assert swept[name].value == pytest.approx(value, rel=1e-6)
        if name in rows:
            assert rows[name].value == pytest.approx(value, rel=1e-6)
            assert f"at the {which} contact" in rows[name].source  # which the table of the command shows
    assert {"film strength, insulator", "Paschen", "field emission"} <= set(rows)


def test_two_contacts_of_one_area_are_judged_as_one(with_gap):
    """Each takes half of the voltage, and neither is named."""
    single = told(with_gap, {"drive.high": 500.0} | BARE)
    both = told(with_gap, {"drive.high": 1000.0} | second_electrode(with_gap.contact_area))
    for name in ("film strength, insulator", "Paschen", "field emission", "electrowetting"):
        assert both[name].text == single[name].text


def test_nothing_is_said_of_what_is_not_declared(vezzoli):
    found = told(vezzoli, {"drive": {"model": "Square", "high": 100.0, "frequency": 200.0}, "limits": {}})
    assert not {"voltage", "current", "charge", "stored energy", "body current"} & set(found)
    texts = " ".join(each.text for name, each in found.items() if name != "film strength, insulator")
    assert not [word for word in ("amplifier", "limits.", "250 uA", "declared") if word in texts]
    assert "100 mA" in found["discontinuity"].text


def test_the_step_at_time_0_is_reported_apart(vezzoli):
    """A cosine of 100 V on 1 kohm: 100 mA as it is switched on, C V w = 5.85 mA in the periodic state at 284 kHz."""
    frequency = 5.85e-3 / (2 * np.pi * CAPACITANCE * 100)
    cosine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": frequency, "phase": np.pi / 2}}
    cosine |= {"limits": {"current": "10 mA", "body_current": "10 mA"}}
    found = told(vezzoli, cosine)
    for name in ("current", "body current"):
        assert (found[name].state, found[name].value) == ("ok", pytest.approx(5.85e-3, rel=3e-3))
        switched = found[f"{name} at switch-on"]
        assert (switched.state, switched.value) == ("warning", pytest.approx(0.1, rel=1e-6))
    assert "at time 0 only" in found["discontinuity"].text
    found = told(vezzoli, cosine | PERIODIC)
    assert not {"discontinuity", "current at switch-on"} & set(found)
    assert found["current"].value == pytest.approx(5.85e-3, rel=3e-3)
    # a drive that does not repeat reports its step apart too
    found = told(vezzoli, {"drive": RAMP | {"low": 20.0}, "limits": {"current": "1 mA"}})
    assert found["current"].value == pytest.approx(CAPACITANCE * 80e3, rel=1e-6)
    assert found["current at switch-on"].value == pytest.approx(20e-3, rel=1e-9)


@pytest.mark.parametrize(
    "drive", [DRIVES["square"] | {"edge": 0.0}, RAMP | {"delay": 1e-3, "rise": 0.0}], ids=["square", "late"]
)
def test_no_series_resistance_and_a_discontinuity(vezzoli, drive):
    found = told(vezzoli, {"drive": drive, "limits": {"current": "1 A"}} | BARE)["current"]
    assert (found.state, found.value) == ("warning", None)
    assert "no bound" in found.text


def test_a_current_that_is_largest_just_before_a_corner(vezzoli):
    """Film and skin conduct so well that the current follows the voltage, C dV/dt turns it at the tip: 1 ms up and down."""
    lengths = {"insulator": 90.0, "stratum_corneum": 200.0}
    leaky = {f"stack.{name}.material.conductivity": 1e-6 * length for name, length in lengths.items()}
    one = vezzoli.replace(leaky | {"drive": RAMP | {"hold": 0.0}, "limits": {"current": "1 mA"}})
    found = told(one, time=np.array([0.0, 2e-3]))["current"].value
    before = ev.simulate(one, time=np.array([1e-3 * (1 - 1e-9)]))
    assert found == pytest.approx(float(before.current[0]), rel=1e-6)


def test_equilibrium_judges_too(with_gap):
    spring = {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "40 um"}
    floating = {"model": "Floating", "capacitance": "100 pF"}
    held = {"drive": HELD | {"level": 1e3}, "contact.surface": spring, "circuit.return_path": floating}
    limits = {"voltage": "500 V", "charge": "1 nC", "stored_energy": "1 nJ", "current": "1 A"}
    conducts = {"stack.stratum_corneum.material.conductivity": 1e-6, "load.normal_force": 0.5}
    scenario = with_gap.replace(held | conducts | IN_GAP | {"limits": limits, "contact.area": AREA})
    found = ev.equilibrium(scenario)
    judged = {diagnostic.name: diagnostic for diagnostic in found.diagnostics}
    (state,) = found.states
    field = 1000 / (FILM + eps0 * AREA / 100e-12 + state.gap)
    charge = eps0 * field * AREA
    expected = {
        "Paschen": field * state.gap,
        "film strength, insulator": field / 3.35,
        "field emission": field,
        "linear skin, stratum_corneum": 0,
        "voltage": 1000.0,
        "charge": charge,
        "stored energy": charge * field * (FILM + state.gap) / 2,
    }
    assert {name: judged[name].value for name in expected} == pytest.approx(expected, rel=1e-9)
    assert judged["voltage"].state == "warning"
    assert "current" not in judged
    thin = {"thickness": "1 um", "material": {"model": "Constant", "permittivity": 5}}
    grounded = {"circuit.return_path": {"model": "Grounded"}}
    near = ev.equilibrium(scenario.replace({"stack.insulator": thin} | grounded))
    states = {diagnostic.name: diagnostic.state for diagnostic in near.diagnostics}
    assert len(near.states) == 3
    # Paschen's law of the open state; of the closed one it says nothing
    names = ("field emission", "film strength, insulator", "Paschen")
    assert [states[name] for name in names] == ["warning", "unknown", "warning"]


def test_export_refuses_what_breaks_a_limit_and_what_run_refuses(vezzoli, tmp_path):
    place = tmp_path / "circuit.cir"
    with pytest.raises(InputError, match=r"above 1 nA: the declared limit \(limits.current\)"):
        ev.export(vezzoli, place, set={"limits.current": "1 nA"})
    with pytest.raises(InputError, match=r"limits.voltage.*\n.*limits.charge"):
        ev.export(vezzoli, place, set={"limits": {"voltage": "1 V", "charge": "1 pC"}})
    lag = {"model": "FirstOrderLag", "steady": {"model": "Coulomb", "coefficient": 0.5}, "cut_off": 100.0}
    press = {"model": "Press", "begin": 0.05, "rise": 0.05}
    for changes, words in (
        ({"stack.insulator.leak": polarity(1e-9, 2e-9)}, "PeriodicState"),
        ({"friction": lag, "load.time_profile": press}, "Press occurs once"),
    ):
        refused = vezzoli.replace(changes | PERIODIC | {"drive": SINE})
        for act in (ev.simulate, lambda one: ev.export(one, place)):
            with pytest.raises(InputError, match=words):
                act(refused)
    assert not place.exists()
    ev.export(vezzoli, place)
    assert place.exists()


PULSE = RAMP | {"rise": 0.0, "hold": 8e-6, "fall": 0.0, "delay": 20.03e-3, "repeat": 0.1}


@pytest.mark.parametrize(
    ("short", "held"),
    [(PULSE, HELD), ({"model": "Offset", "drive": PULSE, "level": "50 V"}, HELD | {"level": "150 V"})],
    ids=["pulse", "pulse on an offset"],
)
def test_a_short_pulse_counts_everywhere(short, held):
    """8 us at 20.03 ms fall between any even times; it is held against the same voltage for ever."""
    spring = {"model": "LinearSpring", "stiffness": "1 TPa/m", "free_gap": "2 um"}
    layers = {"stack.insulator.thickness": 1e-6, "stack.gap.thickness": 2e-6}
    stack = layers | {"stack.gap.material.conductivity": 0.0}
    scenario = ev.load("vezzoli_2014/fig6_gap", changes=stack | {"contact.surface": spring})
    one, other = (scenario.replace({"drive": drive}) for drive in (short, held))
    assert ev.equilibrium(one).voltage == ev.equilibrium(other).voltage
    assert ev.equilibrium(one).force == ev.equilibrium(other).force
    assert ev.equilibrium(one).force[0] > 0.05
    assert ev.simulate(one).mean_force.values.tolist() == ev.simulate(other).mean_force.values.tolist()
    statics = [[entry.static for entry in ev.compare(each).entries] for each in (one, other)]
    assert statics[0] == statics[1]


CABLE, GAIN = 100e-12, 100.0
LOAD = 1e-4 * epsilon_0 / (90e-6 / 3.35 + 200e-6 / 1133) + CABLE
"""Of two lossless layers, plate and cable [F]."""
SLOW, FAST = 2 * np.pi * 100, 2 * np.pi * 500
TONES = [
    {"model": "Sine", "amplitude": 5.0, "frequency": 100},
    {"model": "Sine", "amplitude": 1.0, "frequency": 500, "phase": np.pi},
]
RAMPS = {"model": "Trapezium", "high": 10.0, "rise": 2e-3, "hold": 1e-3, "fall": 0.5e-3}


def slope_where_it_saturates(saturation):
    """Slope of the drive at the time at which it reaches the saturation, which it does while the slope grows."""
    reached = brentq(
        lambda time: GAIN * (5 * np.sin(SLOW * time) - np.sin(FAST * time)) - saturation,
        1e-5,
        1e-3,
        xtol=1e-15,
    )
    return 5 * SLOW * (np.cos(SLOW * reached) - np.cos(FAST * reached))


def check_largest_current(scenario, expected, rel):
    """Of the plate and the stray capacitance, as a run and a sweep state it."""
    swept = {"circuit.amplifier.saturation": [scenario.circuit.amplifier.saturation]}
    states = [ev.simulate(scenario), ev.sweep(scenario, over=swept, quantity=["peak electrostatic_force"])]
    for result in states:
        found = next(each.value for each in diagnostics_of(result) if each.name == "current")
        assert found == pytest.approx(expected, rel=rel)


@pytest.mark.parametrize(
    ("drive", "slope", "saturation"),
    [
        ({"model": "Sum", "drives": TONES}, slope_where_it_saturates(saturation), saturation)
        for saturation in (100.0, 200.0)
    ]
    # the largest voltage ends the rise at 800 V, and the drive does below 2 kV
    + [(RAMPS, 10 / 0.5e-3, saturation) for saturation in (800.0, 2e3)],
)
@pytest.mark.parametrize("samples", [57, pytest.param(4001, marks=pytest.mark.slow)])
def test_the_largest_current_is_that_at_which_the_amplifier_saturates(drive, slope, saturation, samples):
    """Of a capacitor."""
    skin = {"model": "Constant", "permittivity": 1133.0}
    amplifier = {"gain": GAIN, "saturation": saturation, "stray_capacitance": CABLE}
    changes = {
        "drive": drive,
        "stack.stratum_corneum.material": skin,
        "circuit": {"amplifier": amplifier, "return_path": {"model": "Grounded", "resistance": 1.0}},
        "limits": {"current": 1.0, "voltage": 2e3},
        "time": {"duration": 4e-3, "samples": samples},
    }
    scenario = ev.load("vezzoli_2014/fig6_static", changes=changes)
    check_largest_current(scenario, LOAD * GAIN * slope, 1e-6 if drive != RAMPS else 1e-9)


def test_a_sweep_states_the_largest_current_of_a_skin_that_conducts():
    """The current grows up to the end of the ramp, where it jumps: 38 % more would come from a parabola through both sides."""
    amplifier = {"saturation": 2e3, "stray_capacitance": CABLE}
    ramps = {"drive.rise": 10e-3, "drive.hold": 10e-3, "drive.fall": 6e-3, "time.duration": 30e-3}
    changes = {"circuit.amplifier": amplifier, "limits.current": 1.0} | ramps
    scenario = ev.load("vezzoli_2014/fig6", changes=changes)
    trace = ev.simulate(scenario, time=np.linspace(0, 30e-3, 30001))
    check_largest_current(scenario, float(np.max(np.abs(trace.amplifier_current))), 1e-6)


def plate_alone(*films):
    """A plate of films under a finger that conducts; each is thickness, permittivity and conductivity."""
    layers = {
        f"film_{place}": {
            "role": "plate",
            "thickness": thickness,
            "material": {"model": "Constant", "permittivity": permittivity, "conductivity": conductivity},
            "breakdown_field": 1e9,
        }
        for place, (thickness, permittivity, conductivity) in enumerate(films)
    }
    changes = {"stack": layers, "force": {"model": "MaxwellStressInGap"}}
    return ev.load("vezzoli_2014/fig6_static").replace({**changes, **BARE})


SQUARE = {"drive": {"model": "Square", "low": -60.0, "high": 100.0, "frequency": 50.0, "edge": 1e-5}}


@pytest.mark.parametrize("thin", [0.2e-6, 2e-6, 20e-6])
@pytest.mark.parametrize("conductivities", [(0, 0), (1e-7, 0), (0, 1e-7), (1e-7, 3e-8), (1e-8, 1e-10)])
def test_two_films_with_the_gap_closed_never_exceed_their_bound(thin, conductivities):
    """The declared contact is that of a conducting finger, so that the exact fields of the run must stay below the bound."""
    films = [(thin, 8.0, conductivities[0]), (1e-6, 3.0, conductivities[1])]
    shares = np.array([thin / 8.0, 1e-6 / 3.0])
    shares /= shares.sum()
    # the shares after a long time, those of resistances: a film that insulates has everything
    slow = np.array([1.0, 1.0])
    if all(conductivities):
        slow = np.array([thin / conductivities[0], 1e-6 / conductivities[1]])
    elif any(conductivities):
        slow = np.array([each == 0 for each in conductivities], dtype=float)
    later = slow / slow.sum() - shares if any(conductivities) else np.zeros(2)
    swings = [
        100 * shares + np.maximum(100 * later, -60 * later),
        60 * shares + np.maximum(60 * later, -100 * later),
    ]
    largest = np.max([*swings, np.full(2, 100.0 * any(conductivities))], axis=0)
    found = told(plate_alone(*films), SQUARE)
    for place, (thickness, *_) in enumerate(films):
        exact, bound = (found[f"film strength, film_{place}{case}"].value for case in ("", ", gap closed"))
        assert bound == pytest.approx(largest[place] / thickness, rel=1e-9)
        assert exact <= bound * (1 + 1e-6)


def test_the_bound_of_two_films_is_reached():
    """The film that conducts has lost its voltage when the drive turns over, and then takes its share of the whole swing."""
    films = [(20e-6, 8.0, 1e-6), (0.2e-6, 3.0, 0.0)]
    found = told(plate_alone(*films), SQUARE)
    share = (20 / 8) / (20 / 8 + 0.2 / 3)
    assert found["film strength, film_0, gap closed"].value == pytest.approx(160 * share / 20e-6)
    assert found["film strength, film_0"].value == pytest.approx(160 * share / 20e-6, rel=2e-2)
    assert found["film strength, film_1"].value == pytest.approx(100 / 0.2e-6, rel=3e-2)


DEBYE = {
    "model": "Debye",
    "permittivity_high": 3.0,
    "conductivity": 0.0,
    "strength": 2.0,
    "relaxation_time": 1e-3,
}
SERIES = {
    "three of which one conducts": ([(1e-6, 3.0, 0.0), (1e-6, 3.0, 1e-9), (1e-6, 8.0, 0.0)], {}),
    "three that conduct": ([(1e-6, 3.0, 1e-7), (2e-6, 4.0, 1e-8), (1e-6, 8.0, 1e-6)], {}),
    "charge between": ([(1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0)], {"stack.film_0.initial_charge": 1e-3}),
    "negative charge": ([(1e-6, 3.0, 0.0), (1e-6, 8.0, 1e-8)], {"stack.film_0.initial_charge": -1e-3}),
    "relaxing": ([(1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0)], {"stack.film_0.material": DEBYE}),
    "of a library": ([(1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0)], {"stack.film_0.material": "pvdf"}),
}


@pytest.mark.parametrize("case", SERIES)
def test_films_in_series_never_exceed_their_bound(case):
    """Any number of films, charged, conducting or relaxing; their exact fields under a conducting finger stay below it."""
    films, changes = SERIES[case]
    found = told(plate_alone(*films).replace(changes), SQUARE)
    for place in range(len(films)):
        exact, bound = (found[f"film strength, film_{place}{end}"].value for end in ("", ", gap closed"))
        assert exact <= bound * (1 + 1e-6)
        assert bound <= 3 * max(exact, 100.0 / films[place][0])


def test_a_relaxing_film_hands_its_voltage_to_the_other():
    """Of 2 + 3 and 8 in series after the relaxation, 3 and 8 before it: closed form, under a voltage of one sign."""
    relaxing = plate_alone((1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0)).replace({"stack.film_0.material": DEBYE})
    for drive in (RAMP, HELD):  # a step comes from 0 V, though its voltage is never lower than 100 V
        found = told(relaxing, {"drive": drive})
        for place, share in enumerate((8 / 11, 5 / 13)):
            film = found[f"film strength, film_{place}, gap closed"]
            assert film.value == pytest.approx(100 * share / 1e-6, rel=1e-9)


def test_films_that_leak_are_not_known_with_the_gap_closed_and_refused(tmp_path):
    leaky = plate_alone((1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0), (1e-6, 5.0, 0.0)).replace(
        {"stack.film_0.leak": polarity(1e-9, 2e-9), "drive": RAMP, "limits": {"voltage": 1e3, "current": 1.0}}
    )
    film = told(leaky)["film strength, film_0, gap closed"]
    assert (film.state, film.value, film.limit) == ("unknown", None, 1e9)
    checked = ev.check(leaky)
    row = next(each for each in checked.rows if each.quantity == film.name)
    assert (row.state, row.forbids, row.is_refused) == ("unknown", True, True)
    assert "a conductivity in place of the leak" in row.remedy
    assert checked.state == "unknown"
    with pytest.raises(InputError, match=r"in 'film_0', with .* is not known.*in place of the leak"):
        ev.export_waveform(leaky, tmp_path / "drive.csv", rate=50e3, edge="line")


@pytest.mark.parametrize(
    "changes",
    [{"stack.film_1.material": DEBYE}, {"stack.film_0.initial_charge": 1e-6}],
    ids=["relaxing", "charged"],
)
def test_two_films_of_which_one_leaks_have_no_bound_beside_relaxation_or_charge(changes):
    leaks = {"stack.film_0.leak": polarity(1e-9, 2e-9), "drive": RAMP}
    two = plate_alone((1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0)).replace(leaks)
    assert told(two)["film strength, film_1, gap closed"].state == "ok"
    found = told(two.replace(changes))["film strength, film_1, gap closed"]
    assert (found.state, found.value) == ("unknown", None)


@pytest.mark.parametrize("place", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_of_two_films_one_may_leak(place):
    """A leak that charges the interface hands the voltage to the other film, whose share of the swing counts besides."""
    two = plate_alone((1e-6, 3.0, 0.0), (1e-6, 8.0, 0.0))
    found = told(two.replace({f"stack.film_{1 - place}.leak": polarity(1e-6, 2e-6)}), SQUARE)
    for other, share in enumerate((8 / 11, 3 / 11)):
        exact, bound = (found[f"film strength, film_{other}{end}"].value for end in ("", ", gap closed"))
        assert bound == pytest.approx(max(100.0, 160 * share) / 1e-6, rel=1e-9)
        assert exact <= bound * (1 + 1e-6)


def test_films_that_insulate_share_the_voltage():
    insulating = plate_alone((1e-6, 3.0, 0.0), (2e-6, 6.0, 0.0), (1e-6, 3.0, 0.0))
    for place, field in enumerate((100 / 3e-6, 100 / 6e-6, 100 / 3e-6)):
        film = told(insulating, {"drive": RAMP})[f"film strength, film_{place}, gap closed"]
        assert film.value == pytest.approx(field, rel=1e-9)


def test_a_film_on_the_finger_shares_the_voltage_with_that_of_the_plate(with_gap):
    stack = with_gap.to_dict()["stack"]
    glove = {"role": "finger", "thickness": 45e-6, "material": {"model": "Constant", "permittivity": 3.35}}
    worn = {"insulator": stack["insulator"], "gap": stack["gap"], "glove": glove | {"breakdown_field": 50e6}}
    found = told(with_gap, {"stack": worn | {"stratum_corneum": stack["stratum_corneum"]}, "drive": RAMP})
    assert found["film strength, glove, gap closed"].value == pytest.approx(100 / 135e-6)
    assert found["film strength, insulator, gap closed"].value == pytest.approx(100 / 90e-6)
