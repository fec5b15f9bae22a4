"""Recordings fitted one by one, and power laws of tables: a row for each, and the scatter between them."""

import tomllib
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import t

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.recordings.fit.problem import CancelledError
from electrovib.scenario.space import read_space

pytestmark = pytest.mark.usefixtures("blank_pictures")

GAP, LEAK = "stack.gap.thickness", "stack.gap.material.conductivity"
GAPS = (3e-6, 3.3e-6, 3.6e-6)
FILES = ["parameters.csv", "report.html", "space.toml"]
NOISE = {"impedance": 0.01}


@pytest.fixture(scope="module")
def separate(spectra, tmp_path_factory):
    """The fits of all four files, of which one is no Trace, and their folder."""
    out = tmp_path_factory.mktemp("out") / "fits"
    files = [spectra / f"{name}.nc" for name in ("a", "broken", "b", "c")]
    known = ev.Recordings(traces=files, noise=NOISE)
    return ev.fit_separately(spectra / "plate.toml", known, free=[GAP, LEAK], output=out), out


def test_each_recording_has_the_estimates_of_its_own_fit(spectra, separate):
    found, _ = separate
    for each, gap in zip([found.fits[0], *found.fits[2:]], GAPS, strict=True):
        row = each.rows[0]
        assert row.lower < gap < row.upper
        known = ev.Recordings(traces=spectra / each.record, noise=NOISE)
        alone = ev.fit(spectra / "plate.toml", known, free=[GAP, LEAK])
        assert row == alone.rows[0]
        assert each.reduced_chi_square == alone.best.estimate.sum_of_squares / (50 - 2)
        assert 0.5 < each.reduced_chi_square < 1.6


def test_table_and_page_have_a_place_for_each_recording_and_parameter(separate, table):
    found, out = separate
    assert sorted(path.name for path in out.iterdir() if path.suffix != ".pdf") == FILES
    rows = table(out / "parameters.csv")
    records = ["a.nc", "broken.nc", "b.nc", "c.nc", "mean of 3 recordings"]
    assert [row["record"] for row in rows] == [each for each in records for _ in range(2)]
    assert [row["parameter"] for row in rows[:2]] == [GAP, LEAK]
    first = rows[0]
    assert float(first["value"]) == found.fits[0].rows[0].value
    assert float(first["reduced_chi_square"]) == found.fits[0].reduced_chi_square
    assert (first["unit"], first["status"], first["method"]) == ("m", "well", "symmetric")
    failed = [row for row in rows if row["status"] == "failed"]
    assert [row["value"] for row in failed] == ["nan", "nan"]
    assert "broken.nc" in failed[0]["note"]
    page = (out / "report.html").read_text()
    assert page.count("<figure>") == 2
    for words in ("3 of 4 recordings were fitted", "broken.nc", "failed", "Means over the recordings", "2: "):
        assert words in page


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
    assert space.distributions[GAP].distribution.deviation == pytest.approx(
        np.hypot(row.standard_error, spread.between)
    )


@pytest.mark.parametrize("last", [0, 1])
def test_cancelled_nothing_is_written(spectra, here, last):
    seen = []

    def cancel(done, total):
        seen.append((done, total))
        return done >= last and len(seen) > 3

    files = [spectra / "a.nc", spectra / "b.nc"]
    with pytest.raises(CancelledError):
        ev.fit_separately(spectra / "plate.toml", files, free=[GAP], output="out", progress=cancel)
    assert seen[-1] == (last, 2)
    assert not list(here.iterdir())


def test_mistakes_that_concern_all_recordings_are_reported_together(spectra, here):
    plate = spectra / "plate.toml"
    (here / "parameters.csv").write_text("mine")
    with pytest.raises(InputError) as caught:
        ev.fit_separately(plate, spectra / "a.nc", free=["stack.gap.thicknes"], output=here)
    for words in ("stack.gap.thickness", "parameters.csv: exists already"):
        assert words in " ".join(caught.value.problems)
    for files, words in ((spectra / "broken.nc", r"broken\.nc"), ([], "at least one recording")):
        with pytest.raises(InputError, match=words):
            ev.fit_separately(plate, files, free=[GAP], output="out")
    assert not (here / "out").exists()
    found = ev.fit_separately(plate, spectra / "a.nc", free=[GAP])
    assert np.isnan(found.fits[0].reduced_chi_square)  # without a stated noise
    assert not found.spreads


