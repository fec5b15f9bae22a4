"""Materials from measured spectra, and rows that are none."""

from pathlib import Path

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.kramers_kronig import kramers_kronig_residual
from electrovib.physics.material import ColeCole, ConstantPhase, Prony
from electrovib.recordings.importing.own_material import SampleSpectrum
from electrovib.recordings.spectra.fitted import fit_samples
from electrovib.recordings.spectra.material import FittedSpectrum, consistency, fit_material

GABRIEL = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance" / "gabriel_measured_skin_dry.txt"
GRID = np.geomspace(100, 1e5, 31)
TERM = {"strength": 1500.0, "relaxation_time": 2e-5, "broadening": 0.3}
TRUE = ColeCole(permittivity_high=50.0, terms=[TERM], conductivity=1e-4)


def noisy(material, grid=GRID, *, noise=0.01, seed=1):
    rng, exact = np.random.default_rng(seed), material.complex_permittivity(grid)
    real, imaginary = (part * (1 + noise * rng.normal(size=grid.size)) for part in (exact.real, exact.imag))
    return real + 1j * imaginary


def test_parameters_come_back_and_the_criterion_takes_their_form():
    forms = ["ConstantPhase", "Debye", "ColeCole, 1 term"]
    best = fit_material(GRID, noisy(TRUE), forms=forms)[0]
    assert best.form == "ColeCole, 1 term"
    for path, value in {"terms.0.strength": 1500.0, "terms.0.broadening": 0.3, "conductivity": 1e-4}.items():
        lower, upper = best.estimate.interval(path, level=0.999)
        assert lower < value < upper
    assert best.permittivity_error == pytest.approx(0.01, rel=0.3)
    assert not best.outliers.any()
    power = ConstantPhase(permittivity=900.0, reference_frequency=1e3, exponent=0.8, conductivity=1e-5)
    best = fit_material(GRID, noisy(power), forms=forms)[0]
    assert best.form == "ConstantPhase"
    assert best.material.exponent == pytest.approx(0.8, abs=0.02)


def test_a_row_beside_its_neighbours_is_named_and_left_out():
    data = noisy(TRUE)
    data[7] = data[7].real * 1.15 + 1j * data[7].imag
    best = fit_material(GRID, data, forms=["ColeCole, 1 term"])[0]
    assert np.flatnonzero(best.outliers).tolist() == [7]


@pytest.mark.parametrize(
    ("frequency", "permittivity", "options", "words"),
    [
        (GRID, np.full(31, 3.0 + 0j), {}, "the data hold no loss"),
        (GRID, np.full(30, 3.0 - 1j), {}, "same length"),
        (-GRID, np.full(31, 3.0 - 1j), {}, "above 0"),
        (GRID, np.full(31, np.nan - 1j), {}, "finite"),
        (GRID, np.full(31, 3.0 - 1j), {"forms": ["ColeCole, 2 term"]}, "Did you mean 'ColeCole, 2 terms'"),
        (GRID, np.full(31, 3.0 - 1j), {"noise": 0.0}, "noise: expected"),
        (GRID, np.full(31, 3.0 - 1j), {"noise": [0.1, 0.2, 0.3]}, "noise: expected"),
        (GRID, np.full(31, 3.0 - 1j), {"noise": np.full(31, np.nan)}, "noise: expected"),
    ],
)
def test_what_is_no_spectrum_is_refused(frequency, permittivity, options, words):
    with pytest.raises(InputError, match=words):
        fit_material(frequency, permittivity, **options)


@pytest.mark.slow
@pytest.mark.skipif(not GABRIEL.exists(), reason="needs shared/data, which is not part of the repository")
def test_dry_skin_as_measured_by_gabriel():
    table = np.loadtxt(GABRIEL, skiprows=2)
    table = table[table[:, 0] <= 1.0001e5]
    loss = table[:, 3] / (2 * np.pi * table[:, 0] * eps0)
    best = fit_material(table[:, 0], table[:, 1] - 1j * loss)[0]
    assert best.form.startswith("ColeCole")
    assert best.permittivity_error < 0.04
    assert best.conductivity_error < 0.03
    assert table[best.outliers, 0] == pytest.approx([251.19], rel=1e-3)


def of_terms(*values, **more):
    return [{"strength": strength, "relaxation_time": time} | more for strength, time in values]


