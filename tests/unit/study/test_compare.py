"""Comparing laws, and the catalogue of them."""

from __future__ import annotations

import numpy as np
import pytest

from electrovib.core.discovery import find_members, papers
from electrovib.core.errors import InputError
from electrovib.physics.force import ForceLaw
from electrovib.solve.scenario import load
from electrovib.study import catalogue
from electrovib.study.compare import compare


@pytest.fixture(scope="module")
def leaky():
    return compare(load("vezzoli_2014/fig6_gap"), over={"stack.gap.thickness": np.geomspace(1e-7, 1e-4, 3)})


def test_every_law_is_compared_or_says_why_not(leaky):
    assert {entry.name for entry in leaky.entries} | set(leaky.left_out) == set(find_members(ForceLaw))


def test_entries_are_ordered_and_explained(leaky):
    forces = [entry.static for entry in leaky.entries]
    assert forces == sorted(forces, reverse=True)
    why = {entry.name: entry.why for entry in leaky.entries}
    assert "permittivity 1560" in why["StratumCorneumPlane"]
    assert "effective permittivity 10.74" in why["EffectiveMediumPlane"]
    assert "rises" in why["InsulatorPlane"]
    assert "falls" in why["GapPlane"]
    assert not any("has more in it" in entry.why for entry in leaky.entries if entry.name.endswith("Plane"))


def test_planes_differ_in_time_as_well_as_in_size(leaky):
    change = {entry.name: entry.late / entry.early for entry in leaky.entries if len(entry.step)}
    assert change["EffectiveMediumPlane"] == pytest.approx(1.0, abs=1e-2)
    assert change["GapPlane"] < 1e-4
    assert change["InsulatorPlane"] > 1.05


def test_a_law_of_magnitudes_has_a_static_force_but_no_step(leaky):
    found = {entry.name: entry for entry in leaky.entries}
    literal = found["Vezzoli2014PerFrequency"]
    assert len(literal.step) == 0
    assert literal.static == pytest.approx(found["Vezzoli2014Causal"].static, rel=1e-9)


def test_defects_of_the_founding_paper_are_told(leaky):
    text = " ".join(paragraph for page in leaky.pages for paragraph in page.paragraphs)
    for word in ("10.74", "1.0096", "falling edges", "answers before the pulse"):
        assert word in text


def test_the_static_force_is_drawn_over_a_parameter(leaky):
    panel = leaky.panels[-1]
    assert panel.x == ("stack.gap.thickness", "m")
    assert all(len(curve.x) == 3 for curve in panel.curves)


def test_an_unknown_law_is_refused_with_the_nearest_name():
    with pytest.raises(InputError, match="Did you mean 'GapPlane'"):
        compare(load("vezzoli_2014/fig6"), models=["GapPlan"])


def test_catalogue_lists_everything_found_with_status_and_checks():
    listed = {entry.name: entry for entry in catalogue.models()}
    assert set(find_members(ForceLaw)) | set(papers()) <= set(listed)
    assert listed["Vezzoli2014Causal"].paper == "vezzoli_2014"
    assert listed["Vezzoli2014Causal"].status == "full text"
    assert listed["vezzoli_2014"].checks == 3


@pytest.mark.parametrize("name", list(papers()))
def test_every_paper_says_what_it_claims_and_what_not(name):
    said = catalogue.claims(papers()[name])
    assert said["claims"]
    assert said["does not claim"]


@pytest.mark.parametrize("name", list(papers()))
def test_bibtex_has_key_and_citation(name):
    entry = catalogue.bibtex(papers()[name], name)
    assert entry.startswith(f"@misc{{{name},")
    assert entry.count("{") == entry.count("}")


def test_an_unknown_name_is_refused():
    with pytest.raises(InputError, match="neither a model nor a paper"):
        catalogue.find("GapPlne")
