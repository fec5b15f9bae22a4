"""Debye terms of polarisation spectra: accuracy, exactness, noise, refusals, passivity."""

import subprocess
import sys
from itertools import pairwise

import numpy as np
import pytest
import scipy.optimize
from hypothesis import given, settings
from hypothesis import strategies as st

from electrovib.core.errors import InputError
from electrovib.physics.debye_sum import DebyeSum
from electrovib.solve.stack import prony
from electrovib.solve.stack.prony import Spectrum, Terms, fit_debye, fit_debye_table, nonnegative, tidied

SHIPPED = 1e-3
"""The target of the package; 3.2e-4 was measured on the worst of the shipped skins."""
BAND = {"low": 1.0, "high": 1e6}


def constant_phase(exponent, corner):
    shift = exponent - 1
    return lambda f: 1560 * (1j * f / corner) ** shift / np.cos(shift * np.pi / 2)


def cole_cole(high, *rows):
    def law(f):
        s = 2j * np.pi * f
        return high + sum(step / (1 + (s * time) ** (1 - broad)) for step, time, broad in rows)

    return law


def havriliak_negami(high, step, time, alpha, beta):
    return lambda f: high + step / (1 + (2j * np.pi * f * time) ** alpha) ** beta


WET = ((39, 7.958e-12, 0.1), (280, 79.577e-9, 0), (3e4, 1.592e-6, 0.16), (3e4, 1.592e-3, 0.2))
SPECTRA = {
    "constant phase 0.7545": constant_phase(0.7545, 50.9),
    "constant phase 0.8025": constant_phase(0.8025, 64.5),
    "constant phase 0.85": constant_phase(0.85, 86.1),
    "Gabriel dry": cole_cole(4.0, (32, 7.234e-12, 0), (1100, 32.481e-9, 0.2)),
    "Gabriel wet": cole_cole(4.0, *WET),
    "Havriliak-Negami 0.8, 0.5": havriliak_negami(5, 1000, 1e-4, 0.8, 0.5),
    "Havriliak-Negami 0.6, 1.6": havriliak_negami(5, 1000, 1e-4, 0.6, 1.6),
    "Cole-Davidson 0.5": havriliak_negami(2, 500, 1e-5, 1.0, 0.5),
    "a huge step": havriliak_negami(1.0, 1e12, 1e-4, 0.8, 0.5),
}
TWO = DebyeSum(5.0, (80.0, 300.0), (2e-5, 3e-3))


def rms_error(fit, frequency, measured):
    """Root mean square of the modulus of fit/measured - 1."""
    return np.sqrt(np.mean(np.abs(fit.debye.permittivity(frequency) / measured - 1) ** 2))


def with_noise(values, noise, seed):
    parts = np.random.default_rng(seed).normal(0, noise, (2, values.size))
    return values * (1 + parts[0] + 1j * parts[1])


@pytest.mark.parametrize("name", SPECTRA)
def test_follows_shipped_spectra_over_six_decades_with_the_error_it_reports(name):
    fit = fit_debye(SPECTRA[name], **BAND)
    assert fit.largest_error < SHIPPED
    assert 1 <= len(fit.debye.strengths) <= 14
    assert all(one < next_one for one, next_one in pairwise(fit.debye.relaxation_times))
    frequency = np.geomspace(1.0, 1e6, 3457)
    response = np.full(frequency.shape, fit.debye.high, dtype=complex)
    for strength, time in zip(fit.debye.strengths, fit.debye.relaxation_times, strict=True):
        response += strength / (1 + 2j * np.pi * frequency * time)
    error = np.abs(response / SPECTRA[name](frequency) - 1)
    # both grids miss the peaks of the error by a little; 60 points a decade against 8 peaks in a decade
    assert fit.largest_error == pytest.approx(error.max(), rel=0.02)
    assert name != "Gabriel wet" or fit_debye(SPECTRA[name], **BAND) == fit  # repeats to the last digit


def test_error_bound_can_fail_and_more_terms_fit_better():
    # outside alpha beta <= 1 no non-negative sum exists: with the same terms the fit stalls and says so
    assert fit_debye(havriliak_negami(5, 1000, 1e-4, 0.6, 1.8), **BAND).largest_error > 0.02
    law = SPECTRA["constant phase 0.85"]
    errors = [fit_debye(law, **BAND, terms=count).largest_error for count in (4, 8, 12)]
    assert errors[0] > 5 * errors[1] > 25 * errors[2]


