"""Every run says what may break down or exceeds a declared limit, whatever output times were asked for."""

from __future__ import annotations

import json
import math

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import read_diagnostics
from electrovib.core.errors import InputError
from electrovib.solve.diagnostics.judge import solved
from electrovib.solve.stack.expand import modes

AREA, FILM, SKIN = 1e-4, 90e-6 / 3.35, 200e-6 / 1560
SHORT = np.linspace(0.0, 1e-3, 3)


def diagnostics(trace):
    return {diagnostic.name: diagnostic for diagnostic in read_diagnostics(trace.attrs["validity"])}


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
    found = diagnostics(ev.simulate(vezzoli.replace({"drive.high": "50 kV"})))
    film = found["film strength, insulator"]
    assert film.state == "warning"
    assert film.value == pytest.approx(50e3 / (FILM + SKIN) / 3.35, rel=1e-4)  # 1 kohm takes the rest
    assert film.limit == 100e6  # of PET, 100 um
    emission = found["field emission"]
    assert (emission.state, emission.value) == ("warning", pytest.approx(50e3 / (FILM + SKIN), rel=1e-4))
    assert "vanishing" in emission.text


def test_a_film_in_two_is_as_strong_as_in_one(vezzoli):
    """Strength falls with thickness, and that of the slab counts: 27 and 63 um were compared with 157.5 and 115 MV/m."""
    layers = vezzoli.to_dict()["stack"]
    pieces = {}
    for name, layer in layers.items():
        role = vezzoli.stack.roles[name]
        pieces[f"{name}_outside"] = layer | {"thickness": 0.3 * layer["thickness"], "role": role}
        pieces[name] = layer | {"thickness": 0.7 * layer["thickness"]}
    for drive in ({"drive.high": "1 kV"}, {"drive.high": "50 kV"}):
        whole = diagnostics(ev.simulate(vezzoli.replace(drive)))
        cut = diagnostics(ev.simulate(vezzoli.replace(drive | {"stack": pieces})))
        for kind, name in (("film strength", "insulator"), ("linear skin", "stratum_corneum")):
            for piece in (name, f"{name}_outside"):
                one, two = whole[f"{kind}, {name}"], cut[f"{kind}, {piece}"]
                assert (two.state, two.limit) == (one.state, one.limit)
                assert two.value == pytest.approx(one.value, rel=1e-9)


def test_every_layer_of_the_plate_and_of_the_finger_is_judged(vezzoli):
    """Two films and two layers of finger, of other names; the declared strength of one comes before its kind's."""
    film = {"model": "Constant", "permittivity": 3.35}
    skin = {"model": "Constant", "permittivity": 1560}
    stack = {
        "lower": {"thickness": "45 um", "role": "plate", "material": film, "breakdown_field": "10 MV/m"},
        "upper": {"thickness": "45 um", "role": "plate", "material": film},
        "outer": {"thickness": "100 um", "role": "finger", "material": skin},
        "inner": {"thickness": "100 um", "role": "finger", "material": skin, "breakdown_field": "10 kV/m"},
    }
    found = diagnostics(
        ev.simulate(vezzoli.replace({"stack": stack, "force": {"model": "MaxwellStressInGap"}}))
    )
    assert found["film strength, lower"].state == "warning"  # 11.06 MV/m
    assert found["film strength, upper"].state == "ok"
    assert found["film strength, inner"].state == "warning"  # 23.7 kV/m
    assert {"linear skin, outer", "linear skin, inner"} <= set(found)
    assert found["electrowetting"].limit == pytest.approx(math.sqrt(2 * 0.072 * FILM / eps0), rel=1e-12)
    assert "Paschen" not in found


def test_a_gap_is_judged_by_paschen_and_field_emission(with_gap):
    found = diagnostics(ev.simulate(with_gap.replace({"stack.gap.thickness": "28 um", "drive.high": 800.0})))
    assert found["Paschen"].value == pytest.approx(800 * 28e-6 / (28e-6 + FILM + SKIN), rel=1e-4)
    assert found["Paschen"].state == "warning"  # from 789 V on, facts of the rig of Vezzoli et al. 2014
    assert (
        diagnostics(ev.simulate(with_gap.replace({"stack.gap.thickness": "28 um", "drive.high": 780.0})))[
            "Paschen"
        ].state
        == "ok"
    )
    thin = diagnostics(ev.simulate(with_gap.replace({"stack.gap.thickness": "1 um"})))
    assert (thin["Paschen"].state, thin["field emission"].state) == ("unknown", "ok")


