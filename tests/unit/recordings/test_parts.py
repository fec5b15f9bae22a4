"""Known parts and the constant phase error of an impedance analyser, and the calibrations that are refused."""

import json
from contextlib import nullcontext
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.importing.own_material import fit_parallel_part, phase_offset

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
has_data = pytest.mark.skipif(
    not FOLDER.exists(), reason="needs shared/data, which is not part of the repository"
)
GRID = np.geomspace(1e3, 1e5, 40)
TURNS = 2j * np.pi * GRID
EVEN = np.linspace(1e4, 1e5, 40)


def noisy(exact, *, noise=3e-3, seed=1):
    rng = np.random.default_rng(seed)
    return exact * (1 + noise * (rng.normal(size=40) + 1j * rng.normal(size=40)))


def part(*, resistance=5e4, capacitance=3e-11, offset=0.0, seed=1):
    exact = resistance * np.exp(1j * np.radians(offset)) / (1 + 2j * np.pi * EVEN * resistance * capacitance)
    return noisy(exact, noise=1e-3, seed=seed)


RC = 1 / (1 / 5e4 + TURNS * 3e-11)


def measured(name):
    rows = np.genfromtxt(FOLDER / name, delimiter=",", skip_header=1)[:, -3:]
    return rows[:, 0], rows[:, 1] * np.exp(1j * np.radians(rows[:, 2]))


def test_a_part_comes_back_with_its_intervals():
    inside = 0
    for seed in range(40):
        found = fit_parallel_part(EVEN, part(seed=seed))
        for name, value in (("resistance", 5e4), ("capacitance", 3e-11), ("phase_offset", 0.0)):
            lower, upper = found.estimate.interval(name)
            inside += lower < value < upper
    assert 0.9 * 120 < inside < 120  # 95 % of 120 are 114; the standard deviation is 2.4


def test_a_small_offset_is_stated_the_leads_are_taken_off_and_rows_far_off_left_out():
    found = fit_parallel_part(EVEN, part(offset=0.5))
    assert np.degrees(found.estimate.values["phase_offset"]) == pytest.approx(0.5, abs=0.1)
    assert found.capacitance == pytest.approx(3e-11, rel=0.02)
    data = part()
    data[:2] *= np.exp(-0.3j)
    found = fit_parallel_part(EVEN, data)
    assert found.capacitance == pytest.approx(3e-11, rel=0.02)
    bare = fit_parallel_part(EVEN, part(capacitance=4e-13))
    found = fit_parallel_part(EVEN, part(capacitance=3.04e-11))
    assert found.capacitance - bare.capacitance == pytest.approx(3e-11, rel=0.01)


@pytest.mark.parametrize(
    ("frequency", "impedance", "words"),
    [
        (EVEN[:5], part()[:5], "8 or more"),
        (-EVEN, part(), "above 0"),
        (EVEN, np.where(EVEN > 5e4, np.nan, part()), "finite"),
        (EVEN, part(offset=-2.5), r"tends to -2\.\d+ degrees"),
        (EVEN, 1e3 + 1 / (2j * np.pi * EVEN * 1e-9), r"bad calibration|another part"),
    ],
)
def test_another_part_and_what_is_no_spectrum_are_refused(frequency, impedance, words):
    with pytest.raises(InputError, match=words):
        fit_parallel_part(frequency, impedance)


@has_data
def test_known_parts_as_measured_and_a_bad_calibration():
    bare = fit_parallel_part(*measured("Cal10k_51k.csv"))
    assert bare.resistance == pytest.approx(51e3, rel=0.02)
    both = fit_parallel_part(*measured("Cal10k_51kp33.csv"))
    assert both.resistance == pytest.approx(51e3, rel=0.02)
    # 36.6 pF, and 36.2 without the leads
    assert both.capacitance - bare.capacitance == pytest.approx(33e-12, rel=0.11)
    with pytest.raises(InputError, match="bad calibration"):
        fit_parallel_part(*measured("rcal_10k_20k_par101.csv"))


@pytest.mark.parametrize("degrees", [-3.0, 2.0])
@pytest.mark.parametrize("exact", [RC, np.full(40, 2e4 + 0j), 1 / (TURNS * 1e-10)], ids=["RC", "R", "C"])
def test_the_phase_of_a_bad_calibration_is_found(exact, degrees):
    found = phase_offset(GRID, noisy(exact * np.exp(1j * np.radians(degrees))))
    assert np.degrees(found.phase) == pytest.approx(degrees, abs=0.15)
    assert found.misfit == pytest.approx(3e-3 * np.sqrt(2), rel=0.2)
    assert found.inconsistent > 2 * found.misfit


def test_the_misfit_is_the_noise_of_a_row():
    turned = RC * np.exp(-0.05j)
    found = [phase_offset(GRID, noisy(turned, seed=seed)).misfit for seed in range(20)]
    assert np.sqrt(np.mean(np.square(found))) == pytest.approx(3e-3 * np.sqrt(2), rel=0.06)


@pytest.mark.parametrize(
    "exact",
    [
        RC,
        RC * np.exp(0.9j * np.pi / 180),  # within what a calibration may leave
        1 / (1 / 5e4 + 1e-9 * TURNS**0.8),
        5e4 * (TURNS / 1e5) ** -0.04,  # -3.6 degrees, with the modulus that belongs to them
        5e4 * (TURNS / 1e5) ** -0.02,  # -1.8 degrees: only the modulus distinguishes it from a wrong phase
        5e4 + 1 / (1e-4 + TURNS * 1e-6),
        RC + 1 / (1 / 3e3 + TURNS * 1e-8),
    ],
    ids=["RC", "small", "RCPE", "CPE", "flat CPE", "series", "two"],
)
def test_causal_parts_have_none(exact):
    assert all(phase_offset(GRID, noisy(exact, noise=size)) is None for size in (1e-5, 1e-3, 1e-2))


def test_few_wrong_rows_hide_nothing_and_many_are_not_judged():
    turned = noisy(RC * np.exp(-0.06j))
    turned[:2] *= np.exp(-0.3j)
    assert np.degrees(phase_offset(GRID, turned).phase) == pytest.approx(-3.44, abs=0.15)
    assert phase_offset(GRID[:7], turned[:7]) is None
    assert phase_offset(np.concatenate([GRID, GRID]), np.concatenate([turned, turned])) is None
    turned[::3] *= np.exp(-0.3j)
    assert phase_offset(GRID, turned) is None


def test_a_material_is_refused_and_a_trace_has_a_warning(table):
    for name, values in (("bad", noisy(RC * np.exp(-0.06j))), ("good", noisy(RC))):
        path = table("f [Hz],Z' [ohm],Z'' [ohm]", GRID, values.real, values.imag, name=f"{name}.csv")
        said = json.loads(ev.import_file(path).attrs["validity"])
        assert [each["state"] for each in said] == ["warning"] * (name == "bad")
        with pytest.raises(InputError, match="badly calibrated") if name == "bad" else nullcontext():
            assert (
                ev.import_material(path, ev.SpectrumRecipe(area="1 cm2", thickness="1 mm")).material
                is not None
            )
