"""Electrical limits, compared with numbers and derivations that do not come from this code."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.physics import safety
from electrovib.physics.limits import Limits, broken, limit_diagnostics
from electrovib.physics.material import Constant
from electrovib.physics.safety import (
    breakdown_share,
    electrowetting_voltage,
    emission_diagnostic,
    film_diagnostic,
    paschen_diagnostic,
    paschen_voltage,
    skin_diagnostic,
    sweat_diagnostic,
)
from electrovib.physics.stack import Layer

EPS0 = 8.8541878128e-12
TABLE = {5: 657, 7.5: 337, 10: 307, 15: 318, 20: 347, 30: 415, 50: 552, 100: 865}
"""Gap [um] to breakdown voltage [V] of air at 1 atm, computed apart from this code."""


@pytest.mark.parametrize(("gap", "expected"), TABLE.items())
def test_paschen(gap, expected):
    assert paschen_voltage(gap=gap * 1e-6) == pytest.approx(expected, abs=0.51)


@pytest.mark.parametrize("constant", ["PASCHEN_A", "PASCHEN_B"])
def test_a_constant_that_is_off_by_one_and_a_half_percent_is_seen(monkeypatch, constant):
    monkeypatch.setattr(safety, constant, 1.014 * getattr(safety, constant))
    errors = [abs(paschen_voltage(gap=gap * 1e-6) - expected) for gap, expected in TABLE.items()]
    assert max(errors) > 2


def test_paschens_minimum():
    """e ln(1 + 1/gamma) B/A at A p d = e ln(1 + 1/gamma)."""
    lowest, product = np.e * np.log(101) * 2737.5 / 112.5, np.e * np.log(101) / 112.5
    place = product / 101.325 * 1e-2  # kPa cm to m
    assert paschen_voltage(gap=place) == pytest.approx(lowest, rel=1e-12)
    assert paschen_voltage(gap=1.01 * place) > lowest < paschen_voltage(gap=0.99 * place)
    assert paschen_voltage(gap=3e-6) == np.inf


def test_electrowetting_is_where_the_films_energy_is_the_surface_tension():
    """Young-Lippmann: cos(theta) changes by (C V^2/2)/gamma, C = eps0 eps/T; by 1 at this voltage."""
    voltage = electrowetting_voltage(thickness=2e-6, permittivity=3.0)
    assert EPS0 * 3.0 / 2e-6 * voltage**2 / 2 == pytest.approx(0.072, rel=1e-12)
    assert voltage == pytest.approx(104.13, abs=0.01)
    diagnostic = sweat_diagnostic(voltage=104.2, electrical_thickness=2e-6 / 3.0)
    assert (diagnostic.state, diagnostic.limit) == ("warning", pytest.approx(voltage))
    assert sweat_diagnostic(voltage=104.1, electrical_thickness=2e-6 / 3.0).state == "ok"


def test_the_nearest_to_breakdown_is_neither_the_largest_field_nor_the_smallest_gap():
    """The law does not apply at 1 um; 10 um holds 307 V, here at 200 V; 100 um holds 865 V, here at 800 V."""
    fields, gaps = np.array([90e6, -20e6, 8e6, 1e6]), np.array([1e-6, 10e-6, 100e-6, 5e-6])
    assert breakdown_share(fields, gaps) == pytest.approx([0, 200 / 307, 800 / 865, 5 / 657], rel=2e-3)
    assert breakdown_share(fields[1:2], gaps[1:2]) == pytest.approx([200 / 307], rel=2e-3)


def film(field, *, declared=None, permittivity=3.35, thickness=90e-6, substance=None):
    material = Constant(permittivity=permittivity, substance=substance)
    layer = Layer(thickness=thickness, material=material, breakdown_field=declared)
    return film_diagnostic("film", layer, field=field)


def test_a_declared_strength_comes_first():
    assert film(99e6, declared=100e6).state == "ok"
    beyond = film(101e6, declared=100e6)
    assert (beyond.state, beyond.value, beyond.limit, beyond.unit) == ("warning", 101e6, 100e6, "V/m")
    assert "declared" in beyond.text
    assert film(130e6, declared=200e6, substance="pet").state == "ok"


def test_a_polymer_film_is_compared_with_the_weakest_of_the_library():
    """At 90 um the data sheets guarantee 100 MV/m of PET, 118 of polyimide and of PTFE."""
    assert film(99e6).state == "ok"
    diagnostic = film(101e6)
    assert (diagnostic.state, diagnostic.limit) == ("warning", 100e6)
    assert "lowest breakdown strength of polymer films" in diagnostic.text
    assert "measured at 100 um (full text: data sheet of 6020 universal PET film" in diagnostic.text
    assert "stack.film.material.substance or stack.film.breakdown_field" in diagnostic.text


@pytest.mark.parametrize(
    "other",
    [{"permittivity": 1.9}, {"permittivity": 4.6}, {"thickness": 3.7e-6}, {"thickness": 0.71e-3}],
)
def test_another_film_is_unknown(other):
    diagnostic = film(1e9, **other)
    assert diagnostic.state == "unknown"
    assert diagnostic.value is None
    assert "no breakdown strength is known" in diagnostic.text


def test_the_strength_comes_with_the_substance():
    diagnostic = film(117e6, substance="polyimide", permittivity=3.9)
    assert (diagnostic.state, diagnostic.limit) == ("ok", 118e6)
    assert (
        "the breakdown strength of polyimide, measured at 127 um (full text: data sheet of Kapton"
        in diagnostic.text
    )
    assert film(119e6, substance="polyimide").state == "warning"


def test_a_strength_from_a_thinner_film_shows_nothing_of_a_thicker_one():
    within = film(1e6, substance="polyimide", thickness=300e-6)
    assert (within.state, within.limit) == ("unknown", 118e6)
    assert "thicker films usually hold less" in within.text
    assert film(119e6, substance="polyimide", thickness=300e-6).state == "warning"
    thin = film(1e6, substance="polyimide", thickness=1e-6)
    assert thin.state == "ok"
    assert "thinner films usually hold more" in thin.text


def test_an_unverified_strength_is_marked_and_never_enough():
    within = film(100e6, substance="parylene_c", thickness=25.4e-6)
    assert (within.state, within.limit) == ("unknown", pytest.approx(220.5e6, rel=1e-3))
    assert "measured at 25.4 um (unverified: " in within.text
    assert film(230e6, substance="parylene_c", thickness=25.4e-6).state == "warning"
    unstated = film(100e6, substance="su8", thickness=10e-6)
    assert unstated.state == "unknown"
    assert "measured at a thickness that its source does not state" in unstated.text


def test_skin():
    assert skin_diagnostic("stratum_corneum", voltage=9.9).state == "ok"
    assert skin_diagnostic("stratum_corneum", voltage=10.1).state == "warning"


def test_air():
    assert paschen_diagnostic(field=31e6, gap=10e-6).state == "warning"  # 310 V, 307 V allowed
    assert paschen_diagnostic(field=30e6, gap=10e-6).state == "ok"
    assert paschen_diagnostic(field=70e6, gap=4.9e-6).state == "unknown"
    assert emission_diagnostic(field=74e6).state == "ok"
    vanishing = emission_diagnostic(field=76e6, vanishing=True)
    assert vanishing.state == "warning"
    assert "vanishing" in vanishing.text
    assert emission_diagnostic(field=float("nan")).state == "unknown"


REACHED = {"voltage": 100.0, "current": 2e-3, "charge": 3e-9, "stored_energy": 4e-6, "body_current": 5e-4}


def test_nothing_that_is_not_declared_is_judged():
    assert limit_diagnostics(REACHED, Limits()) == []


@pytest.mark.parametrize(("name", "value"), REACHED.items())
def test_each_limit_judges_its_own(name, value):
    (diagnostic,) = limit_diagnostics(REACHED, Limits(**{name: 1.01 * value}))
    assert (diagnostic.name, diagnostic.state, diagnostic.value) == (name.replace("_", " "), "ok", value)
    (diagnostic,) = limit_diagnostics(REACHED, Limits(**{name: 0.99 * value}))
    assert diagnostic.state == "warning"
    assert f"limits.{name}" in diagnostic.text
    assert broken([diagnostic, film(1e9)]) == [diagnostic]


def test_the_step_at_the_start_is_judged_separately():
    reached = {"current": 5.85e-3, "current at switch-on": 0.1}
    running, jump = limit_diagnostics(reached, Limits(current=10e-3))
    assert (running.state, running.value) == ("ok", 5.85e-3)
    assert (jump.state, jump.value, jump.name) == ("warning", 0.1, "current at switch-on")
    assert "in the step at time 0" in jump.text
