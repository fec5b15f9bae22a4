"""Stories for visitors of the page: steps, each a scenario with changes, a tab, and the sentence that says what to see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final

from electrovib.core.parsing import read_toml


@dataclass(frozen=True)
class StoryStep:
    """One state of the page; `name` is that of its story with its number, as in an address.

    `asks` is the dotted path of the parameter that a visitor may change to see what the sentence is about.
    """

    name: str
    preset: str
    tab: str
    sentence: str
    asks: str
    changes: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Story:
    """Steps for one kind of visitor."""

    reader: str
    title: str
    steps: tuple[StoryStep, ...]


def _shipped() -> tuple[Story, ...]:
    tables = read_toml((Path(__file__).parent / "stories.toml").read_text(encoding="utf-8"))
    return tuple(
        Story(
            each["reader"],
            each["title"],
            tuple(StoryStep(f"{name}.{number}", **step) for number, step in enumerate(each["steps"], 1)),
        )
        for name, each in tables.items()
    )


STORIES: Final = _shipped()
STEPS: Final = {step.name: step for story in STORIES for step in story.steps}
"""All steps by name, a story after the other."""
