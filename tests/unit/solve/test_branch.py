"""The march of one nonlinear branch: its scalar equation, its error estimate, and its order."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from electrovib.core.model import read_model
from electrovib.physics.circuit import SeriesElement
from electrovib.physics.conduction import FieldConduction, PolarityConduction
from electrovib.physics.drive.base import Drive
from electrovib.physics.material import Constant, Debye
from electrovib.physics.stack import Layer
from electrovib.solve.electrics import leaks, steps
from electrovib.solve.electrics.leaks import field_under_leak, follow, leak_section, leaky_response
from electrovib.solve.electrics.transient import transient
from electrovib.solve.stack.keys import FieldOf
from electrovib.solve.stack.section import modal_section

AREA = 1e-4
CONTROL = FieldOf("stratum_corneum")
LEAKS = {
    "polarity": PolarityConduction(conductivity_positive=5e-6, conductivity_negative=1e-6),
    "field": FieldConduction(conductivity=2e-6, onset_field=1e4),
}
RAMPS = {"model": "Trapezium", "high": 100, "rise": 10e-3, "hold": 10e-3, "fall": 10e-3}


def answers(conductivity=0.0, element=SeriesElement()):  # noqa: B008
    layers = {
        "insulator": Layer(thickness=90e-6, material=Constant(permittivity=3.35)),
        "stratum_corneum": Layer(
            thickness=200e-6,
            material=Debye(
                permittivity_high=300, strength=1200, relaxation_time=2e-3, conductivity=conductivity
            ),
        ),
    }
    debye = {name: layer.material.debye() for name, layer in layers.items()}
    section = modal_section(layers, debye, area=AREA, element=element, second=0.0)
    leaking = leak_section(section, layers, "stratum_corneum", area=AREA, element=element)
    return section["stratum_corneum"].field, leaking["stratum_corneum"].field


@given(
    known=st.floats(-1e9, 1e9, allow_subnormal=False).filter(lambda field: field == 0 or abs(field) > 1e-200),
    weight=st.floats(-3, 20).map(lambda power: 10.0**power),
    name=st.sampled_from(sorted(LEAKS)),
    share=st.one_of(st.none(), st.floats(-1, 2)),
)
def test_the_scalar_equation_is_solved(known, weight, name, share):
    leak = LEAKS[name]
    guess = None if share is None else share * known
    field = field_under_leak(leak, known=known, weight=weight, guess=guess)
    drop = weight * float(leak.current_density(field))
    assert min(0.0, known) <= field <= max(0.0, known)
    slope = 1 + weight * float(leak.slope(field))
    # the residue as a distance of the field, and the rounding of what is subtracted in it
    assert abs(field + drop - known) / slope <= 1e-14 * abs(field) + 1e-15 * abs(known) / slope


@pytest.mark.parametrize("name", LEAKS)
def test_no_weight_is_no_leak(name):
    assert field_under_leak(LEAKS[name], known=3.0, weight=0.0) == 3.0
    assert field_under_leak(LEAKS[name], known=0.0, weight=1e9) == 0.0


def orders(errors):
    return np.log2(np.array(errors[:-1]) / np.array(errors[1:]))


def test_second_order_against_the_linear_solver():
    """An ohmic leak is a conductivity, whose response is exact."""
    conductivity = 3e-6
    leak = PolarityConduction(conductivity_positive=conductivity, conductivity_negative=conductivity)
    drive = read_model(Drive, RAMPS)
    exact, _ = answers(conductivity)
    driven, leaking = answers()
    errors = []
    for count in (60, 120, 240, 480):
        grid = np.linspace(0, 30e-3, count + 1)
        found = follow(driven, leaking, drive, grid, leak=leak)
        errors.append(np.max(np.abs(found.field.after - transient({"E": exact}, drive, grid)["E"])))
    assert orders(errors) == pytest.approx(2, abs=0.1)
    assert errors[-1] < 3e-4 * np.max(np.abs(found.field.after))  # 200 steps in the time constant


def test_second_order_of_a_leak_that_grows_with_the_field():
    drive = read_model(Drive, RAMPS)
    driven, leaking = answers()
    leak = LEAKS["field"]

    def at_a_few(count):
        found = follow(driven, leaking, drive, np.linspace(0, 30e-3, count + 1), leak=leak)
        return found.field.after[:: count // 30]

    reference = at_a_few(30 * 512)
    errors = [np.max(np.abs(at_a_few(30 * n) - reference)) for n in (4, 8, 16, 32)]
    assert orders(errors) == pytest.approx(2, abs=0.1)


def test_a_jump_keeps_the_order():
    """The drive's jump ends a step, so that nothing is smeared over it."""
    conductivity = 3e-6
    leak = PolarityConduction(conductivity_positive=conductivity, conductivity_negative=conductivity)
    drive = read_model(Drive, {"model": "Square", "high": 50, "low": -20, "frequency": 50})
    exact, _ = answers(conductivity)
    driven, leaking = answers()
    errors = []
    for count in (60, 120, 240, 480):
        grid = np.linspace(0, 30e-3, count + 1)
        found = follow(driven, leaking, drive, grid, leak=leak)
        errors.append(np.max(np.abs(found.field.after - transient({"E": exact}, drive, grid)["E"])))
        assert np.max(np.abs(found.field.after - found.field.before)[1:]) > 0.1 * np.max(
            np.abs(found.field.after)
        )
    assert orders(errors) == pytest.approx(2, abs=0.1)