DRIVES = {
    "pulse": {"model": "Trapezium", "high": 300.0, "delay": 2e-3, "rise": 1e-6, "hold": 5e-6, "fall": 1e-6},
    "sine": {"model": "Sine", "amplitude": 300.0, "frequency": 777.0, "phase": 0.123},
    "two": {
        "model": "Sum",
        "drives": [
            {"model": "Sine", "amplitude": 200.0, "frequency": 777.0},
            {"model": "Burst", "amplitude": 150.0, "frequency": 3e3, "cycles": 4, "delay": 1e-3},
        ],
    },
    "square": {"model": "Square", "high": 300.0, "frequency": 400.0, "edge": 2e-6},
}
STACKS = {
    "closed form": {},
    "behind an amplifier": {"circuit.amplifier": {"gain": 1.0, "bandwidth": 2e4, "stray_capacitance": 1e-10}},
    "amplifier with limits": {
        "circuit.amplifier": {"gain": 1.0, "source_current": 1e-4, "stray_capacitance": 1e-10}
    },
    "leak": {
        "stack.gap.leak": {
            "model": "PolarityConduction",
            "conductivity_positive": 1e-8,
            "conductivity_negative": 2e-8,
        }
    },
    "moving gap": {
        "motion.distance": {
            "model": "TremblingDistance",
            "mean": 20e-6,
            "amplitude": 15e-6,
            "frequency": 300.0,
        }
    },
}
CASES = [
    (stack, drive)
    for stack in STACKS
    for drive in DRIVES
    if stack != "amplifier with limits" or drive == "pulse"
]

TWO_LEAKS = {
    "stack.insulator.leak": {
        "model": "PolarityConduction",
        "conductivity_positive": 1e-9,
        "conductivity_negative": 1e-9,
    },
} | STACKS["leak"]


@pytest.mark.parametrize(("stack", "drive"), CASES)
def test_checks_do_not_depend_on_the_output_times(with_gap, stack, drive):
    """Three times that miss everything, and four thousand that do not: the same largest values."""
    skin = {"stack.stratum_corneum.material.conductivity": 2e-6, "circuit.return_path.resistance": 1e4}
    limits = {
        "limits": {
            "voltage": 100,
            "current": 1e-4,
            "charge": 1e-9,
            "stored_energy": 1e-6,
            "body_current": 1e-4,
        }
    }
    one = with_gap.replace(skin | limits | STACKS[stack] | {"drive": DRIVES[drive]})
    end = 4e-3
    few, many = np.array([0.9 * end, end]), np.linspace(0.0, end, 4001)
    told = [diagnostics(ev.simulate(one, time=time)) for time in (few, many)]
    values = [
        {
            name: diagnostic.value / diagnostic.limit
            for name, diagnostic in each.items()
            if diagnostic.value is not None
        }
        for each in told
    ]
    for each in values:
        each.pop("sampling", None)
    assert {"field emission", "current", "voltage", "charge", "stored energy", "body current"} <= set(
        values[0]
    )
    assert values[0] == pytest.approx(values[1], rel=2e-4)
    # ... and no smaller than what the many times show
    trace = ev.simulate(one, time=many)
    largest = float(np.abs(trace.field.sel(layer="gap")).max())
    assert told[0]["field emission"].value >= largest * (1 - 1e-5)
    body = max(diagnostic.value for name, diagnostic in told[0].items() if name.startswith("body current"))
    assert body >= float(np.abs(trace.current).max()) * (1 - 1e-5)


def test_the_general_reference_too(with_gap):
    one = with_gap.replace(TWO_LEAKS | {"drive": DRIVES["pulse"], "limits.current": 1e-6})
    told = [
        diagnostics(ev.simulate(one, time=time))["field emission"].value
        for time in (SHORT * 4, np.linspace(0, 4e-3, 401))
    ]
    assert told[0] == pytest.approx(told[1], rel=1e-6)
    assert told[0] > 5e6