COLE = of_terms((40.0, 2e-9), (500.0, 5e-7), (5e3, 5e-5), (2e5, 4e-3), broadening=0.1)
SUMS = {
    "Prony, 3 terms": (
        Prony(
            permittivity_high=3.0,
            terms=of_terms((10.0, 1e-6), (50.0, 1e-4), (200.0, 1e-2)),
            conductivity=1e-6,
        ),
        np.geomspace(1, 1e7, 50),
    ),
    "ColeCole, 4 terms": (
        ColeCole(permittivity_high=4.0, terms=COLE, conductivity=2e-4),
        np.geomspace(10, 1e8, 60),
    ),
}


@pytest.mark.parametrize(
    "form", ["Prony, 3 terms", pytest.param("ColeCole, 4 terms", marks=pytest.mark.slow)]
)
def test_a_sum_comes_back_with_its_number_of_terms(form):
    (true, grid), name = SUMS[form], form.split(",")[0]
    data = noisy(true, grid)
    best = fit_material(grid, data, forms=[f"{name}, {count} terms" for count in (2, 3, 4)])[0]
    assert best.form == form
    found = sorted(best.material.terms, key=lambda term: term.relaxation_time)
    for term, known in zip(found, true.terms, strict=True):
        assert term.strength == pytest.approx(known.strength, rel=0.05 if name == "ColeCole" else 0.03)
        assert term.relaxation_time == pytest.approx(known.relaxation_time, rel=0.05)
    assert name == "ColeCole" or consistency(grid, data) == pytest.approx(0.01, rel=0.4)


def test_rows_of_several_sources_count_by_their_noise():
    rough, fine = noisy(TRUE, noise=0.1, seed=2), noisy(TRUE, noise=0.005, seed=3)
    both, grid = np.concatenate([rough, fine]), np.concatenate([GRID, GRID])
    of, name = {"forms": ["ColeCole, 1 term"]}, "terms.0.strength"
    weighted = fit_material(grid, both, noise=np.repeat([0.1, 0.005], GRID.size), **of)[0]
    alike = fit_material(grid, both, **of)[0]
    deviation = weighted.estimate.standard_deviations[name]
    assert deviation < 0.3 * alike.estimate.standard_deviations[name]
    assert abs(weighted.estimate.values[name] - 1500.0) < 3 * deviation
    assert 60 < weighted.estimate.sum_of_squares < 190  # 119 degrees of freedom
    assert np.isnan(consistency(grid, both))  # repeated frequencies
    alone = fit_material(GRID, fine, noise=[[0.005], [0.005]], **of)[0]
    assert alone.estimate.standard_deviations[name] == pytest.approx(deviation, rel=0.05)


def test_an_impedance_of_passive_parts_passes_the_linear_test_and_a_turned_one_fails():
    grid, rng = np.geomspace(1, 1e6, 50), np.random.default_rng(1)
    impedance = 1e3 + 1 / (1e-5 + 1e-8 * (2j * np.pi * grid) ** 0.8)
    noise = 0.01 * (rng.normal(size=50) + 1j * rng.normal(size=50))

    def residual(impedance):
        admittance = 1 / impedance
        return kramers_kronig_residual(grid, admittance.imag / (2 * np.pi * grid * eps0), admittance.real)

    assert residual(impedance) < 3e-3  # what the test resolves
    assert residual(impedance * (1 + noise)) == pytest.approx(0.014, rel=0.3)
    assert residual(impedance * np.exp(-0.2j)) > 0.1


def test_a_loss_that_vanishes_in_one_row_is_refused():
    grid = np.geomspace(1e2, 1e4, 6)
    data = np.full(6, 100.0 - 10.0j)
    fit_material(grid, data)
    data[3] = 100.0
    with pytest.raises(InputError, match="both above 0"):
        fit_material(grid, data)


def conducting_more_at_the_end(grid):
    """A table whose least conductivity no form of one term with its slope at high frequencies has."""
    permittivity = 1300.0 * (grid / 100) ** -0.05
    conductivity = 1.767e-4 * (1 + 0.02 * (100 / grid) ** 2 + (grid / 1e5) ** 1.6)
    return permittivity - 1j * conductivity / (2 * np.pi * grid * eps0)


