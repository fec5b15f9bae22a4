"""Materials from measured spectra."""

from pathlib import Path

import numpy as np
import pytest

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.material import ColeCole, ConstantPhase
from electrovib.recordings.spectra import FORMS, fit_material

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
        (GRID, np.full(31, 3.0 + 0j), "declare the material lossless"),
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
