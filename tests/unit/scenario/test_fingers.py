"""The population of fingers: every number has a source and a status, and it suits every ready-made scenario."""

import importlib
import tomllib
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner

import electrovib as ev
from electrovib.apps.cli import app
from electrovib.core.citation import STATUSES
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError
from electrovib.physics.finger import Moisture
from electrovib.scenario.space.shipped import read_shipped, shipped_names
from electrovib.studies.catalogue.found import distributions_in, entries_of

PAGE = Path(__file__).parents[3] / "docs" / "populations.md"
CONDUCTIVITY = "stack.stratum_corneum.material.conductivity"
FILM = "vezzoli_2014/fig6_gap"


def test_every_distribution_has_a_source_a_status_and_a_confidence():
    for name in shipped_names():
        for entry in entries_of(name):
            assert entry.confidence in {"high", "medium", "low"}
            if entry.name == "share":
                assert entry.choice  # a share that no source gives is a choice, and is called one
            else:
                assert len(entry.source) > 20
                assert entry.status in STATUSES


def test_a_distribution_of_ones_own_says_what_its_author_stated():
    half = {"model": "Uniform", "low": 1, "high": 2}
    space = {"a": half, "b": half | {"choice": "ends"}, "c": {"model": "Sampled", "values": list(range(40))}}
    rows = {each.name: each.row for each in distributions_in({"space": space})}
    assert [rows[name][3] for name in "abc"] == ["not stated", "a choice", "not stated"]
    assert (rows["a"][2], rows["c"][2]) == ("Uniform, low 1, high 2", "Sampled, values 40 values")


@pytest.mark.parametrize("name", ["vezzoli_2014/fig6", FILM, "vezzoli_2014/fig7", "bau_2010/sine"])
def test_the_population_suits_scenarios_and_reports_what_they_lack(name):
    found = ev.read_space(name, "fingers")
    has_gap = ev.load(name).stack.gap_name is not None
    assert ("stack.gap.thickness" in found.paths) == has_gap
    assert ("stack.gap.thickness" in found.omitted) != has_gap
    assert any("unverified" in remark for remark in found.remarks) == has_gap
    assert any("moisture.level is not drawn" in remark for remark in found.remarks)
    ev.load(name).replace({path: float(value[0]) for path, value in found.draw(1, 0, 1).items()})


def test_dry_and_moist_fingers_women_and_men_differ():
    found = ev.read_space(FILM, "fingers")
    draws, groups = found.draw(1, 0, 20_000), found.draw_groups(1, 0, 20_000)["moisture"]
    tau = VACUUM_PERMITTIVITY * draws["stack.stratum_corneum.material.permittivity"] / draws[CONDUCTIVITY]
    dry, moist = (np.median(tau[groups == group]) for group in ("dry", "moist"))
    assert (dry / moist, dry) == (pytest.approx(10, rel=0.05), pytest.approx(5e-3, rel=0.05))
    found = ev.read_space("vezzoli_2014/fig7", "fingers")  # whose skin is of constant phase
    exponent = found.draw(1, 0, 1000)["stack.stratum_corneum.material.exponent"]
    groups = found.draw_groups(1, 0, 1000)["sex"]
    assert [set(exponent[groups == group]) for group in ("women", "men")] == [{0.8025}, {0.7545}]


def test_moisture_of_a_scenario_takes_the_place_of_the_conductivity():
    found = ev.read_space(ev.load("bau_2010/sine").replace({"moisture": dict(Moisture.example)}), "fingers")
    assert "moisture.level" in found.paths
    assert {CONDUCTIVITY, "friction.coefficient"} <= set(found.omitted)
    assert set(found.draw(1, 0, 100)["moisture.level"]) == {0.0, 1.0}


def test_a_scenario_without_a_skin_layer_is_refused():
    tables = ev.load("vezzoli_2014/fig6_gap").to_dict()
    tables["stack"]["skin"] = tables["stack"].pop("stratum_corneum") | {"role": "finger"}
    with pytest.raises(InputError, match="stratum_corneum"):
        ev.read_space(tables | {"sources": {}}, "fingers")


def test_the_command_and_the_function_show_every_distribution():
    listing = ev.spaces("fingers")
    tables = read_shipped("fingers")
    assert all(path in str(listing) for path in tables["space"])
    assert "unverified, cited from memory, low confidence" in str(listing)
    assert [record.name for record in ev.spaces()] == list(shipped_names())
    assert "<table" in listing._repr_html_()
    shown = CliRunner().invoke(app, ["list", "fingers"])
    assert shown.exit_code == 0
    assert "moisture: dry" in shown.stdout
    with pytest.raises(InputError, match="Did you mean 'fingers'"):
        ev.spaces("finger")


def test_the_page_is_as_the_populations_are_and_its_example_is_read(monkeypatch):
    monkeypatch.syspath_prepend(str(PAGE.parent / "_ext"))
    made = importlib.import_module("populations_page")
    page = made.as_markdown()
    # to renew it: python docs/_ext/populations_page.py > docs/populations.md
    assert PAGE.read_text(encoding="utf-8") == page
    assert "| unverified, cited from memory | low |" in page
    found = ev.read_space("vezzoli_2014/fig6", tomllib.loads(made.EXAMPLE))
    draws = found.draw(1, 0, 4000)
    assert (draws["stack.insulator.thickness"] < draws["stack.stratum_corneum.thickness"]).all()
    assert np.corrcoef(draws["friction.coefficient"], draws["load.normal_force"])[0, 1] < -0.25
    assert np.mean(draws[CONDUCTIVITY] < 1e-5) == pytest.approx(0.7, abs=0.03)
    assert f"```toml\n{made.EXAMPLE}```" in page
