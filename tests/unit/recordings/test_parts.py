"""Known parts from an impedance analyser, and the calibrations that are refused."""

from pathlib import Path

import numpy as np
import pytest

from electrovib.core.errors import InputError
from electrovib.recordings.spectra import fit_parallel_part

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
GRID = np.linspace(1e4, 1e5, 40)
has_data = pytest.mark.skipif(
    not FOLDER.exists(), reason="needs shared/data, which is not part of the repository"
)


def part(*, resistance=5e4, capacitance=3e-11, offset=0.0, noise=1e-3, seed=1):
    rng = np.random.default_rng(seed)
    exact = resistance * np.exp(1j * np.radians(offset)) / (1 + 2j * np.pi * GRID * resistance * capacitance)
    return exact * (1 + noise * (rng.normal(size=GRID.size) + 1j * rng.normal(size=GRID.size)))


def measured(name):
    rows = np.genfromtxt(FOLDER / name, delimiter=",", skip_header=1)[:, -3:]
    return rows[:, 0], rows[:, 1] * np.exp(1j * np.radians(rows[:, 2]))


def test_a_part_comes_back_with_its_intervals():
    inside = 0
    for seed in range(40):
        found = fit_parallel_part(GRID, part(seed=seed))
        for name, value in (("resistance", 5e4), ("capacitance", 3e-11), ("phase_offset", 0.0)):
            lower, upper = found.estimate.interval(name)
            inside += lower < value < upper
    assert 0.9 * 120 < inside < 120  # 95 % of 120 are 114; the standard deviation is 2.4


def test_a_small_offset_is_stated_and_a_large_one_refused():
    found = fit_parallel_part(GRID, part(offset=0.5))
    assert np.degrees(found.estimate.values["phase_offset"]) == pytest.approx(0.5, abs=0.1)
    assert found.capacitance == pytest.approx(3e-11, rel=0.02)
    # at the middle of the band, 3.6e4 Hz in logarithms, the phase is 18 degrees: d phi / d ln C = sin(2 phi)/2 = 0.3
    assert 0.01 < found.systematic_error < 0.1
    with pytest.raises(InputError, match=r"tends to -2\.\d+ degrees"):
        fit_parallel_part(GRID, part(offset=-2.5))


def test_rows_far_from_the_others_are_left_out():
    data = part()
    data[:2] *= np.exp(-0.3j)
    found = fit_parallel_part(GRID, data)
    assert found.left_out.tolist() == GRID[:2].tolist()
    assert found.capacitance == pytest.approx(3e-11, rel=0.02)


def test_another_part_is_refused():
    series = 1e3 + 1 / (2j * np.pi * GRID * 1e-9)
    with pytest.raises(InputError, match=r"bad calibration|another part"):
        fit_parallel_part(GRID, series)


def test_the_leads_are_taken_off():
    bare = fit_parallel_part(GRID, part(capacitance=4e-13))
    found = fit_parallel_part(GRID, part(capacitance=3.04e-11), stray_capacitance=bare.capacitance)
    assert found.capacitance == pytest.approx(3e-11, rel=0.01)


@pytest.mark.parametrize(
    ("frequency", "impedance", "words"),
    [
        (GRID[:5], part()[:5], "8 or more"),
        (-GRID, part(), "above 0"),
        (GRID, np.where(GRID > 5e4, np.nan, part()), "finite"),
    ],
)
def test_what_is_no_spectrum_is_refused(frequency, impedance, words):
    with pytest.raises(InputError, match=words):
        fit_parallel_part(frequency, impedance)


@has_data
def test_known_parts():
    bare = fit_parallel_part(*measured("Cal10k_51k.csv"))
    assert bare.resistance == pytest.approx(51e3, rel=0.02)
    both = fit_parallel_part(*measured("Cal10k_51kp33.csv"), stray_capacitance=bare.capacitance)
    assert both.resistance == pytest.approx(51e3, rel=0.02)
    assert both.capacitance == pytest.approx(33e-12, rel=0.11)  # 36.6 pF, and 36.2 without the leads


@has_data
def test_a_bad_calibration_is_refused():
    with pytest.raises(InputError, match="bad calibration"):
        fit_parallel_part(*measured("rcal_10k_20k_par101.csv"))
