"""Materials from measured spectra."""

from pathlib import Path

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.material import ColeCole, ConstantPhase, Prony
from electrovib.recordings.spectra import FORMS, fit_material, impedance_residual

GABRIEL = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance" / "gabriel_measured_skin_dry.txt"
GRID = np.geomspace(100, 1e5, 31)
TERM = {"strength": 1500.0, "relaxation_time": 2e-5, "broadening": 0.3}


def noisy(material, *, share=0.01, seed=1):
    rng = np.random.default_rng(seed)
    exact = material.complex_permittivity(GRID)
    return exact.real * (1 + share * rng.normal(size=GRID.size)) + 1j * exact.imag * (
        1 + share * rng.normal(size=GRID.size)
    )


def test_parameters_come_back_and_the_criterion_takes_their_form():
    true = ColeCole(permittivity_high=50.0, terms=[TERM], conductivity=1e-4)
    best = fit_material(GRID, noisy(true), forms=["ConstantPhase", "Debye", "ColeCole, 1 term"])[0]
    assert best.form == "ColeCole, 1 term"
    for path, value in {"terms.0.strength": 1500.0, "terms.0.broadening": 0.3, "conductivity": 1e-4}.items():
        lower, upper = best.estimate.interval(path, level=0.999)
        assert lower < value < upper
    assert best.permittivity_error == pytest.approx(0.01, rel=0.3)
    assert not best.outliers.any()


def test_a_power_law_is_not_taken_for_relaxations():
    true = ConstantPhase(permittivity=900.0, reference_frequency=1e3, exponent=0.8, conductivity=1e-5)
    best = fit_material(GRID, noisy(true), forms=["ConstantPhase", "Debye", "ColeCole, 1 term"])[0]
    assert best.form == "ConstantPhase"
    assert best.material.exponent == pytest.approx(0.8, abs=0.02)


def test_a_row_beside_its_neighbours_is_named_and_left_out():
    true = ColeCole(permittivity_high=50.0, terms=[TERM], conductivity=1e-4)
    data = noisy(true)
    data[7] = data[7].real * 1.15 + 1j * data[7].imag
    best = fit_material(GRID, data, forms=["ColeCole, 1 term"])[0]
    assert np.flatnonzero(best.outliers).tolist() == [7]


@pytest.mark.parametrize(
    ("frequency", "permittivity", "words"),
    [
        (GRID, np.full(31, 3.0 + 0j), "the data hold no loss"),
        (GRID, np.full(30, 3.0 - 1j), "same length"),
        (-GRID, np.full(31, 3.0 - 1j), "above 0"),
        (GRID, np.full(31, np.nan - 1j), "finite"),
    ],
)
def test_what_is_no_spectrum_is_refused(frequency, permittivity, words):
    with pytest.raises(InputError, match=words):
        fit_material(frequency, permittivity)


def test_an_unknown_form_is_refused_with_the_nearest():
    with pytest.raises(InputError, match="Did you mean 'ColeCole, 2 terms'"):
        fit_material(GRID, np.full(31, 3.0 - 1j), forms=["ColeCole, 2 term"])
    assert "Constant" in FORMS


@pytest.mark.slow
@pytest.mark.skipif(not GABRIEL.exists(), reason="needs shared/data, which is not part of the repository")
def test_dry_skin_as_measured_by_gabriel():
    table = np.loadtxt(GABRIEL, skiprows=2)
    table = table[table[:, 0] <= 1.0001e5]
    frequency = table[:, 0]
    loss = table[:, 3] / (2 * np.pi * frequency * eps0)
    best = fit_material(frequency, table[:, 1] - 1j * loss)[0]
    assert best.form.startswith("ColeCole")
    assert best.permittivity_error < 0.04
    assert best.conductivity_error < 0.03
    assert frequency[best.outliers] == pytest.approx([251.19], rel=1e-3)


def of_rows(material, grid, *, noise, seed=1):
    rng, exact = np.random.default_rng(seed), material.complex_permittivity(grid)
    real, imaginary = (part * (1 + noise * rng.normal(size=grid.size)) for part in (exact.real, exact.imag))
    return real + 1j * imaginary