@pytest.mark.parametrize(
    "law", [TWO, DebyeSum(4.0, (1000.0,), (1e-3,)), DebyeSum(3.35)], ids=["two", "one", "none"]
)
def test_recovers_debye_terms_and_their_number(law):
    fit = fit_debye(law.permittivity, **BAND)
    # 2e-15 was measured; 1e-9 leaves room for other linear algebra and is below any grid's spacing
    assert fit.largest_error < 1e-9
    assert fit.debye.strengths == pytest.approx(law.strengths, rel=1e-6)
    assert fit.debye.relaxation_times == pytest.approx(law.relaxation_times, rel=1e-6)
    assert fit.debye.high == pytest.approx(law.high, rel=1e-6)


def test_relaxations_on_a_dense_grid_are_found_where_even_times_leave_more_terms():
    """Even times alone end with seven terms, whose sum is as good to 1e-12."""
    law = DebyeSum(5.0, (10.0, 300.0, 50.0, 4000.0), (2e-6, 1e-4, 3e-3, 2e-2))
    fit = fit_debye(law.permittivity, low=0.1, high=1e6, terms=10)
    assert fit.debye.strengths == pytest.approx(law.strengths, rel=1e-6)
    assert fit.debye.relaxation_times == pytest.approx(law.relaxation_times, rel=1e-6)


def test_terms_that_coincide_become_one():
    angular = np.geomspace(1, 1e6, 20)
    spectrum = Spectrum(angular=angular, target=np.full(20, 3.0 + 0j), fastest=1e-9, slowest=1e3)
    pieces = Terms(2.0, np.array([3.0, 1.0, 1e-20, 5.0]), np.array([1e-3, 1.00002e-3, 1e-4, 1e-6]))
    tidy = tidied(spectrum, pieces)
    assert tidy.strengths == pytest.approx([5.0, 4.0], rel=1e-12)
    assert tidy.times == pytest.approx([1e-6, 1.000005e-3], rel=1e-12)


def test_slowest_limits_the_times():
    law = SPECTRA["constant phase 0.8025"]
    fit, free = (fit_debye(law, low=10.0, high=1e6, slowest=slowest) for slowest in (1e-3, None))
    assert max(fit.debye.relaxation_times) <= 1e-3
    assert max(free.debye.relaxation_times) > 1 / (2 * np.pi * 10)
    assert free.largest_error < fit.largest_error


POINTS = np.geomspace(10, 1e6, 51)


@pytest.mark.parametrize("name", ["Gabriel wet", "Gabriel dry", "Havriliak-Negami 0.8, 0.5"])
@pytest.mark.parametrize("noise", [0.01, 0.03])
def test_table_fit_stays_within_the_noise(name, noise):
    """Below 100 kHz dry skin loses less than 1 %, so 3 % of noise gives many points with eps'' < 0: not active."""
    fine, errors = np.geomspace(10, 1e6, 401), []
    for seed in range(5):
        measured = with_noise(SPECTRA[name](POINTS), noise, seed)
        fit = fit_debye_table(POINTS, measured)
        assert max(fit.debye.relaxation_times) <= 1 / (2 * np.pi * 10)
        error = np.abs(fit.debye.permittivity(fine) / SPECTRA[name](fine) - 1)
        errors.append((np.sqrt(np.mean(error**2)), error.max()))
        # the noise of 51 complex values, of modulus sqrt(2) times one part, stays in the reported error
        assert 0.9 * noise < rms_error(fit, POINTS, measured) < 1.8 * noise
    # of 20 seeds, in units of the noise: worst root mean square 0.7, worst largest 2.8, median largest 1.2
    assert max(mean for mean, _ in errors) < noise
    assert np.median([largest for _, largest in errors]) < 2 * noise
    assert noise < 0.03 or name != "Gabriel dry" or (measured.imag > 0).sum() > 10


def test_table_leaves_slower_loss_to_conduction_unless_told_and_takes_few_points_in_any_order():
    values = SPECTRA["constant phase 0.7545"](POINTS)
    # measured 0.06 and 1.3e-4: a constant phase has half of its slow loss below the band
    assert 0.03 < fit_debye_table(POINTS, values).largest_error < 0.1
    assert fit_debye_table(POINTS, values, slowest=10 / (2 * np.pi * 10)).largest_error < SHIPPED
    frequency = np.array([1e2, 1e3, 1e4, 1e5])
    fit = fit_debye_table(frequency, SPECTRA["constant phase 0.85"](frequency))
    assert len(fit.debye.strengths) <= 3
    assert fit.largest_error < 0.1