@pytest.mark.parametrize(
    "element",
    [SeriesElement(), SeriesElement(resistance=1e3), SeriesElement(resistance=1e5, elastance=1e10, rate=5.0)],
)
@pytest.mark.parametrize(
    "drive", [RAMPS, {"model": "Square", "high": 50, "low": -20, "frequency": 50}], ids=["ramps", "square"]
)
def test_the_stated_error_bounds_the_error(drive, element):
    conductivity = 3e-6
    leak = PolarityConduction(conductivity_positive=conductivity, conductivity_negative=conductivity)
    drive = read_model(Drive, drive)
    exact, _ = answers(conductivity, element)
    driven, leaking = answers(element=element)
    time = np.linspace(0, 30e-3, 7)
    found = leaky_response({CONTROL: driven}, {CONTROL: leaking}, drive, time, leak=leak, control=CONTROL)
    field = transient({"E": exact}, drive, time)["E"]
    assert found.errors["step_error"] < leaks.TOLERANCE
    largest = np.max(np.abs(transient({"E": exact}, drive, np.linspace(0, 30e-3, 3001))["E"]))
    assert np.max(np.abs(found.found[CONTROL] - field)) < 2 * found.errors["step_error"] * largest
    assert f"{found.steps} steps" in found.reason


def test_coarse_steps_say_so(monkeypatch):
    """Steps that cannot be halved further leave a larger error, and it is told."""
    monkeypatch.setattr(steps, "MOST_HALVINGS", 1)
    monkeypatch.setattr(leaks, "TOLERANCE", 1e-12)
    driven, leaking = answers()
    found = leaky_response(
        {CONTROL: driven},
        {CONTROL: leaking},
        read_model(Drive, RAMPS),
        np.linspace(0, 30e-3, 3),
        leak=LEAKS["field"],
        control=CONTROL,
    )
    assert found.errors["step_error"] > 1e-8


def test_an_instant_is_the_instant_of_switching_on():
    driven, leaking = answers()
    drive = read_model(Drive, {"model": "Step", "level": 5})
    time = np.zeros(1)
    found = leaky_response(
        {CONTROL: driven}, {CONTROL: leaking}, drive, time, leak=LEAKS["field"], control=CONTROL
    )
    assert found.found[CONTROL] == pytest.approx([5 * driven.direct])
