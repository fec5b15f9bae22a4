"""The page of a comparison."""

import re

import pytest

import electrovib as ev


@pytest.fixture(scope="module")
def page(scenario, tmp_path_factory):
    path = tmp_path_factory.mktemp("compare") / "compare.html"
    over = {"stack.gap.thickness": [1e-7, 1e-6, 1e-5]}
    found = ev.compare(scenario, over=over)
    ev.save(found, path)
    return found, path.read_text(encoding="utf-8")


def test_the_page_opens_with_the_law_to_believe_and_its_figure(page):
    """Then the tables, the other figures, and the explanations last; no figure has more than five curves."""
    found, text = page
    order = (
        *("<h1>", "Believe MaxwellStressInGap here", "Static force over the thickness of the gap</h2>"),
        *("<h2>Every law on this stack", "<h2>Step response", "<h2>Mean force over frequency"),
        *("<h2>Why they differ", "<h2>References"),
    )
    places = [text.index(words) for words in order]
    assert places == sorted(places)
    assert found.headline.split(":")[0] in text
    figures = re.findall(r"<figure>.*?</figure>", text, flags=re.DOTALL)
    assert len(figures) >= 3
    for figure in figures:
        assert len(set(re.findall(r"stroke: (#[0-9a-f]{6}); stroke-width: 1\.4", figure))) <= 5


@pytest.mark.usefixtures("blank_pictures")
def test_the_figure_that_belongs_to_the_drive_is_the_first(scenario, tmp_path):
    drive = {"model": "Sine", "amplitude": 100, "frequency": 50}
    sine = scenario.replace({"drive": drive, "time.initial_state.model": "PeriodicState"})
    ev.save(ev.compare(sine, models=["MaxwellStressInGap"]), tmp_path / "compare.html")
    text = (tmp_path / "compare.html").read_text(encoding="utf-8")
    assert text.index("<h2>Mean force over frequency") < text.index("<h2>Step response")
