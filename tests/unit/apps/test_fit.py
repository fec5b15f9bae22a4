"""The fit from files to a folder of results, in Python and on the command line."""

import csv
import sys
import tomllib

import numpy as np
import pytest
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
FREQUENCIES = np.geomspace(1, 1e5, 25)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scenario, the same with an insulator twice as thick, and impedance spectra of three gaps with 1 % of noise."""
    place, rng = tmp_path_factory.mktemp("fit"), np.random.default_rng(3)
    plate = ev.load("bau_2010/sine").replace({LEAK: "2e-9 S/m"})
    (place / "plate.toml").write_text(to_toml(plate))
    (place / "thick.toml").write_text(to_toml(plate.replace({"stack.insulator.thickness": "2 um"})))
    for name, gap in (("a", 3e-6), ("b", 3.3e-6), ("c", 3.6e-6)):
        grid = {"frequency.low": 1.0, "frequency.high": 1e5, "frequency.samples": 25}
        exact = ev.simulate(plate.replace({GAP: gap, **grid}))
        clean = exact["impedance"].values
        noise = 0.01 * np.abs(clean) * (rng.normal(size=clean.size) + 1j * rng.normal(size=clean.size))
        ev.save(
            make_trace(
                {"impedance": (("frequency",), clean + noise)}, {"frequency": exact["frequency"].values}, {}
            ),
            place / f"{name}.nc",
        )
    return place


def test_the_folder_holds_what_can_be_used_again(folder, tmp_path):
    out = tmp_path / "out"
    found = ev.fit(
        folder / "plate.toml",
        folder / "a.nc",
        free=[GAP, LEAK],
        output=out,
        compare_with=[folder / "thick.toml"],
    )
    assert sorted(path.name for path in out.iterdir()) == [
        "parameters.csv", "parameters.toml", "report.html", "space.toml",
    ]  # fmt: skip
    assert ev.load(out / "parameters.toml").stack.layers["gap"].thickness == found.best.estimate.values[GAP]
    lines = uncommented(out / "parameters.csv")
    rows = {row["name"]: row for row in csv.DictReader(lines)}
    assert float(rows[GAP]["value"]) == found.best.estimate.values[GAP]
    assert float(rows[GAP]["lower"]) < 3e-6 < float(rows[GAP]["upper"])
    assert rows[GAP]["unit"] == "m"
    space = read_space(found.scenario, out / "space.toml")
    assert space.distributions[GAP].mean == found.best.estimate.values[GAP]
    assert space.distributions[GAP].deviation == found.best.estimate.standard_deviations[GAP]
    correlation = tomllib.loads((out / "space.toml").read_text())["correlation"]
    assert correlation == {f"{GAP} ~ {LEAK}": found.best.correlation[0][1]}
    assert space.correlations == {(GAP, LEAK): found.best.correlation[0][1]}
    covariance = found.best.estimate.covariance
    assert correlation[f"{GAP} ~ {LEAK}"] == pytest.approx(
        covariance[0, 1] / np.sqrt(covariance[0, 0] * covariance[1, 1])
    )
    page = (out / "report.html").read_text()
    assert page.count("<figure>") == 3  # modulus, phase, residuals
    for words in (
        "Correlation of the estimates",
        "95 % interval",
        "Residuals",
        "Burnham",
        "leaves it no support",
    ):
        assert words in page
    assert "src=" not in page
    assert found.comparison.names[0] == "plate.toml"


def test_the_best_model_comes_first_even_if_it_was_not_asked_for(folder):
    found = ev.fit(
        folder / "thick.toml", folder / "a.nc", free=[GAP, LEAK], compare_with=[folder / "plate.toml"]
    )
    assert found.comparison.names == ("plate.toml", "thick.toml")
    assert found.comparison.aicc[0] == 0
    assert found.comparison.aicc[1] > 10
    assert found.scenario.stack.layers["insulator"].thickness == 2e-6


def test_files_of_the_same_name_are_numbered(folder, tmp_path):
    other = tmp_path / "a.nc"
    other.write_bytes((folder / "b.nc").read_bytes())
    found = ev.fit(folder / "plate.toml", [folder / "a.nc", other], free=[GAP], varying=[GAP])
    assert [row.name for row in found.rows[:2]] == [f"{GAP} [a.nc (1)]", f"{GAP} [a.nc (2)]"]


def test_sessions_appear_in_table_and_space(folder, tmp_path):
    files = [folder / f"{name}.nc" for name in "abc"]
    found = ev.fit(folder / "plate.toml", files, free=[GAP, LEAK], varying=[GAP], output=tmp_path / "out")
    row = found.rows[-1]
    assert row.name == f"{GAP} (mean of 3 sessions)"
    assert row.value == pytest.approx(3.3e-6, rel=0.01)
    assert "between sessions" in row.note
    space = tomllib.loads((tmp_path / "out" / "space.toml").read_text())["space"]
    assert set(space) == {GAP, LEAK}
    text = (tmp_path / "out" / "space.toml").read_text()
    assert f"# {GAP} varies between sessions: no correlation" in text
    assert "correlation" not in tomllib.loads(text)
    # between sessions 0.3 um, and 0.3 um / sqrt(3) of the mean
    assert space[GAP]["deviation"] == pytest.approx(0.3e-6 * np.sqrt(4 / 3), rel=0.05)


def test_what_is_not_determined_says_why_and_is_not_in_the_space(folder, tmp_path):
    film, permittivity = "stack.insulator.thickness", "stack.insulator.material.permittivity"
    found = ev.fit(folder / "plate.toml", folder / "a.nc", free=[film, permittivity], output=tmp_path / "out")
    assert {row.state for row in found.rows} == {"not"}
    assert all("they determine" in row.note for row in found.rows)
    page = (tmp_path / "out" / "report.html").read_text()
    assert "not determined" in page
    text = (tmp_path / "out" / "space.toml").read_text()
    assert film not in tomllib.loads(text).get("space", {})
    assert "correlation" not in tomllib.loads(text)
    assert f"# {film} is omitted: the data do not determine" in text


def test_cancelled_nothing_is_written(folder, tmp_path):
    with pytest.raises(CancelledError):
        ev.fit(
            folder / "plate.toml",
            folder / "a.nc",
            free=[GAP],
            output=tmp_path / "out",
            progress=lambda count, _: count > 1,
        )
    assert not (tmp_path / "out").exists()


def test_a_file_of_somebody_else_is_not_replaced(folder, tmp_path):
    (tmp_path / "parameters.csv").write_text("mine")
    with pytest.raises(InputError, match=r"parameters\.csv: exists already"):
        ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], output=tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["parameters.csv"]
    ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], output=tmp_path, force=True)
    ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], output=tmp_path)  # our own is


def test_mistakes_are_reported_together(folder, tmp_path):
    (tmp_path / "out").write_text("a file")
    with pytest.raises(InputError) as caught:
        ev.fit(
            "bau_2010/sin", folder / "none.nc", free=[GAP], output=tmp_path / "out", compare_with=["nothing"]
        )
    told = " ".join(caught.value.problems)
    for words in ("bau_2010/sine", "none.nc", "nothing", "is a file"):
        assert words in told
    with pytest.raises(InputError, match="none of the recordings"):
        ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], sessions={"b.nc": "x"})
    with pytest.raises(InputError, match="no recording has this signal"):
        ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], noise={"mean_force": 1.0})
    with pytest.raises(InputError, match="none of the free parameters"):
        ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP], compare_with=["vezzoli_2014/fig6"])


def test_without_lmfit_the_line_that_installs_it_is_given(folder, monkeypatch):
    monkeypatch.setitem(sys.modules, "lmfit", None)
    with pytest.raises(InputError, match=r"pip install 'electrovib\[fit\]'"):
        ev.fit(folder / "plate.toml", folder / "a.nc", free=[GAP])


def test_the_command_prints_estimates_and_writes_the_folder(folder, tmp_path):
    arguments = [
        "fit", str(folder / "plate.toml"), str(folder / "a.nc"), str(folder / "b.nc"),
        "--free", f"{GAP},{LEAK}", "--vary", GAP, "--session", f"{folder / 'a.nc'}=monday",
        "--noise", "impedance=0.01", "-o", str(tmp_path / "out"),
    ]  # fmt: skip
    result = CliRunner().invoke(app, arguments)
    assert result.exit_code == 0, result.output
    assert f"{GAP} [monday]: " in result.output
    assert "95 % interval" in result.output
    assert "scatter within a session" in result.output
    assert (tmp_path / "out" / "report.html").exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--noise", "impedance"], "expected SIGNAL=VALUE"),
        (["--noise", "impedanc=1"], "impedance"),
        (["--noise", "electrostatic_force=3 V"], "--noise electrostatic_force=3 V"),
        (["--session", "a.nc"], "expected FILE=NAME"),
    ],
)
def test_mistakes_of_the_command_name_the_option(folder, options, words):
    arguments = ["fit", str(folder / "plate.toml"), str(folder / "a.nc"), "--free", GAP, *options]
    result = CliRunner().invoke(app, arguments)
    assert isinstance(result.exception, InputError)
    assert words in " ".join(result.exception.problems)
