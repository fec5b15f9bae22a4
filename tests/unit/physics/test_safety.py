"""Electrical limits, compared with numbers and derivations that do not come from this code."""

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


def off_the_table():
    return max(abs(paschen_voltage(gap=gap * 1e-6) - expected) for gap, expected in TABLE.items())


def test_paschen():
    assert off_the_table() <= 0.51
    # the minimum, e ln(1 + 1/gamma) B/A, is at A p d = e ln(1 + 1/gamma)
    lowest, product = np.e * np.log(101) * 2737.5 / 112.5, np.e * np.log(101) / 112.5
    place = product / 101.325 * 1e-2  # kPa cm to m
    assert paschen_voltage(gap=place) == pytest.approx(lowest, rel=1e-12)
    assert paschen_voltage(gap=1.01 * place) > lowest < paschen_voltage(gap=0.99 * place)
    assert paschen_voltage(gap=3e-6) == np.inf


@pytest.mark.parametrize("constant", ["PASCHEN_A", "PASCHEN_B"])
def test_a_constant_that_is_off_by_one_and_a_half_percent_is_seen(monkeypatch, constant):
    monkeypatch.setattr(safety, constant, 1.014 * getattr(safety, constant))
    assert off_the_table() > 2


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
    held = np.full(2, 10e-6)
    assert breakdown_share(fields[:2], held) == pytest.approx([900 / 307, 200 / 307], rel=2e-3)
    assert list(breakdown_share(fields[:2], held / 10)) == [0, 0]


def film(field, *, declared=None, permittivity=3.35, thickness=90e-6, substance=None):
    material = Constant(permittivity=permittivity, substance=substance)
    layer = Layer(thickness=thickness, material=material, breakdown_field=declared)
    return film_diagnostic("film", layer, field=field)


def of(substance, thickness):
    return {"substance": substance, "thickness": thickness}


POLYIMIDE, PARYLENE = of("polyimide", 90e-6), of("parylene_c", 25.4e-6)
DECLARE = "stack.film.material.substance or stack.film.breakdown_field"
NOTHING = "no breakdown strength is known"
FILMS = [
    # a declared strength comes first
    (99e6, {"declared": 100e6}, "ok", 100e6, "declared"),
    (101e6, {"declared": 100e6}, "warning", 100e6, "declared"),
    (130e6, {"declared": 200e6} | of("pet", 90e-6), "ok", 200e6, "declared"),
    # a polymer film is compared with the weakest of the library: at 90 um 100 MV/m of PET, 118 of polyimide, PTFE
    (99e6, {}, "ok", 100e6, "lowest breakdown strength of polymer films"),
    (101e6, {}, "warning", 100e6, "measured at 100 um (full text: data sheet of 6020 universal PET film"),
    (101e6, {}, "warning", 100e6, DECLARE),
    # another film is unknown
    (1e9, {"permittivity": 1.9}, "unknown", None, NOTHING),
    (1e9, {"permittivity": 4.6}, "unknown", None, NOTHING),
    (1e9, {"thickness": 3.7e-6}, "unknown", None, NOTHING),
    (1e9, {"thickness": 0.71e-3}, "unknown", None, NOTHING),
    # the strength comes with the substance
    (
        117e6,
        POLYIMIDE | {"permittivity": 3.9},
        "ok",
        118e6,
        "of polyimide, measured at 127 um (full text: data sheet",
    ),
    (119e6, POLYIMIDE, "warning", 118e6, "of polyimide"),
    # from a thinner film it shows nothing of a thicker one
    (1e6, of("polyimide", 300e-6), "unknown", 118e6, "thicker films usually hold less"),
    (119e6, of("polyimide", 300e-6), "warning", 118e6, ""),
    (1e6, of("polyimide", 1e-6), "ok", 118e6, "thinner films usually hold more"),
    # an unverified one is marked and never enough
    (100e6, PARYLENE, "unknown", 220.5e6, "measured at 25.4 um (unverified: "),
    (230e6, PARYLENE, "warning", 220.5e6, ""),
    (100e6, of("su8", 10e-6), "unknown", 440e6, "measured at a thickness that its source does not state"),
]


@pytest.mark.parametrize(("field", "layer", "state", "limit", "words"), FILMS)
def test_films(field, layer, state, limit, words):
    diagnostic = film(field, **layer)
    assert diagnostic.state == state
    assert diagnostic.limit == (limit and pytest.approx(limit, rel=1e-3))
    assert (diagnostic.value, diagnostic.unit) == ((field, "V/m") if limit else (None, diagnostic.unit))
    assert words in diagnostic.text


def test_skin_and_air():
    assert skin_diagnostic("stratum_corneum", voltage=9.9).state == "ok"
    assert skin_diagnostic("stratum_corneum", voltage=10.1).state == "warning"
    assert paschen_diagnostic(field=31e6, gap=10e-6).state == "warning"  # 310 V, 307 V allowed
    assert paschen_diagnostic(field=30e6, gap=10e-6).state == "ok"
    assert paschen_diagnostic(field=70e6, gap=4.9e-6).state == "unknown"
    assert emission_diagnostic(field=74e6).state == "ok"
    vanishing = emission_diagnostic(field=76e6, vanishing=True)
    assert vanishing.state == "warning"
    assert "vanishing" in vanishing.text
    assert emission_diagnostic(field=float("nan")).state == "unknown"


REACHED = {"voltage": 100.0, "current": 2e-3, "charge": 3e-9, "stored_energy": 4e-6, "body_current": 5e-4}


@pytest.mark.parametrize(("name", "value"), REACHED.items())
def test_each_limit_judges_its_own(name, value):
    assert limit_diagnostics(REACHED, Limits()) == []  # nothing that is not declared is judged
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
