"""Recordings fitted one by one: one table, one figure, failures in the table, nothing half-written."""

import csv
import tomllib

import numpy as np
import pytest
from scipy.stats import t
from tests.unit.apps.written import uncommented
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.core.trace import make_trace
from electrovib.recordings.fit import CancelledError
from electrovib.scenario.space import read_space
from electrovib.scenario.toml import to_toml

GAP, LEAK = "stack.gap.thickness", "stack.gap.material.conductivity"
GAPS = {"a": 3e-6, "b": 3.3e-6, "c": 3.6e-6}
FILES = ["parameters.csv", "report.html", "space.toml"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scenario and impedance spectra of three gaps with 1 % of noise, and one file that is no Trace."""
    place, rng = tmp_path_factory.mktemp("separate"), np.random.default_rng(3)
    plate = ev.load("bau_2010/sine").replace({LEAK: "2e-9 S/m"})
    (place / "plate.toml").write_text(to_toml(plate))
    grid = {"frequency.low": 1.0, "frequency.high": 1e5, "frequency.samples": 25}
    for name, gap in GAPS.items():
        exact = ev.simulate(plate.replace({GAP: gap, **grid}))
        clean = exact["impedance"].values
        noise = 0.01 * np.abs(clean) * (rng.normal(size=clean.size) + 1j * rng.normal(size=clean.size))
        ev.save(
            make_trace(
                {"impedance": (("frequency",), clean + noise)}, {"frequency": exact["frequency"].values}, {}
            ),
            place / f"{name}.nc",
        )
    (place / "broken.nc").write_text("no Trace")
    return place


@pytest.fixture(scope="module")
def separate(folder, tmp_path_factory):
    """The fits of all four files, and their folder."""
    out = tmp_path_factory.mktemp("out") / "fits"
    files = [folder / f"{name}.nc" for name in ("a", "broken", "b", "c")]
    found = ev.fit_separately(
        folder / "plate.toml", files, free=[GAP, LEAK], noise={"impedance": 0.01}, output=out
    )
    return found, out


def test_each_recording_has_the_estimates_of_its_own_fit(folder, separate):
    found, _ = separate
    for each, gap in zip([found.fits[0], *found.fits[2:]], GAPS.values(), strict=True):
        row = each.rows[0]
        assert row.lower < gap < row.upper
        alone = ev.fit(
            folder / "plate.toml", folder / each.record, free=[GAP, LEAK], noise={"impedance": 0.01}
        )
        assert row == alone.rows[0]
        assert each.reduced_chi_square == alone.best.estimate.sum_of_squares / (50 - 2)
        assert 0.5 < each.reduced_chi_square < 1.6


def test_the_table_has_a_row_for_each_recording_and_parameter(separate):
    found, out = separate
    assert sorted(path.name for path in out.iterdir()) == FILES
    rows = list(csv.DictReader(uncommented(out / "parameters.csv")))
    named = [(row["record"], row["parameter"]) for row in rows]
    records = ["a.nc", "broken.nc", "b.nc", "c.nc", "mean of 3 recordings"]
    assert [name for name, _ in named] == [each for each in records for _ in range(2)]
    first = rows[0]
    assert float(first["value"]) == found.fits[0].rows[0].value
    assert float(first["reduced_chi_square"]) == found.fits[0].reduced_chi_square
    assert (first["unit"], first["status"], first["method"]) == ("m", "well", "symmetric")
    failed = [row for row in rows if row["status"] == "failed"]
    assert len(failed) == 2
    assert "broken.nc" in failed[0]["note"]
    assert failed[0]["value"] == "nan"


def test_the_mean_has_the_scatter_within_and_between_recordings(separate):
    found, out = separate
    values = np.array([found.fits[at].rows[0].value for at in (0, 2, 3)])
    deviations = np.array([found.fits[at].rows[0].standard_error for at in (0, 2, 3)])
    spread, row = found.spreads[GAP], found.means[0]
    assert row.value == pytest.approx(values.mean(), rel=1e-12)
    assert spread.within == pytest.approx(np.sqrt(np.mean(deviations**2)), rel=1e-12)
    assert spread.between == pytest.approx(np.sqrt(values.var(ddof=1) - spread.within**2), rel=1e-12)
    half = t.ppf(0.975, 2) * values.std(ddof=1) / np.sqrt(3)
    assert row.upper - row.value == pytest.approx(half, rel=1e-9)
    assert "between recordings" in row.note
    space = read_space(found.scenario, tomllib.loads((out / "space.toml").read_text())["space"])
    assert space.distributions[GAP].deviation == pytest.approx(np.hypot(row.standard_error, spread.between))


def test_the_page_has_one_figure_of_each_parameter(separate):
    _, out = separate
    page = (out / "report.html").read_text()
    assert page.count("<figure>") == 2
    for words in ("3 of 4 recordings were fitted", "broken.nc", "failed", "Means over the recordings", "2: "):
        assert words in page


def test_without_a_stated_noise_there_is_no_chi_square(folder):
    found = ev.fit_separately(folder / "plate.toml", folder / "a.nc", free=[GAP])
    assert np.isnan(found.fits[0].reduced_chi_square)
    assert not found.spreads


@pytest.mark.parametrize("last", [0, 1])
def test_cancelled_nothing_is_written(folder, tmp_path, last):
    seen = []

    def cancel(done, total):
        seen.append((done, total))
        return done >= last and len(seen) > 3

    with pytest.raises(CancelledError):
        ev.fit_separately(
            folder / "plate.toml", [folder / "a.nc", folder / "b.nc"], free=[GAP], output=tmp_path / "out", progress=cancel
        )  # fmt: skip
    assert seen[-1] == (last, 2)
    assert not (tmp_path / "out").exists()


def test_mistakes_that_concern_all_recordings_are_reported_together(folder, tmp_path):
    (tmp_path / "parameters.csv").write_text("mine")
    with pytest.raises(InputError) as caught:
        ev.fit_separately(
            folder / "plate.toml", folder / "a.nc", free=["stack.gap.thicknes"], output=tmp_path
        )
    words = " ".join(caught.value.problems)
    assert "stack.gap.thickness" in words
    assert "parameters.csv: exists already" in words
    with pytest.raises(InputError, match=r"broken\.nc"):
        ev.fit_separately(folder / "plate.toml", folder / "broken.nc", free=[GAP], output=tmp_path / "out")
    assert not (tmp_path / "out").exists()
    with pytest.raises(InputError, match="at least one recording"):
        ev.fit_separately(folder / "plate.toml", [], free=[GAP])


def test_a_gain_error_is_stated_beside_the_interval(folder, tmp_path):
    files = [str(folder / f"{name}.nc") for name in ("a", "b")]
    out = tmp_path / "out"
    arguments = ["fit", str(folder / "plate.toml"), *files, "--free", GAP, "--separately", "-o", str(out)]
    result = CliRunner().invoke(
        app, [*arguments, "--all", "--gain-error", "impedance=2 %", "--zero-error", "impedance=1 ohm"]
    )
    assert result.exit_code == 0, result.output
    assert result.output.count(", by calibration ") == 3
    rows = list(csv.DictReader(uncommented(out / "parameters.csv")))
    systematic = [float(row["systematic"]) for row in rows]
    # the gap alone changes the impedance by less than proportionally: the insulator and the leak are known
    assert all(0.02 * gap < each < 0.2 * gap for each, gap in zip(systematic, (3e-6, 3.3e-6), strict=False))
    assert systematic[2] == pytest.approx(np.mean(systematic[:2]), rel=1e-12)
    assert "95 % by calibration" in (out / "report.html").read_text()
    for option, value, words in (
        ("--gain-error", "impedance=x", "expected a share"),
        ("--gain-error", "impedanc=1 %", "Did you mean 'impedance'"),
        ("--zero-error", "impedance=1 V", "--zero-error impedance=1 V"),
    ):
        refused = CliRunner().invoke(app, [*arguments, option, value])
        assert words in " ".join(refused.exception.problems)


def test_the_command_prints_each_recording_and_the_means(folder, tmp_path):
    files = [str(folder / f"{name}.nc") for name in ("a", "broken", "b")]
    arguments = ["fit", str(folder / "plate.toml"), *files, "--free", GAP, "--separately"]
    result = CliRunner().invoke(app, [*arguments, "--all", "-o", str(tmp_path / "out")])
    assert result.exit_code == 0, result.output
    for words in ("a.nc:", "broken.nc: failed", f"{GAP}, mean of 2 recordings: ", "within a recording"):
        assert words in result.output
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == FILES
    refused = CliRunner().invoke(app, [*arguments, "--vary", GAP])
    assert "--vary: does not belong to --separately, but to a joint fit" in " ".join(
        refused.exception.problems
    )