def test_a_sines_largest_values_are_met_between_evaluation_times(vezzoli):
    """300 V of 777 Hz from the periodic state: |i| = C V w and E = V/(T eps_film/eps0) to 1e-6."""
    settled = {"time.initial_state": {"model": "PeriodicState"}, "circuit.return_path.resistance": 0.0}
    one = vezzoli.replace({"drive": DRIVES["sine"], "force": {"model": "MaxwellStressInGap"}} | settled)
    time = np.array([0.0, 1e-9])
    _, record = solved(one, modes(one, time)[0], time)
    peaks = record.peaks()
    assert peaks["interface"] == pytest.approx(300 / (FILM + SKIN), rel=1e-6)
    capacitance = eps0 * AREA / (FILM + SKIN)
    assert peaks["current"] == pytest.approx(capacitance * 300 * 2 * np.pi * 777, rel=1e-6)
    assert peaks["charge"] == pytest.approx(capacitance * 300, rel=1e-6)
    assert peaks["stored_energy"] == pytest.approx(capacitance * 300**2 / 2, rel=1e-6)


def test_each_limit_is_defined(vezzoli):
    """100 V held: plate 100 V, Q = C V on the plate, C V^2/2 in contact and stray, and 10 us of ramp."""
    ramp = {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}
    amplifier = {"gain": 2.0, "stray_capacitance": "50 pF"}
    limits = {"voltage": 1.0, "current": 1e-9, "charge": 1e-12, "stored_energy": 1e-12, "body_current": 1e-9}
    changes = {
        "drive": ramp,
        "circuit.amplifier": amplifier,
        "limits": limits,
        "circuit.return_path.resistance": 0.0,
    }
    found = diagnostics(ev.simulate(vezzoli.replace(changes)))
    capacitance = eps0 * AREA / (FILM + SKIN)
    expected = {
        "voltage": 200.0,
        "current": (capacitance + 50e-12) * 200e3,
        "charge": capacitance * 200,
        "stored energy": (capacitance + 50e-12) * 200**2 / 2,
        "body current": capacitance * 200e3,
    }
    for name, value in expected.items():
        assert (found[name].state, found[name].value) == ("warning", pytest.approx(value, rel=1e-6)), name


def test_the_energy_of_two_contacts_is_that_of_both(vezzoli):
    """The second contact of half the area is in series: q/C_1 and q/C_2 across, q^2/2 (1/C_1 + 1/C_2) in both."""
    held = {"drive": {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}}
    two = {"circuit.return_path": {"model": "SecondElectrode", "area": "0.5 cm2", "resistance": 0.0}}
    limits = {"limits": {"stored_energy": 1e-12, "charge": 1e-12}}
    found = diagnostics(ev.simulate(vezzoli.replace(held | two | limits)))
    first = eps0 * AREA / (FILM + SKIN)
    series = 1 / (1 / first + 2 / first)
    assert found["charge"].value == pytest.approx(series * 100, rel=1e-6)
    assert found["stored energy"].value == pytest.approx(series * 100**2 / 2, rel=1e-6)


@pytest.mark.parametrize("which", ["first", "second"])
def test_the_smaller_of_two_contacts_is_judged(with_gap, which):
    """Two capacitors in series: that of half the area takes 2/3 of the voltage, on whichever electrode it is."""
    areas = ("0.5 cm2", "1 cm2") if which == "first" else ("1 cm2", "0.5 cm2")
    changes = {
        "drive": {"model": "Trapezium", "high": 3000.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3},
        "contact.area": areas[0],
        "circuit.return_path": {"model": "SecondElectrode", "area": areas[1], "resistance": 0.0},
    }
    scenario = with_gap.replace(changes)
    found = diagnostics(ev.simulate(scenario))
    field = 2000 / (FILM + SKIN + 5e-6)
    expected = {
        "film strength, insulator": field / 3.35,
        "Paschen": field * 5e-6,
        "field emission": field,
        "linear skin, stratum_corneum": field * SKIN,
        "electrowetting": 2000,
    }
    rows = {row.quantity: row for row in ev.check(scenario).rows}
    swept = diagnostics(ev.sweep(scenario, {"limits.charge": [1e-3, 2e-3]}))
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
    two = {"circuit.return_path": {"model": "SecondElectrode", "area": with_gap.contact_area}}
    single = diagnostics(
        ev.simulate(with_gap.replace({"drive.high": 500.0, "circuit.return_path.resistance": 0.0}))
    )
    both = diagnostics(
        ev.simulate(with_gap.replace({"drive.high": 1000.0} | two | {"circuit.return_path.resistance": 0.0}))
    )
    for name in ("film strength, insulator", "Paschen", "field emission", "electrowetting"):
        assert both[name].text == single[name].text


