"""The power law of tables, on the command line."""

import csv

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app

VOLTS = np.geomspace(20, 200, 8)
COLUMNS = ["--column", "x=voltage", "--column", "y=force"]


def table(path, exponents, *, seed=1, unit="mN"):
    """Points of several sessions with 2 % of noise, forces in mN."""
    rng = np.random.default_rng(seed)
    rows = [f"voltage (V),force ({unit}),day"]
    for day, exponent in enumerate(exponents, start=1):
        force = 1e-3 * VOLTS**exponent * np.exp(0.02 * rng.normal(size=8))
        rows += [f"{v!r},{f!r},{day}" for v, f in zip(VOLTS.tolist(), force.tolist(), strict=True)]
    path.write_text("\n".join(rows))
    return str(path)


def ran(*arguments):
    return CliRunner().invoke(app, ["fit", *arguments])


def test_sessions_of_a_column_are_those_of_the_function(tmp_path):
    file, out = table(tmp_path / "all.csv", (1.8, 2.0, 2.2)), tmp_path / "law.csv"
    result = ran(file, *COLUMNS, "--column", "session=day", "-o", str(out))
    assert result.exit_code == 0, result.output
    points = np.loadtxt(file, delimiter=",", skiprows=1)
    law = ev.fit_power_law(points[:, 0], 1e-3 * points[:, 1], session=[f"{each:g}" for each in points[:, 2]])
    assert f"exponent {law.exponent:.4g}, 95 % interval {law.lower:.4g} to {law.upper:.4g}" in result.output
    assert "with 2 degrees of freedom" in result.output
    assert "too narrow" in result.output
    rows = list(csv.DictReader(line for line in out.read_text().splitlines() if not line.startswith("#")))
    assert [row["session"] for row in rows] == ["1", "2", "3", "mean of the sessions"]
    assert float(rows[1]["exponent"]) == law.sessions["2"].exponent
    assert float(rows[1]["factor"]) == law.sessions["2"].factor
    assert float(rows[-1]["between"]) == law.between.between
    assert float(rows[-1]["between_upper"]) == law.between.between_upper
    assert ran(file, *COLUMNS, "-o", str(out)).exit_code == 0  # our own file is replaced


def test_each_file_is_a_session_and_units_are_converted(tmp_path):
    files = [table(tmp_path / "a.csv", [1.9]), table(tmp_path / "b.csv", [2.1], unit="N")]
    result = ran(*files, *COLUMNS)
    assert result.exit_code == 0, result.output
    lines = result.output.splitlines()
    a, b = (float(line.rpartition(" ")[2]) for line in lines[1:3])
    assert [line.split(":")[0].strip() for line in lines[1:3]] == ["a.csv", "b.csv"]
    assert a == pytest.approx(1e-6, rel=0.2)  # 1e-3 mN
    assert b == pytest.approx(1e-3, rel=0.2)
    assert "1 degree of freedom" in result.output


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["--column", "x=volts", "--column", "y=force"], "the file has no such column"),
        ([*COLUMNS, "--column", "session=dya"], "Did you mean 'day'"),
        ([*COLUMNS, "-o", "law.txt"], "written as .csv"),
    ],
)
def test_mistakes_name_the_option(tmp_path, arguments, words):
    result = ran(table(tmp_path / "a.csv", [2.0]), *arguments)
    assert words in " ".join(result.exception.problems)
