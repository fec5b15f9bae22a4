"""The posterior distribution of a fit, from the command to the chains in the folder."""

import json
import sys

import h5netcdf
import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.recordings.fit import CancelledError
from electrovib.scenario.toml import to_toml

GAP = "stack.gap.thickness"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scenario and its impedance at six frequencies, with 0.1 % of noise."""
    place, rng = tmp_path_factory.mktemp("posterior"), np.random.default_rng(3)
    plate = ev.load("bau_2010/sine").replace(
        {"frequency.low": 1e2, "frequency.high": 1e5, "frequency.samples": 6}
    )
    (place / "plate.toml").write_text(to_toml(plate))
    exact = ev.simulate(plate)
    noise = 1e-3 * rng.normal(size=6) + 1e-3j * rng.normal(size=6)
    values = {"impedance": (("frequency",), exact["impedance"].values * (1 + noise))}
    ev.save(make_trace(values, {"frequency": exact["frequency"].values}, {}), place / "a.nc")
    return place


@pytest.fixture(scope="module")
def fitted(folder, tmp_path_factory):
    out = tmp_path_factory.mktemp("out") / "fit"
    sampling = ev.Sampling(seed=1, steps=40)
    return ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], posterior=sampling, output=out), out


def test_the_file_holds_the_chains_with_their_diagnostics(fitted):
    found, out = fitted
    with h5netcdf.File(out / "posterior.nc", "r") as file:
        values = file["value"][...]
        assert values.shape == (1, 40, 4)
        assert file["parameter"][0] in {GAP, GAP.encode()}
        assert file["unit"][0] in {"m", b"m"}
        np.testing.assert_array_equal(values[0], found.posterior.chains[GAP])
        assert file["log_density"].shape == (40, 4)
        assert (file.attrs["burn_in"], file.attrs["seed"]) == (20, 1)
        assert json.loads(file.attrs["problems"]) == list(found.posterior.problems)
    assert len(found.posterior.problems) == 1  # 40 steps are too few


def test_samples_are_the_chains_after_the_burn_in(fitted):
    found, _ = fitted
    posterior = found.posterior
    assert set(posterior.samples[GAP]) <= set(posterior.chains[GAP][20:].ravel())
    best = np.unravel_index(np.argmax(posterior.log_density), posterior.log_density.shape)
    deviation = found.best.estimate.standard_deviations[GAP]
    assert posterior.chains[GAP][best] == pytest.approx(found.best.estimate.values[GAP], abs=0.3 * deviation)


def test_the_page_states_that_the_chains_are_too_short(fitted):
    _, out = fitted
    page = (out / "report.html").read_text()
    for words in ("Posterior distribution", "4 chains of 40 steps", "may not represent", "MCMC Hammer"):
        assert words in page


def test_the_command_repeats_the_samples_and_replaces_its_own_files(folder, fitted):
    found, out = fitted
    arguments = ["fit", str(folder / "plate.toml"), str(folder / "a.nc"), "--free", GAP, "--posterior"]
    result = CliRunner().invoke(app, [*arguments, "--seed", "1", "-n", "40", "-o", str(out)])
    assert result.exit_code == 0, result.output
    assert f"{GAP}: posterior 95 % interval " in result.output
    assert "warning: the samples may not represent the posterior" in result.output
    with h5netcdf.File(out / "posterior.nc", "r") as file:
        np.testing.assert_array_equal(file["value"][0], found.posterior.chains[GAP])
    refused = CliRunner().invoke(app, arguments)
    assert "--posterior: state --seed" in " ".join(refused.exception.problems)
    refused = CliRunner().invoke(app, [*arguments, "--seed", "1", "--separately"])
    assert "--posterior: does not belong to --separately, but to a joint fit" in " ".join(
        refused.exception.problems
    )


def test_cancelled_nothing_is_written(folder, tmp_path, monkeypatch):
    given = {"free": [GAP], "output": tmp_path / "out"}
    sampling = ev.Sampling(seed=1, steps=40, progress=lambda done, total: (done, total) == (3, 40))
    with pytest.raises(CancelledError):
        ev.fit(folder / "plate.toml", folder / "a.nc", posterior=sampling, **given)
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="seed = -1"):
        ev.Sampling(seed=-1)
    monkeypatch.setitem(sys.modules, "emcee", None)
    with pytest.raises(InputError, match="emcee"):
        ev.fit(folder / "plate.toml", folder / "a.nc", posterior=ev.Sampling(seed=1), **given)


def test_a_file_of_somebody_else_is_not_replaced(folder, tmp_path):
    (tmp_path / "posterior.nc").write_text("mine")
    with pytest.raises(InputError, match=r"posterior\.nc: exists already"):
        ev.fit(
            folder / "plate.toml", folder / "a.nc", free=[GAP], posterior=ev.Sampling(seed=1), output=tmp_path
        )