def test_the_stray_capacitance_holds_the_voltage_of_the_plate(vezzoli):
    """A floating body of 20 pF takes part of the voltage from the layers, and none from plate and cable."""
    body = 20e-12
    changes = {
        "drive": {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3},
        "circuit": {
            "amplifier": {"gain": 2.0, "stray_capacitance": "50 pF"},
            "return_path": {"model": "Floating", "capacitance": body},
        },
        "limits": {"stored_energy": 1e-12},
    }
    found = diagnostics(ev.simulate(vezzoli.replace(changes)))
    layers = eps0 * AREA / (FILM + SKIN)
    across = 200 * body / (body + layers)
    expected = (layers * across**2 + 50e-12 * 200**2) / 2
    assert found["stored energy"].value == pytest.approx(expected, rel=1e-6)


def test_nothing_is_said_of_what_is_not_declared(vezzoli):
    square = {"drive": {"model": "Square", "high": 100.0, "frequency": 200.0}}
    trace = ev.simulate(vezzoli.replace(square | {"limits": {}}))
    assert not {"voltage", "current", "charge", "stored energy", "body current"} & set(diagnostics(trace))
    for word in ("amplifier", "limits.", "250 uA", "declared"):
        assert word not in json.dumps(
            [
                diagnostic.text
                for diagnostic in diagnostics(trace).values()
                if diagnostic.name != "film strength, insulator"
            ]
        )
    assert "100 mA" in diagnostics(trace)["discontinuity"].text


def test_the_step_at_time_0_is_reported_apart(vezzoli):
    """A cosine of 100 V on 1 kohm: 100 mA as it is switched on, C V w = 5.85 mA in the periodic state at 284 kHz."""
    capacitance = eps0 * AREA / (FILM + SKIN)
    frequency = 5.85e-3 / (2 * np.pi * capacitance * 100)
    cosine = {"drive": {"model": "Sine", "amplitude": 100.0, "frequency": frequency, "phase": np.pi / 2}}
    found = diagnostics(
        ev.simulate(vezzoli.replace(cosine | {"limits": {"current": "10 mA", "body_current": "10 mA"}}))
    )
    for name in ("current", "body current"):
        assert (found[name].state, found[name].value) == ("ok", pytest.approx(5.85e-3, rel=3e-3))
        switched = found[f"{name} at switch-on"]
        assert (switched.state, switched.value) == ("warning", pytest.approx(0.1, rel=1e-6))
    assert "at time 0 only" in found["discontinuity"].text
    settled = vezzoli.replace(
        cosine | {"limits": {"current": "10 mA"}, "time.initial_state": {"model": "PeriodicState"}}
    )
    found = diagnostics(ev.simulate(settled))
    assert not {"discontinuity", "current at switch-on"} & set(found)
    assert found["current"].value == pytest.approx(5.85e-3, rel=3e-3)


def test_a_drive_that_does_not_repeat_reports_its_step_apart_too(vezzoli):
    once = {
        "drive": {"model": "Trapezium", "low": 20.0, "high": 100.0, "rise": 1e-3, "hold": 1e-3, "fall": 1e-3}
    }
    found = diagnostics(ev.simulate(vezzoli.replace(once | {"limits": {"current": "1 mA"}})))
    assert found["current"].value == pytest.approx(eps0 * AREA / (FILM + SKIN) * 80e3, rel=1e-6)
    assert found["current at switch-on"].value == pytest.approx(20e-3, rel=1e-9)


LATE = {"model": "Trapezium", "high": 100.0, "delay": 1e-3, "rise": 0.0, "hold": 1e-3, "fall": 1e-3}


@pytest.mark.parametrize(
    "drive", [{"model": "Square", "high": 100.0, "frequency": 200.0}, LATE], ids=["square", "late"]
)
def test_no_series_resistance_and_a_discontinuity(vezzoli, drive):
    endless = {"drive": drive, "limits": {"current": "1 A"}, "circuit.return_path.resistance": 0.0}
    found = diagnostics(ev.simulate(vezzoli.replace(endless)))
    assert found["current"].state == "warning"
    assert "no bound" in found["current"].text
    assert found["current"].value is None


def test_a_current_that_is_largest_just_before_a_corner(vezzoli):
    """Film and skin conduct so well that the current follows the voltage, C dV/dt turns it at the tip: 1 ms up and down."""
    triangle = {"model": "Trapezium", "high": 100.0, "rise": 1e-3, "hold": 0.0, "fall": 1e-3}
    leaky = {
        f"stack.{name}.material.conductivity": 1e-6 * length
        for name, length in (("insulator", 90.0), ("stratum_corneum", 200.0))
    }
    one = vezzoli.replace(leaky | {"drive": triangle, "limits": {"current": "1 mA"}})
    told = diagnostics(ev.simulate(one, time=np.array([0.0, 2e-3])))["current"].value
    before = np.array([1e-3 * (1 - 1e-9)])
    assert told == pytest.approx(float(ev.simulate(one, time=before).current[0]), rel=1e-6)