@pytest.mark.parametrize(
    "law",
    [
        lambda f: np.conj(SPECTRA["Gabriel wet"](f)),
        lambda f: SPECTRA["Gabriel dry"](f) + 20j,
        # less than nothing at low frequency: too much conduction was taken out
        lambda f: TWO.permittivity(f) + 1e-3j / (2 * np.pi * f * 1e-5),
    ],
)
def test_refuses_active_laws(law):
    frequency = np.geomspace(1.0, 1e6, 51)
    with pytest.raises(InputError, match="eps'' < 0"):
        fit_debye(law, **BAND)
    with pytest.raises(InputError, match="eps'' < 0"):
        fit_debye_table(frequency, law(frequency))


def test_refuses_a_gain_that_shows_only_in_the_mean_of_neighbours_or_in_one_point_of_a_clean_table():
    # 4 % of gain in 1 % of noise: no single point stands out by itself from 51, five together do
    for seed in range(5):
        with pytest.raises(InputError, match="eps'' < 0"):
            fit_debye_table(POINTS, with_noise(np.full(51, 1000 * (1 + 0.04j)), 0.01, seed))
        measured = with_noise(np.full(51, 1000.0), 0.01, seed)
        assert rms_error(fit_debye_table(POINTS, measured), POINTS, measured) < 0.02
    values = np.full(21, 5.0 + 0j)
    values[10] += 5 * 1.5e-3j
    with pytest.raises(InputError, match="near 100 Hz"):
        fit_debye_table(np.geomspace(1, 1e4, 21), values)


def fit_of(law=SPECTRA["Gabriel wet"], **changes):
    return fit_debye(law, **BAND | changes)


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: fit_of(lambda f: np.full(f.shape, np.nan)), "is not finite"),
        (lambda: fit_of(lambda f: -2.0 + 0 * f), "real part <= 0"),
    ],
)
def test_refuses_laws_that_are_no_dielectric(call, message):
    with pytest.raises(InputError, match=message):
        call()


def test_survives_strengths_that_are_not_the_best_or_tiny(monkeypatch):
    monkeypatch.setattr(prony, "ENTRIES", 1)
    # a wide law and few terms: 8 terms give 0.73 %
    fit = fit_debye(SPECTRA["constant phase 0.85"], **BAND, terms=8)
    assert fit.largest_error < 0.02
    assert min(fit.debye.strengths) > 0
    tiny = fit_debye(havriliak_negami(1.0, 1e-12, 1e-4, 0.8, 0.5), **BAND)
    assert tiny.largest_error < SHIPPED
    assert np.all(np.isfinite(tiny.debye.strengths))


@pytest.mark.parametrize("columns", [1, 5, 21])
def test_nonnegative_least_squares_are_those_of_scipy(columns):
    generator = np.random.default_rng(columns)
    for _ in range(50):
        matrix, wanted = generator.normal(size=(40, columns)), generator.normal(size=40)
        matrix /= np.linalg.norm(matrix, axis=0)
        found = nonnegative(matrix.T @ matrix, matrix.T @ wanted)
        assert found == pytest.approx(scipy.optimize.nnls(matrix, wanted)[0], abs=1e-10)


@settings(max_examples=25, deadline=None)
@given(
    high=st.floats(1, 100),
    step=st.floats(1, 1e5),
    time=st.floats(-8, 1).map(lambda x: 10.0**x),
    alpha=st.floats(0.2, 1.0),
    share=st.floats(0.2, 1.0),
)
def test_passive_far_outside_the_band(high, step, time, alpha, share):
    fit = fit_debye(havriliak_negami(high, step, time, alpha, share / alpha), **BAND)
    assert fit.debye.high > 0
    assert all(strength >= 0 for strength in fit.debye.strengths)
    values = fit.debye.permittivity(np.geomspace(0.1, 1e9, 500))
    assert (values.imag <= 0).all()
    assert (values.real > 0).all()
    # inside alpha <= 1 and alpha beta <= 1 a non-negative form exists, and 14 terms come near it
    assert fit.largest_error < 0.01


def test_a_fit_needs_no_scipy():
    """The first run of a process with a dispersive skin does not wait for its import."""
    code = (
        "import sys, numpy as np; from electrovib.solve.stack.prony import fit_debye\n"
        "fit_debye(lambda f: 5 + 100 / (1 + 1j * f / 1e3) ** 0.5, low=1.0, high=1e6)\n"
        "assert not any(name.startswith('scipy') for name in sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True)
