"""What a paper's ready-made scenario shows of the paper, and the words by which it is found."""

from __future__ import annotations

from dataclasses import dataclass

from electrovib.core.discovery import offers, papers
from electrovib.core.search import Searchable, as_question, suggestions


@dataclass(frozen=True)
class PresetNote:
    """What a ready-made scenario shows, and words that a user may search for and that neither title nor stack has."""

    reproduces: str
    keywords: str = ""


def note_of(name: str) -> PresetNote:
    """Return what a paper declares of a ready-made scenario; empty words where it declares nothing."""
    author_year, _, key = name.partition("/")
    declared: dict[str, PresetNote] = getattr(papers()[author_year], "PRESETS", {})
    return declared.get(key, PresetNote(""))


def near_presets(name: str) -> str:
    """Ask for the three ready-made scenarios that a wrong name or word is most like, with the title of each."""
    entries = [
        Searchable(
            name=key, kind="scenario", meaning=scenario.title, texts={"keywords": note_of(key).keywords}
        )
        for key, scenario in offers(("scenarios",)).items()
    ]
    return f"{as_question(suggestions(name, entries))} 'electrovib list scenarios' lists all."