def test_equilibrium_judges_too():
    content = {
        "drive": {"model": "Step", "level": "1 kV"},
        "force": {"model": "MaxwellStressInGap"},
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {
            "model": "FixedArea",
            "area": "1 cm2",
            "surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "40 um"},
        },
        "load": {"normal_force": "0.5 N"},
        "circuit": {"return_path": {"model": "Floating", "capacitance": "100 pF"}},
        "limits": {"voltage": "500 V", "charge": "1 nC", "stored_energy": "1 nJ", "current": "1 A"},
        "stack": {
            "insulator": {"thickness": "90 um", "material": {"model": "Constant", "permittivity": 3.35}},
            "gap": {"thickness": "5 um"},
            "stratum_corneum": {
                "thickness": "200 um",
                "material": {"model": "Constant", "permittivity": 1560, "conductivity": 1e-6},
            },
        },
    }
    found = ev.equilibrium(content)
    told = {diagnostic.name: diagnostic for diagnostic in found.diagnostics}
    (state,) = found.states
    body = eps0 * AREA / 100e-12
    field = 1000 / (FILM + body + state.gap)
    assert told["Paschen"].value == pytest.approx(field * state.gap, rel=1e-9)
    assert told["film strength, insulator"].value == pytest.approx(field / 3.35, rel=1e-9)
    assert told["field emission"].value == pytest.approx(field, rel=1e-9)
    assert told["linear skin, stratum_corneum"].value == 0
    assert (told["voltage"].state, told["voltage"].value) == ("warning", 1000.0)
    assert told["charge"].value == pytest.approx(eps0 * field * AREA, rel=1e-9)
    assert told["stored energy"].value == pytest.approx(
        eps0 * field * AREA * field * (FILM + state.gap) / 2, rel=1e-9
    )
    assert "current" not in told
    near = ev.equilibrium(
        content
        | {
            "stack": content["stack"]
            | {"insulator": {"thickness": "1 um", "material": {"model": "Constant", "permittivity": 5}}},
            "circuit": {"return_path": {"model": "Grounded"}},
        }
    )
    worst = {diagnostic.name: diagnostic.state for diagnostic in near.diagnostics}
    assert worst["field emission"] == "warning"
    assert worst["film strength, insulator"] == "unknown"
    assert len(near.states) == 3
    assert worst["Paschen"] == "warning"  # of the open state; of the closed one its law says nothing


def test_export_refuses_what_breaks_a_limit(vezzoli, tmp_path):
    place = tmp_path / "circuit.cir"
    with pytest.raises(InputError, match=r"above 1 nA: the declared limit \(limits.current\)"):
        ev.export(vezzoli, place, set={"limits.current": "1 nA"})
    with pytest.raises(InputError, match=r"limits.voltage.*\n.*limits.charge"):
        ev.export(vezzoli, place, set={"limits": {"voltage": "1 V", "charge": "1 pC"}})
    assert not place.exists()
    ev.export(vezzoli, place)
    assert place.exists()


def test_export_refuses_what_run_refuses(vezzoli, tmp_path):
    leaky = {
        "stack.insulator.leak": {
            "model": "PolarityConduction",
            "conductivity_positive": 1e-9,
            "conductivity_negative": 2e-9,
        }
    }
    changes = leaky | {"time.initial_state": {"model": "PeriodicState"}, "drive": DRIVES["sine"]}
    for act in (ev.simulate, lambda one: ev.export(one, tmp_path / "circuit.cir")):
        with pytest.raises(InputError, match="PeriodicState"):
            act(vezzoli.replace(changes))
    lag = {
        "friction": {
            "model": "FirstOrderLag",
            "steady": {"model": "Coulomb", "coefficient": 0.5},
            "cut_off": 100.0,
        }
    }
    press = {"load.time_profile": {"model": "Press", "begin": 0.05, "rise": 0.05}}
    changes = lag | press | {"time.initial_state": {"model": "PeriodicState"}, "drive": DRIVES["sine"]}
    for act in (ev.simulate, lambda one: ev.export(one, tmp_path / "circuit.cir")):
        with pytest.raises(InputError, match="Press occurs once"):
            act(vezzoli.replace(changes))
