"""What a page shows, by name: a scenario, its changes, the open tab, a step of a story; and their form in an address."""

from __future__ import annotations

import functools
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Final
from urllib.parse import parse_qsl, urlencode

from electrovib.apps.explorer.computed import TABS
from electrovib.apps.explorer.runner import LONGEST_LINK, LONGEST_VALUE, MOST_CHANGES, MOST_SAMPLES
from electrovib.core.errors import LONGEST_QUOTED, InputError, nearest, shortened
from electrovib.core.parsing import read_toml
from electrovib.core.tables import read_changes
from electrovib.scenario import Scenario, read_scenario
from electrovib.studies.catalogue import scenarios


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


def _read_stories() -> tuple[Story, ...]:
    tables = read_toml((Path(__file__).parent / "stories.toml").read_text(encoding="utf-8"))
    return tuple(
        Story(
            each["reader"],
            each["title"],
            tuple(StoryStep(f"{name}.{number}", **step) for number, step in enumerate(each["steps"], 1)),
        )
        for name, each in tables.items()
    )


STORIES: Final = _read_stories()
STEPS: Final = {step.name: step for story in STORIES for step in story.steps}
"""All steps by name, a story after the other."""


FILES: Final = frozenset({"file"})
"""Keys of tables that name a file; a page never reads one."""


@dataclass(frozen=True)
class PageState:
    """A scenario by its name, what was changed in it, and how it is shown.

    `changes` is dotted path to value as a person writes it, with its unit; `tab` is the open one, and `story` the name
    of the step of a story that is told beside it, empty for none.
    """

    preset: str
    changes: Mapping[str, str] = field(default_factory=dict)
    tab: str = TABS[0]
    story: str = ""

    @classmethod
    def of_step(cls, step: StoryStep) -> PageState:
        """Return what a step of a story shows."""
        return cls(step.preset, step.changes, step.tab, step.name)

    def to_query(self) -> str:
        """Write the state as the part of an address behind the question mark; the first tab is not written."""
        items = [("preset", self.preset), *(("set", f"{p}={v}") for p, v in self.changes.items())]
        shown = {"tab": self.tab if self.tab != TABS[0] else "", "story": self.story}
        return urlencode([*items, *((name, value) for name, value in shown.items() if value)])

    def has_scenario_of(self, other: PageState) -> bool:
        """Return whether another state has the same scenario, whatever is shown of it."""
        return (self.preset, self.changes) == (other.preset, other.changes)

    def changed(self, path: str, value: str) -> PageState:
        """Return the state with one more parameter changed; a part that is replaced loses the changes inside it."""
        return replace(self, changes={**self.reset(path).changes, path: value})

    def reset(self, path: str = "") -> PageState:
        """Return the state without the changes of one parameter or part, or without any."""
        kept = {each: text for each, text in self.changes.items() if path and not _is_inside(each, path)}
        return replace(self, changes=kept)


def presets(own: Mapping[str, Scenario] | None = None) -> list[str]:
    """Return the names of the scenarios that a page offers: the given ones, then the shipped ones."""
    return [*(own or {}), *_shipped()]


@functools.cache
def _shipped() -> tuple[str, ...]:
    return tuple(each.name for each in scenarios())


def read_query(query: str, *, own: Mapping[str, Scenario], default: str) -> PageState:
    """Read a state, whose scenario can be built, from the part of the address behind the question mark.

    An address is refused that is too long, names an unknown scenario, parameter, tab, story or file, or holds a
    value that does not fit.
    """
    if len(query) > LONGEST_LINK:
        raise InputError(f"The link has {len(query)} letters; at most {LONGEST_LINK} are read.")
    try:
        items = parse_qsl(query, keep_blank_values=True, max_num_fields=MOST_CHANGES + 10)
    except ValueError:
        raise InputError(f"The link changes more than {MOST_CHANGES} parameters.") from None
    changes = {}
    for value in [text for name, text in items if name == "set"]:
        path, equals, text = value.partition("=")
        if not equals:
            raise InputError(
                f"The link has 'set={shortened(value, LONGEST_QUOTED)}'; it has to be 'set=path=value'."
            )
        changes[path.strip()] = text
    named = {"preset": default, "tab": TABS[0], "story": ""} | dict(items)
    state = PageState(
        named["preset"], changes, _known(named, "tab", TABS), _known(named, "story", ["", *STEPS])
    )
    scenario_of(state, own=own)
    return state


def _known(named: Mapping[str, str], name: str, known: Collection[str]) -> str:
    """Return one part of a link that has to be a known name."""
    if (found := named[name]) in known:
        return found
    raise InputError(
        f"{name}: no {name} is called '{shortened(found, LONGEST_QUOTED)}'.{nearest(found, known)}"
    )


def scenario_of(state: PageState, *, own: Mapping[str, Scenario]) -> Scenario:
    """Build the scenario of a page.

    Refused are unknown names, a change that does not fit, names a file, or asks for more samples than a page
    computes.
    """
    if not all(isinstance(each, str) for each in (state.preset, *state.changes, *state.changes.values())):
        raise InputError("The name of a scenario, and the paths and values of its changes, have to be texts.")
    known = presets(own)
    if state.preset not in known:
        raise InputError(
            f"preset: no scenario is called '{shortened(state.preset, LONGEST_QUOTED)}'.{nearest(state.preset, known)}"
        )
    if len(state.changes) > MOST_CHANGES:
        raise InputError(
            f"{len(state.changes)} parameters are changed; a page changes at most {MOST_CHANGES}."
        )
    for path, text in state.changes.items():
        if len(path) > LONGEST_VALUE or len(text) > LONGEST_VALUE:
            raise InputError(
                f"{shortened(path, LONGEST_QUOTED)}: a value of a link has at most {LONGEST_VALUE} letters."
            )
    wanted = read_changes([f"{path}={text}" for path, text in state.changes.items()])
    refuse_files(wanted)
    base = own.get(state.preset) or read_scenario(state.preset)
    return refuse_many_samples(base.replace(wanted) if wanted else base)


def refuse_many_samples(scenario: Scenario) -> Scenario:
    """Return the scenario if its times and frequencies are few enough for a page; refuse it otherwise."""
    counts = {"time": scenario.time.count(scenario.drive), "frequency": scenario.frequency.samples}
    for path, count in counts.items():
        if count > MOST_SAMPLES:
            raise InputError(
                f"{path}.samples = {count}: a page computes at most {MOST_SAMPLES}; use 'electrovib run' for more."
            )
    return scenario


def refuse_files(content: Any, *, path: str = "") -> None:
    """Refuse tables that name a file: nobody who sends a link or a table makes this program read one.

    A file is named by a key of any table or by the last part of a dotted path.
    """
    if isinstance(content, Mapping):
        for key, item in content.items():
            inner = f"{path}.{key}" if path else str(key)
            if str(key).rpartition(".")[2] in FILES:
                raise InputError(
                    "names a file, which a page never reads; drop the file on the page", path=inner
                )
            refuse_files(item, path=inner)
    elif isinstance(content, Sequence) and not isinstance(content, str):
        for index, item in enumerate(content):
            refuse_files(item, path=f"{path}.{index}")


def _is_inside(path: str, part: str) -> bool:
    """Return whether a path is that of a part, or of something inside it; a model counts as its whole part."""
    part = part.removesuffix(".model")
    return path == part or path.startswith(f"{part}.")
