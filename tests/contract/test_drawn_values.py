"""Figures and tables of answers show the numbers of the answers."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.answer import REFERENCE
from electrovib.physics.material import Debye
from electrovib.recordings.importing.own_material import SampleSpectrum
from electrovib.recordings.spectra.fitted import InstrumentError, fit_samples
from electrovib.recordings.spectra.material import FittedSpectrum
from electrovib.solve.equilibrium import equilibrium

GRID = np.geomspace(10.0, 1e5, 25)
SKIN = Debye(permittivity_high=100.0, strength=900.0, relaxation_time=1e-4, conductivity=1e-6)


def test_the_curves_of_a_power_law_pass_its_points():
    x = np.array([10.0, 20.0, 40.0, 80.0])
    law = ev.fit_power_law(
        np.tile(x, 2), np.concatenate([2e-6 * x**2, 5e-6 * x**1.5]), session=list("aaaabbbb")
    )
    points_a, law_a, points_b, law_b = law.document.figures[0].curves
    for points, curve in ((points_a, law_a), (points_b, law_b)):
        np.testing.assert_allclose(
            np.interp(points.x[[0, -1]], curve.x, curve.y), points.y[[0, -1]], rtol=1e-9
        )
    assert [row[0] for row in law.document.numbers[0].rows] == ["a", "b"]


def test_every_point_of_a_power_law_is_drawn_and_five_sessions_have_a_colour():
    x, names = np.tile([10.0, 20.0, 40.0], 7), [name for name in "abcdefg" for _ in range(3)]
    factors = np.repeat(1e-6 * np.arange(1, 8), 3)
    noise = 1 + 0.01 * np.random.default_rng(2).normal(size=21)
    curves = ev.fit_power_law(x, factors * x**2 * noise, session=names).document.figures[0].curves
    points, laws = curves[::2], curves[1::2]
    assert all(each.drawn for each in points)
    assert [each.drawn for each in laws] == [True] * 5 + [False] * 2
    assert [each.look for each in points] == [0, 1, 2, 3, 4, REFERENCE, REFERENCE]


def test_the_curve_of_a_bench_plan_is_its_burst():
    plan = ev.plan_bench("vezzoli_2014/fig6")
    points, drive = plan.document.figures[0].curves
    assert (points.x[0], points.x[-1]) == pytest.approx((0.0, plan.duration))
    assert points.y.max() == pytest.approx(plan.peak, rel=1e-3)
    np.testing.assert_allclose(np.interp(drive.x, points.x, points.y), drive.y, atol=0.01 * plan.peak)


def test_the_curve_of_a_held_waveform_is_that_of_its_samples(tmp_path):
    limits = {"limits.voltage": "1 kV", "limits.current": "10 mA"}
    written = ev.export_waveform(
        "bau_2010/sine",
        tmp_path / "a.csv",
        set=limits,
        instrument="hp_33120a",
        edge=1e-5,
        ramp=1e-3,
        scaling=ev.Scaling(gain=20.0),
    )
    (curve,) = written.document.figures[0].curves
    wave = written.waveform
    assert wave.held
    middle = wave.times + 0.5 / wave.rate
    np.testing.assert_allclose(np.interp(middle, curve.x, curve.y), wave.voltages, atol=1e-9)
    assert curve.x[-1] == pytest.approx(wave.times[-1] + 1 / wave.rate)


def test_the_rows_of_equilibria_say_which_are_stable():
    changes = {
        "contact.surface": {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"},
        "stack.gap.material.conductivity": 0.0,
    }
    found = equilibrium(ev.load("vezzoli_2014/fig6_gap", changes=changes))
    rows = found.document.numbers[0].rows
    assert [row[3].startswith("stable") for row in rows] == [state.stable for state in found.states]
    assert any(state.stable for state in found.states)


def test_the_form_of_a_fitted_material_is_drawn_through_its_rows_with_both_errors():
    sample = SampleSpectrum(
        frequency=GRID,
        permittivity=SKIN.complex_permittivity(GRID),
        thickness=None,
        history=(),
        diagnostics=(),
    )
    found = fit_samples({"skin": sample}, form="debye", error=InstrumentError(gain=0.02, words="as declared"))
    for panel, part in zip(found.document.figures, ("permittivity", "conductivity"), strict=True):
        rows, form = panel.curves
        assert panel.id == part
        np.testing.assert_allclose(
            np.exp(np.interp(np.log(rows.x), np.log(form.x), np.log(form.y))), rows.y, rtol=1e-2
        )
    assert "extrapolated below the lowest frequency measured" in repr(found)  # why it is not judged
    (strength,) = (row for row in found.document.numbers[0].rows if row[0] == "strength")
    assert strength[2] == "+- 35"  # 1.96 times 2 % of 900


def test_the_bound_of_a_conductivity_narrows_with_the_rows_of_its_level():
    noise, rng = 0.01, np.random.default_rng(5)
    loss = 5e5 / np.geomspace(10, 1e3, 64) * (1 + noise * rng.normal(size=64))
    kept = FittedSpectrum.of(np.geomspace(10, 1e3, 64), 100 - 1j * loss, np.full(64, noise), "measured")
    assert (
        0.0 < kept.free(SKIN)["conductivity"].upper / (5e5 * 2 * np.pi * 8.8541878128e-12) - 1 < 5 * noise / 4
    )
