"""A paper cites, says how it was read, and carries numbers it can be held to."""

from __future__ import annotations

import math

import pytest

from electrovib.core.checks import STATUSES, Check
from electrovib.core.discovery import offers
from electrovib.physics.material import Material
from electrovib.physics.stack import Stack
from electrovib.scenario import not_in_paper
from electrovib.scenario.sources import BY_THE_USER


def checks_in(paper):
    found = list(getattr(paper, "CHECKS", ()))
    for thing in vars(paper).values():
        found += list(getattr(thing, "checks", ())) if isinstance(thing, type) else []
    return found


def test_a_paper_cites(paper):
    assert isinstance(paper.CITATION, str)
    found = any(mark in paper.CITATION for mark in ("doi:", "hal-", "arXiv:", "ISBN", "http"))
    assert found or paper.STATUS == "unverified"
    assert any(year in paper.CITATION for year in (str(year) for year in range(1850, 2101)))


def test_a_paper_says_how_it_was_read(paper):
    assert paper.STATUS in STATUSES


def test_a_paper_says_what_it_claims_and_what_not(paper):
    text = " ".join((paper.__doc__ or "").split())
    assert "Claims:" in text
    assert "Does not claim" in text


def test_a_paper_carries_a_check(paper):
    assert checks_in(paper), f"{paper.__name__} has no number to be held to"


def test_a_paper_is_named_author_year(paper):
    name = paper.__name__.rsplit(".", 1)[-1]
    author, _, year = name.rpartition("_")
    assert author.isidentifier()
    assert year.isdigit()
    assert len(year) == 4


def test_what_a_paper_offers_is_read_by_its_name(paper):
    author_year = paper.__name__.rsplit(".", 1)[-1]
    for kind in (Material, Stack):
        for name, offer in offers(kind.offered_by, of=author_year).items():
            assert kind.model_validate(name) == kind.from_offer(offer)


def test_a_check_passes(asked):
    value = asked.value()
    check = asked.check
    assert math.isfinite(value)
    assert check.accepts(value), f"{check.name}: {value:.6g} is not {check.expect:.6g} within {check.rtol:g}"


@pytest.mark.parametrize("side", [-1, 1])
def test_a_check_refuses_a_value_three_tolerances_away(asked, side):
    check = asked.check
    assert check.accepts(check.expect)
    assert not check.accepts(check.expect * (1 + 3 * side * check.rtol))
    assert not check.accepts(math.nan)


def test_a_check_names_its_source(asked):
    assert len(asked.check.source) > 5
    assert asked.check.status in STATUSES
    assert asked.check.status != "unverified"
    assert asked.check.rtol <= 0.1, "a tolerance above 10 % holds a paper to nothing"


def test_a_recalled_number_is_never_a_check():
    with pytest.raises(TypeError, match="unverified"):
        Check("C", expect=1.0, rtol=0.1, source="memory", status="unverified")


def test_a_scenario_names_the_source_of_every_parameter(scenario):
    """What a paper does not print has to say so; grids and parameters at their default need no source."""
    unsourced = [
        path
        for path, value, _ in scenario.parameters()
        if path not in scenario.sources and not path.startswith(("time.", "frequency."))
        if not is_default(scenario, path, value)
    ]
    assert not unsourced


def test_no_value_of_a_paper_is_called_the_users(scenario):
    """As `Scenario.replace` calls what it changes; a paper makes its set-ups with `preset`."""
    assert not any(source.startswith(BY_THE_USER) for source in scenario.sources.values())


def test_sources_belong_to_parameters(scenario):
    assert set(scenario.sources) <= {path for path, _, _ in scenario.parameters()}


def test_what_a_scenario_finds_in_its_paper_begins_with_the_papers_name(scenario, request):
    """So the terminal can name the rest; a source that means the paper otherwise would be told as not found in it."""
    paper = request.node.callspec.id.split("-")[0]
    author, year = paper.split("_")
    found = not_in_paper(scenario, paper)
    for path, value, _ in scenario.parameters():
        source = scenario.sources.get(path)
        if source is None:
            assert path not in found
        elif source.startswith(f"{author.capitalize()} {year}"):
            assert path not in found
            assert "a choice" not in source
        else:
            assert path in found or value is None or (value == 0 and is_default(scenario, path, value))
            assert not source.startswith(
                ("abstract", "section", "table", "figure", "equation", "the paper", "printed")
            )


def is_default(scenario, path, value):
    *parents, name = path.split(".")
    owner = scenario
    for part in parents:
        owner = owner[int(part)] if isinstance(owner, tuple) else getattr(owner, part)
    return type(owner).model_fields[name].default == value
