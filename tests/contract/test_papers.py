"""A paper cites, says how it was read, and carries numbers it can be held to; its scenarios name their sources and strengths."""

import math
import re

import numpy as np
import pytest

from electrovib.core.citation import STATUSES, Check
from electrovib.core.discovery import offered_by
from electrovib.papers import published
from electrovib.physics.material import Material
from electrovib.physics.safety import film_diagnostic
from electrovib.physics.stack import Stack
from electrovib.scenario import not_in_paper
from electrovib.scenario.sources import BY_THE_USER

NOT_JUDGED = {
    "rauf_2025-field_50": "a number of a field calculation, of no material",
    "shultz_2015-leaky": "a coating that conducts as a choice; no strength is known for such a layer",
}
"""Preset to why nothing is known of the strength of its insulator."""


def test_a_paper_cites_says_how_it_was_read_and_what_it_claims(paper):
    assert isinstance(paper.CITATION, str)
    found = any(mark in paper.CITATION for mark in ("doi:", "hal-", "arXiv:", "ISBN", "http"))
    assert found or paper.STATUS == "unverified"
    assert any(str(year) in paper.CITATION for year in range(1850, 2101))
    assert paper.STATUS in STATUSES
    text = " ".join((paper.__doc__ or "").split())
    assert "Claims:" in text
    assert "Does not claim" in text
    assert re.fullmatch(r"[a-z]\w*_\d{4}", paper.__name__.rsplit(".", 1)[-1])


def test_a_paper_that_was_not_read_in_full_says_so_and_checks_no_number_as_if_it_was(paper):
    if paper.STATUS == "full text":
        return
    assert all(citation.read for citation in paper.CITATIONS)
    assert all(check.status != "full text" for check in paper.CHECKS)


def test_what_a_paper_states_is_the_file_beside_it_and_its_module_offers_all_of_it(paper):
    """Nothing that the file states is lost, and whoever edits it needs no Python."""
    name = paper.__name__.rsplit(".", 1)[-1]
    if not hasattr(paper, "PAPER"):
        return  # a paper of a user may state these in Python
    stated = published(paper.__name__).stated
    assert len(paper.CITATIONS) == len(stated.citations)
    assert (stated.status, stated.not_read, stated.defects) == (paper.STATUS, paper.NOT_READ, paper.DEFECTS)
    for function in ("scenarios", "skins", "materials", "quantities"):
        assert list(getattr(paper, function, dict)()) == list(getattr(stated, function)), (name, function)
    assert set(paper.PRESETS) == set(stated.scenarios)


def test_a_paper_carries_a_check_and_its_offers_are_read_by_their_names(paper):
    classes = [thing for thing in vars(paper).values() if isinstance(thing, type)]
    of_classes = [check for kind in classes for check in getattr(kind, "checks", ())]
    assert [*getattr(paper, "CHECKS", ()), *of_classes], f"{paper.__name__} has no number to be held to"
    author_year = paper.__name__.rsplit(".", 1)[-1]
    for kind, function in [(each, name) for each in (Material, Stack) for name in each.offered_by]:
        for name, offer in offered_by(author_year, function).items():
            assert kind.model_validate(f"{author_year}/{name}") == kind.from_offer(offer)


def test_a_check_passes_and_names_its_source(asked):
    value, check = asked.value(), asked.check
    assert math.isfinite(value)
    assert check.accepts(value), f"{check.name}: {value:.6g} is not {check.expect:.6g} within {check.rtol:g}"
    assert len(check.source) > 5
    assert check.status in set(STATUSES) - {"unverified"}
    assert check.rtol <= 0.1, "a tolerance above 10 % holds a paper to nothing"


def test_a_recalled_number_is_never_a_check():
    with pytest.raises(TypeError, match="unverified"):
        Check("C", expect=1.0, rtol=0.1, source="memory", status="unverified")


def is_default(scenario, path, value):
    *parents, name = path.split(".")
    owner = scenario
    for part in parents:
        owner = owner[int(part)] if isinstance(owner, tuple) else getattr(owner, part)
    return type(owner).model_fields[name].default == value


def test_a_scenario_names_the_source_of_every_parameter_and_begins_it_with_its_papers_name(scenario, request):
    """What a paper does not print has to say so; grids and parameters at their default need no source.

    So the terminal can name the rest; a source that means the paper otherwise would be told as not found in it.
    """
    paper = request.node.callspec.id.split("-")[0]
    author, year = paper.split("_")
    found = not_in_paper(scenario, paper)
    assert set(scenario.sources) <= {path for path, _, _ in scenario.parameters()}
    for path, value, _ in scenario.parameters():
        source = scenario.sources.get(path)
        if source is None:
            assert path.startswith(("time.", "frequency.")) or is_default(scenario, path, value), path
            assert path not in found
            continue
        # as `Scenario.replace` calls what it changes; a paper makes its set-ups with `preset`
        assert not source.startswith(BY_THE_USER)
        if source.startswith(f"{author.capitalize()} {year}"):
            assert path not in found
            assert "a choice" not in source
        else:
            assert path in found or value is None or (value == 0 and is_default(scenario, path, value))
            printed = ("abstract", "section", "table", "figure", "equation", "the paper", "printed")
            assert not source.startswith(printed)


def test_each_insulator_has_a_strength_or_a_reason(scenario, request, discovered):
    """The coatings of touch screens are silica and the films are polymers."""
    assert set(NOT_JUDGED) <= set(discovered["scenario"])
    unknown = any(name in request.node.name for name in NOT_JUDGED)
    for name in (name for name, role in scenario.stack.roles.items() if role == "plate"):
        layer = scenario.stack.layers[name]
        assert layer.breakdown_field is None  # no copied constant
        diagnostic = film_diagnostic(name, layer, field=1.0)  # far below every strength
        text = diagnostic.text
        assert (diagnostic.limit is None) == unknown == ("no breakdown strength is known" in text), text
        if diagnostic.limit is not None:
            assert 1e7 < diagnostic.limit < 1e10
            assert "measured at" in text
            doubtful = "unverified" in text or "does not show" in text
            assert diagnostic.state == ("unknown" if doubtful else "ok")
        permittivity = float(layer.material.bound_permittivity(np.array(1e3)).real)
        leaky = layer.material.conductivity > 0
        assert (layer.material.substance == "silica") == (permittivity == 3.9 and not leaky)
        if layer.material.substance is None and not leaky and permittivity < 4.5:
            assert "lowest breakdown strength of polymer films in the materials library" in text
