"""``electrovib compare SCENARIO --materials``."""

from __future__ import annotations

import pytest
from typer.testing import CliRunner

from electrovib.apps.cli import app


def run(*words):
    return CliRunner(env={"COLUMNS": "200"}).invoke(app, ["compare", *words])


def test_materials_in_a_table():
    result = run("vezzoli_2014/fig6", "--material", "pet, Kapton")
    assert result.exit_code == 0
    lines = result.stdout.splitlines()
    assert lines[0] == "Materials of the layer 'insulator', 90 um thick"
    assert [line.split("  ")[0] for line in lines[3:6]] == ["as it is", "polyimide", "pet"]
    assert "unverified: permittivity, conductivity; full text: strength" in lines[4]


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["vezzoli_2014/fig6", "--material", "kaptn"], "no material 'kaptn'. Nearest: polyimide"),
        (
            ["vezzoli_2014/fig6", "--material", "pet", "--models", "x"],
            "--models: does not belong to --material",
        ),
        (["vezzoli_2014/fig6", "--material", "pet", "--layer", "gap"], "layer 'gap': the stack has none"),
        (["--material", "pet"], "--material: needs a scenario"),
    ],
)
def test_mistakes(words, said):
    result = run(*words)
    assert result.exit_code != 0
    assert said in str(result.stderr) + str(result.exception)