@pytest.mark.slow
def test_four_cole_cole_terms_come_back():
    times, strengths = (2e-9, 5e-7, 5e-5, 4e-3), (40.0, 500.0, 5e3, 2e5)
    terms = [
        {"strength": strength, "relaxation_time": time, "broadening": 0.1}
        for strength, time in zip(strengths, times, strict=True)
    ]
    grid = np.geomspace(10, 1e8, 60)
    data = of_rows(ColeCole(permittivity_high=4.0, terms=terms, conductivity=2e-4), grid, noise=0.01)
    best = fit_material(grid, data, forms=["ColeCole, 2 terms", "ColeCole, 3 terms", "ColeCole, 4 terms"])[0]
    assert best.form == "ColeCole, 4 terms"
    found = sorted(best.material.terms, key=lambda term: term.relaxation_time)
    assert [term.relaxation_time for term in found] == pytest.approx(times, rel=0.05)
    assert [term.strength for term in found] == pytest.approx(strengths, rel=0.05)


def test_a_prony_sum_comes_back_with_its_number_of_terms():
    terms = [
        {"strength": strength, "relaxation_time": time}
        for strength, time in ((10.0, 1e-6), (50.0, 1e-4), (200.0, 1e-2))
    ]
    grid = np.geomspace(1, 1e7, 50)
    data = of_rows(Prony(permittivity_high=3.0, terms=terms, conductivity=1e-6), grid, noise=0.01)
    best = fit_material(grid, data, forms=["Prony, 2 terms", "Prony, 3 terms", "Prony, 4 terms"])[0]
    assert best.form == "Prony, 3 terms"
    assert sorted(term.strength for term in best.material.terms) == pytest.approx([10, 50, 200], rel=0.03)
    assert best.kramers_kronig == pytest.approx(0.01, rel=0.4)


def test_rows_of_several_sources_count_by_their_noise():
    true = ColeCole(permittivity_high=50.0, terms=[TERM], conductivity=1e-4)
    rough, fine = of_rows(true, GRID, noise=0.1, seed=2), of_rows(true, GRID, noise=0.005, seed=3)
    both, grid = np.concatenate([rough, fine]), np.concatenate([GRID, GRID])
    noise = np.repeat([0.1, 0.005], GRID.size)
    weighted = fit_material(grid, both, forms=["ColeCole, 1 term"], noise=noise)[0]
    alike = fit_material(grid, both, forms=["ColeCole, 1 term"])[0]
    name = "terms.0.strength"
    deviation = weighted.estimate.standard_deviations[name]
    assert deviation < 0.3 * alike.estimate.standard_deviations[name]
    assert abs(weighted.estimate.values[name] - 1500.0) < 3 * deviation
    assert 60 < weighted.estimate.sum_of_squares < 190  # 119 degrees of freedom
    assert np.isnan(weighted.kramers_kronig)  # repeated frequencies
    alone = fit_material(GRID, fine, forms=["ColeCole, 1 term"], noise=[[0.005], [0.005]])[0]
    assert alone.estimate.standard_deviations[name] == pytest.approx(deviation, rel=0.05)


@pytest.mark.parametrize("noise", [0.0, [0.1, 0.2, 0.3], np.full(31, np.nan)])
def test_a_noise_that_is_none_is_refused(noise):
    with pytest.raises(InputError, match="noise: expected"):
        fit_material(GRID, np.full(31, 3.0 - 1j), noise=noise)


def test_an_impedance_of_passive_parts_passes_the_linear_test_and_a_turned_one_fails():
    grid, rng = np.geomspace(1, 1e6, 50), np.random.default_rng(1)
    impedance = 1e3 + 1 / (1e-5 + 1e-8 * (2j * np.pi * grid) ** 0.8)
    noise = 0.01 * (rng.normal(size=50) + 1j * rng.normal(size=50))
    assert impedance_residual(grid, impedance) < 3e-3  # what the test resolves
    assert impedance_residual(grid, impedance * (1 + noise)) == pytest.approx(0.014, rel=0.3)
    assert impedance_residual(grid, impedance * np.exp(-0.2j)) > 0.1
    with pytest.raises(InputError, match="not 0"):
        impedance_residual(grid, 0 * impedance)