@pytest.mark.parametrize("noise", [0.005, 0.02])
def test_the_conductivity_of_a_form_that_describes_the_rows_has_its_interval(noise):
    """Their course is steep above the level of the lowest few, whose noise is below and above it."""
    true = Prony(permittivity_high=100.0, terms=of_terms((900.0, 1e-4)), conductivity=1e-6)
    grid, inside = np.geomspace(10, 1e5, 25), 0
    for seed in range(12):
        rows = noisy(true, grid, noise=noise, seed=seed)
        sample = SampleSpectrum(frequency=grid, permittivity=rows, thickness=None, history=(), diagnostics=())
        found = {each.name: each for each in fit_samples({"a": sample}, form="debye").parameters}[
            "conductivity"
        ]
        assert not found.note
        inside += found.lower < 1e-6 < found.upper
    assert inside >= 9  # of 12; fewer in 1 of 500 runs of 95 % intervals


def test_a_form_has_no_more_conductivity_than_the_rows():
    data = conducting_more_at_the_end(GRID)
    least = float((-data.imag * 2 * np.pi * GRID * eps0).min())
    found = fit_material(GRID, data)
    for each in found:
        assert each.material.conductivity <= 1.002 * least, each.form
    for seed in range(20):  # flat rows scatter about the conductivity
        flat = np.full(31, 30.0 - 5e5j / GRID) * (1 + 0.01 * np.random.default_rng(seed).normal(size=31))
        fitted = fit_material(GRID, flat, forms=["Constant"])[0]
        mean = np.exp(np.log(-flat.imag * GRID).mean()) * 2 * np.pi * eps0
        assert fitted.material.conductivity == pytest.approx(mean, rel=1e-6)


@pytest.mark.parametrize("band", [(1.0, 1e9), (300.0, 1e9), (1.0, 2e4), (300.0, 2e4)])
def test_an_outlier_is_one_in_every_band(band):
    grid = np.geomspace(100, 1e5, 61)
    data = noisy(TRUE, grid, noise=0.005)
    data[20] = data[20].real * 1.1 + 1j * data[20].imag
    part = (grid >= band[0]) & (grid <= band[1])
    for forms in (["ColeCole, 1 term"], ["ConstantPhase"]):  # of which one misses the rows
        best = fit_material(grid[part], data[part], forms=forms)[0]
        assert grid[part][best.outliers].tolist() == [grid[20]]


def sample(data, grid=GRID):
    return SampleSpectrum(
        frequency=grid, permittivity=data, thickness=None, diagnostics=(), history=("rows",), per_farad=0.0
    )


def test_a_search_begins_within_the_range_of_each_parameter():
    material = Prony(permittivity_high=1.0, terms=of_terms((0.0, 1e-6)), conductivity=0.9)
    for name, each in FittedSpectrum.of(GRID, noisy(TRUE), None, "measured").free(material).items():
        assert each.lower <= each.start <= each.upper, name
        assert each.start > 0, name


def test_a_search_for_more_terms_than_the_rows_determine_is_ended():
    true, grid = SUMS["Prony, 3 terms"]
    found = fit_material(grid, noisy(true, grid, noise=0.002), forms=["Prony, 6 terms"])[0]
    assert found.estimate.evaluations < 300  # thousands until the sum of squares changes no more
    assert found.error < 0.003


def test_no_interval_leaves_the_range_of_its_parameter():
    wide = Prony(permittivity_high=2.0, terms=of_terms((500.0, 3e-8), (900.0, 2e-5)), conductivity=1e-4)
    found = fit_samples({"rows": sample(noisy(wide, noise=0.03))}, form="cole-cole-2")
    for each in found.parameters:
        for end in (each.lower, each.upper):
            assert not end < (1.0 if each.name == "permittivity_high" else 0.0)
        assert np.isnan(each.lower) or each.lower <= each.value <= each.upper


@pytest.mark.slow
def test_a_form_that_misses_the_rows_names_one_that_does_not_or_a_band():
    both = noisy(SUMS["Prony, 3 terms"][0], SUMS["Prony, 3 terms"][1], noise=0.002)
    with pytest.raises(InputError, match=r"--form (cole-cole-3|prony-3)"):
        fit_samples({"rows": sample(both, SUMS["Prony, 3 terms"][1])}, form="constant")
