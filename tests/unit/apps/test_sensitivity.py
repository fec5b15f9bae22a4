"""The command ``electrovib study --sensitivity`` and its folder."""

from __future__ import annotations

import csv

import pytest
from tests.unit.apps.written import uncommented
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.errors import InputError
from electrovib.data.marks import Form

SCENARIO, QUANTITY = "vezzoli_2014/fig6_gap", "peak electrostatic_force"
ASKED = [SCENARIO, "--space", "fingers", "--quantity", QUANTITY, "-n", "4", "--seed", "1"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    out = tmp_path_factory.mktemp("sensitivity") / "out"
    shown = CliRunner().invoke(app, ["study", "--sensitivity", *ASKED, "-o", str(out)])
    assert shown.exit_code == 0, shown.output
    return out, shown.stdout


def test_the_command_prints_the_answer_first_and_what_is_unverified(folder):
    out, printed = folder
    assert printed.startswith("Measure ")
    assert "stack.gap.thickness: the distribution is unverified, cited from memory" in " ".join(
        printed.split()
    )
    assert f"written: {out}" in printed


def test_the_folder_holds_what_the_function_returns(folder):
    out, _ = folder
    found = ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1)
    rows = list(csv.DictReader(uncommented(out / "indices.csv")))
    assert [(row["input"], float(row["total"])) for row in rows] == [(e.name, e.total) for e in found.indices]
    rows = list(csv.DictReader(uncommented(out / "elasticities.csv")))
    assert {row["parameter"]: float(row["elasticity"]) for row in rows} == {
        each.path: each.value for each in found.elasticities
    }
    assert ev.read_space(SCENARIO, out / "space.toml").distributions == found.space.distributions
    page = (out / "report.html").read_text()
    assert "<svg" in page
    assert "unverified, cited from memory" in page
    assert str(Form.PAGE) in page


def test_the_figure_shows_both_indices_of_every_input_with_their_intervals():
    found = ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1)
    axes = ev.plot.indices(found)
    assert [label.get_text() for label in axes.get_yticklabels()] == [each.name for each in found.indices]
    widths = [bar.get_width() for bar in axes.patches]
    assert widths == [each.total for each in found.indices] + [each.first for each in found.indices]
    ends = [tuple(line.get_xdata()) for line in axes.lines]
    assert ends == [e.total_interval for e in found.indices] + [e.first_interval for e in found.indices]


def test_the_result_shows_itself_as_the_command_prints_it(folder):
    found = ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1)
    assert folder[1].startswith(found.answer)
    assert all(line in folder[1] for line in repr(found).splitlines())
    assert found._repr_html_().count("<table") == 2


def test_files_of_somebody_else_are_not_replaced(tmp_path):
    (tmp_path / "indices.csv").write_text("mine")
    with pytest.raises(InputError, match=r"indices\.csv"):
        ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1, output=tmp_path)
    assert not (tmp_path / "report.html").exists()
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="is a file"):
        ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1, output=tmp_path / "file")


def test_a_changed_parameter_and_a_missing_seed():
    run = CliRunner()
    changed = run.invoke(
        app, ["study", "--sensitivity", *ASKED, "--set", "drive.high=1 kV", "--set", "drive.rise=0 s"]
    )
    assert changed.exit_code == 0
    assert changed.stdout != run.invoke(app, ["study", "--sensitivity", *ASKED]).stdout
    assert run.invoke(app, ["study", "--sensitivity", *ASKED[:-2]]).exit_code == 2