def test_the_command_prints_each_recording_and_the_means_and_the_error_by_calibration(
    spectra, here, said, refused, table
):
    files = [spectra / f"{name}.nc" for name in ("plate", "a", "broken", "b")]
    asked = [files[0].with_suffix(".toml"), *files[1:], "--free", GAP, "--all", "-o", "out"]
    out = said("fit-separately --gain-error 'impedance=2 %' --zero-error 'impedance=1 ohm'", *asked)
    for words in ("a.nc  ", "broken.nc: failed", f"{GAP}, mean of 2 recordings: ", "within a recording"):
        assert words in out
    assert out.count(", by calibration ") == 1  # of the mean; the table has that of each recording
    assert sorted(path.name for path in (here / "out").iterdir() if path.suffix != ".pdf") == FILES
    found = [float(row["systematic"]) for row in table(here / "out" / "parameters.csv")]
    systematic = [each for each in found if np.isfinite(each)]
    # the gap alone changes the impedance by less than proportionally: the insulator and the leak are known
    assert all(0.02 * gap < each < 0.2 * gap for each, gap in zip(systematic, GAPS[:2], strict=False))
    assert systematic[2] == pytest.approx(np.mean(systematic[:2]), rel=1e-12)
    assert "95 % by calibration" in (here / "out" / "report.html").read_text()
    assert "Did you mean 'impedance'" in refused("fit-separately --gain-error 'impedanc=1 %'", *asked)


VOLTS = np.geomspace(20, 200, 8)
COLUMNS = "--x voltage --y force"


def points(name, exponents, *, unit="mN"):
    """Write points of several sessions with 2 % of noise, forces in mN."""
    rng, rows = np.random.default_rng(1), [f"voltage (V),force ({unit}),day"]
    for day, exponent in enumerate(exponents, start=1):
        force = 1e-3 * VOLTS**exponent * np.exp(0.02 * rng.normal(size=8))
        rows += [f"{v!r},{f!r},{day}" for v, f in zip(VOLTS.tolist(), force.tolist(), strict=True)]
    Path(name).write_text("\n".join(rows))


def test_sessions_of_a_column_are_those_of_the_function(here, said, table):
    points("all.csv", (1.8, 2.0, 2.2))
    asked = f"fit-power-law all.csv {COLUMNS} --session-column day -o law.csv"
    out = said(asked)
    read = np.loadtxt("all.csv", delimiter=",", skiprows=1)
    law = ev.fit_power_law(read[:, 0], 1e-3 * read[:, 1], session=[f"{each:g}" for each in read[:, 2]])
    assert f"exponent {law.exponent:.4g}, 95 % interval {law.lower:.4g} to {law.upper:.4g}" in out
    assert "with 2 degrees of freedom" in out
    assert "too narrow" in out
    rows = table(here / "law.csv")
    assert [row["session"] for row in rows] == ["1", "2", "3", "mean of the sessions"]
    assert float(rows[1]["exponent"]) == law.sessions["2"].exponent
    assert float(rows[1]["factor"]) == law.sessions["2"].factor
    assert float(rows[-1]["between"]) == law.between.between.value
    assert float(rows[-1]["between_upper"]) == law.between.between.upper
    said(asked)  # our own file is replaced


def test_each_file_is_a_session_and_units_are_converted(here, said, refused):
    points("a.csv", [1.9])
    points("b.csv", [2.1], unit="N")
    lines = said(f"fit-power-law a.csv b.csv {COLUMNS}").splitlines()
    rows = [line.split() for line in lines if line.startswith(("a.csv", "b.csv"))]
    a, b = (float(row[-1]) for row in rows)
    assert [row[0] for row in rows] == ["a.csv", "b.csv"]
    assert a == pytest.approx(1e-6, rel=0.2)  # 1e-3 mN
    assert b == pytest.approx(1e-3, rel=0.2)
    assert any("1 degree of freedom" in line for line in lines)
    for wrong, words in (
        ("--x volts --y force", "the file has no such column"),
        (f"{COLUMNS} --session-column dya", "Did you mean 'day'"),
        (f"{COLUMNS} -o law.gif", "written as .html, .pdf"),
    ):
        assert words in refused(f"fit-power-law a.csv {wrong}")
