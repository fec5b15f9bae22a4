"""A permittivity without a measured loss is fitted where it is said what the loss is: none, or unknown."""

import math
import re

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.physics.material import ColeCole, Constant

GRID = np.geomspace(10, 1e6, 41)
SKIN = ColeCole(
    permittivity_high=50.0,
    terms=[{"strength": 1500.0, "relaxation_time": 2e-5, "broadening": 0.3}],
    conductivity=1e-4,
)
TRUE = {
    "permittivity_high": 50.0,
    "terms.0.strength": 1500.0,
    "terms.0.relaxation_time": 2e-5,
    "terms.0.broadening": 0.3,
}


def written(path, material, *, noise=0.01, seed=1, zeros=False):
    """A table of permittivity alone, with relative noise; or with a loss factor of 0 in each row."""
    rng = np.random.default_rng(seed)
    real = material.complex_permittivity(GRID).real * (1 + noise * rng.normal(size=GRID.size))
    end = ",0" if zeros else ""
    rows = [f"{f!r},{a!r}{end}" for f, a in zip(GRID.tolist(), real.tolist(), strict=True)]
    path.write_text("\n".join([f"f [Hz],permittivity{',loss factor' if zeros else ''}", *rows]))
    return path


def loss_of(found):
    (told,) = [each for each in found.diagnostics if each.name == "loss"]
    assert told.state == "unknown"
    return told.text


@pytest.mark.slow
@pytest.mark.parametrize("noise", [None, 0.01])
def test_a_dispersion_is_recovered_from_the_real_part_within_its_intervals(tmp_path, noise):
    inside = np.zeros(len(TRUE))
    for seed in range(20):
        file = written(tmp_path / "eps.csv", SKIN, seed=seed)
        found = ev.fit_material(file, loss="unknown", form="cole-cole-1", noise=noise and {"eps.csv": noise})
        by = {each.name: each for each in found.parameters}
        inside += [by[path].lower <= value <= by[path].upper for path, value in TRUE.items()]
        assert by["conductivity"].value == 0.0
        assert "not measured" in by["conductivity"].note
    assert (inside >= 16).all()  # binomial of 0.95 and 20: fewer in 3e-4 of all cases
    assert inside.sum() >= 70


def test_the_loss_that_follows_is_that_of_the_dispersion_without_conduction(tmp_path):
    """The true loss factor, computed from the twin, lies in the stated interval; conduction alone is missing from it."""
    found = ev.fit_material(written(tmp_path / "eps.csv", SKIN), loss="unknown")
    text = loss_of(found)
    assert "not measured" in text
    assert "lower bound" in text
    told = [
        [float(each) for each in row]
        for row in re.findall(r"([\d.e+-]+) \(([\d.e+-]+) to ([\d.e+-]+)\)", text)
    ]
    bound = -SKIN.conducting(0.0).complex_permittivity(np.array([10, math.sqrt(10 * 1e6), 1e6])).imag
    assert len(told) == 3
    for (value, lower, upper), true in zip(told, bound, strict=True):
        assert lower <= value <= upper
        assert lower <= true <= upper
    assert told[1][2] < 1.1 * told[1][1]  # known in the middle of the band
    assert told[0][2] > 1.1 * told[0][1]  # and less well at its ends
    assert "without a measured loss" in " ".join(each.text for each in found.diagnostics)


@pytest.mark.parametrize("zeros", [False, True])
def test_a_material_without_loss_is_constant(tmp_path, zeros):
    file = written(tmp_path / "film.csv", Constant(permittivity=3.4), zeros=zeros)
    found = ev.fit_material(file, loss="none")
    (level, conductivity) = found.parameters
    assert found.form == "Constant"
    assert found.material.conductivity == 0.0
    assert level.lower < 3.4 < level.upper
    assert level.upper - level.lower == pytest.approx(2 * 1.96 * 3.4 * 0.01 / math.sqrt(41), rel=0.35)
    assert conductivity.note == "0 as stated with the loss"
    assert "stated to be 0" in loss_of(found)
    unknown = ev.fit_material(file, loss="unknown", form="constant").parameters[0]
    assert (unknown.value, unknown.lower) == pytest.approx((level.value, level.lower))


def test_without_a_word_on_the_loss_it_is_refused_and_the_option_named(tmp_path):
    file = written(tmp_path / "eps.csv", SKIN)
    for each in (file, written(tmp_path / "zero.csv", SKIN, zeros=True)):
        with pytest.raises(InputError, match=r"hold no loss.*--loss none, --loss unknown"):
            ev.fit_material(each)
    with pytest.raises(InputError, match="loss = 'unknwon': expected measured, none, unknown"):
        ev.fit_material(file, loss="unknwon")
    shown = CliRunner().invoke(app, ["fit", str(file), "--loss", "unknown", "--form", "cole-cole-1"])
    assert shown.exit_code == 0, shown.output
    assert "to the permittivity alone" in shown.output
    assert "nan" not in shown.output


@pytest.mark.parametrize("loss", ["none", "unknown"])
def test_a_permittivity_without_any_scatter_is_fitted(tmp_path, loss):
    (tmp_path / "eps.csv").write_text(
        "f [Hz],permittivity\n" + "".join(f"{10 * at},3\n" for at in range(1, 31))
    )
    found = ev.fit_material(tmp_path / "eps.csv", loss=loss, form="constant")
    assert found.parameters[0].value == pytest.approx(3, rel=1e-9)


def test_a_dispersion_has_a_loss(tmp_path):
    with pytest.raises(InputError, match=r"Kramers-Kronig.*--loss unknown"):
        ev.fit_material(written(tmp_path / "eps.csv", SKIN), loss="none")
    with pytest.raises(InputError, match="without dispersion"):
        ev.fit_material(written(tmp_path / "eps.csv", SKIN), loss="none", form="cole-cole-1")


@pytest.mark.parametrize("loss", ["none", "unknown"])
def test_a_measured_loss_is_not_disregarded(tmp_path, loss):
    values = SKIN.complex_permittivity(GRID)
    rows = [f"{f!r},{e.real!r},{-e.imag!r}" for f, e in zip(GRID.tolist(), values.tolist(), strict=True)]
    file = tmp_path / "both.csv"
    file.write_text("\n".join(["f [Hz],permittivity,loss factor", *rows]))
    with pytest.raises(InputError, match="the data hold a loss"):
        ev.fit_material(file, loss=loss)


@pytest.mark.parametrize("noise", [None, {"eps.csv": 0.01}])
def test_the_error_of_the_modulus_reaches_the_permittivity(tmp_path, noise):
    """By a closed form: an error of the modulus of 2 % is one of 2 % of every permittivity."""
    found = ev.fit_material(
        written(tmp_path / "eps.csv", SKIN), loss="unknown", form="cole-cole-1", systematic=0.02, noise=noise
    )
    by = {each.name: each for each in found.parameters}
    assert by["terms.0.strength"].systematic == pytest.approx(by["terms.0.strength"].value * 0.0202, rel=0.01)
    assert by["terms.0.broadening"].systematic == pytest.approx(0, abs=1e-6)
