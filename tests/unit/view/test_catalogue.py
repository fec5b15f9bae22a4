"""The page of models is as the code is."""

from __future__ import annotations

from pathlib import Path

from electrovib.view.catalogue import as_markdown

PAGE = Path(__file__).parents[3] / "docs" / "models.md"


def test_the_page_is_as_the_code_is():
    # to renew it: python -c "from electrovib.view.catalogue import as_markdown; print(as_markdown(), end='')" > docs/models.md
    assert PAGE.read_text(encoding="utf-8") == as_markdown()


def test_recalled_models_are_shown_as_such():
    page = as_markdown()
    assert "| Persson2018RoughGap | persson_2018 | recalled |" in page
    assert "| Vezzoli2014Causal | vezzoli_2014 | full text |" in page
