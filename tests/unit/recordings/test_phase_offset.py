"""A constant phase error of an instrument, and the spectra that are not to be taken for one."""

import json

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.importing.phase_offset import phase_offset

GRID = np.geomspace(1e3, 1e5, 40)
TURNS = 2j * np.pi * GRID
RC = 1 / (1 / 5e4 + TURNS * 3e-11)


def noisy(exact, *, noise=3e-3, seed=1):
    rng = np.random.default_rng(seed)
    return exact * (1 + noise * (rng.normal(size=GRID.size) + 1j * rng.normal(size=GRID.size)))


@pytest.mark.parametrize("degrees", [-3.0, 2.0])
@pytest.mark.parametrize("exact", [RC, np.full(40, 2e4 + 0j), 1 / (TURNS * 1e-10)], ids=["RC", "R", "C"])
def test_the_phase_of_a_bad_calibration_is_found(exact, degrees):
    found = phase_offset(GRID, noisy(exact * np.exp(1j * np.radians(degrees))))
    assert np.degrees(found.phase) == pytest.approx(degrees, abs=0.15)
    assert found.misfit == pytest.approx(3e-3 * np.sqrt(2), rel=0.2)
    assert found.inconsistent > 2 * found.misfit


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


def test_a_material_is_refused_and_a_trace_has_a_warning(tmp_path):
    for name, values in (("bad.csv", noisy(RC * np.exp(-0.06j))), ("good.csv", noisy(RC))):
        rows = [f"{f},{z.real},{z.imag}" for f, z in zip(GRID, values, strict=True)]
        (tmp_path / name).write_text("\n".join(["f [Hz],Z' [ohm],Z'' [ohm]", *rows]))
    given = {"area": "1 cm2", "thickness": "1 mm"}
    with pytest.raises(InputError, match="badly calibrated"):
        ev.import_material(tmp_path / "bad.csv", **given)
    assert ev.import_material(tmp_path / "good.csv", **given).material is not None
    for name, count in (("bad.csv", 1), ("good.csv", 0)):
        found = json.loads(ev.import_file(tmp_path / name).attrs["validity"])
        assert [each["state"] for each in found] == ["warning"] * count
