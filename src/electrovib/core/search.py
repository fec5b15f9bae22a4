"""Search for an entry by its name, by words of its description, and by spelling."""

from __future__ import annotations

import difflib
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Final

from electrovib.core.errors import nearest, question

NAME, LAST, ALIAS = "name", "last part of the name", "alias"
KIND, PREFIX, WORDS, SPELLING = "kind", "prefix", "words", "spelling"
STAGES: Final = (NAME, LAST, ALIAS, KIND, PREFIX, WORDS, SPELLING)
"""How an entry was found, from best to worst."""

_PART: Final = re.compile(r"[A-Z]+(?![a-z])|[A-Z]?[a-z]+|\d+")
_WORD: Final = re.compile(r"[^\W_]+(?:\.\d+)?")
_TWO_WORDS: Final = re.compile(r"\b(touch|finger)[ -](screens?|pads?|tips?)\b", re.IGNORECASE)
_SHORTEST_PREFIX: Final = 3
_LONGEST_EXCERPT: Final = 90
_LONGEST_QUERY: Final = 100
_LIKE, _NEAR = 0.55, 0.3
"""Least likeness, 0 to 1, of the best name that is suggested, and of the others."""


@dataclass(frozen=True, kw_only=True)
class Searchable:
    """Something that can be searched for.

    `name` is what is written to use it, ``Sine`` or ``vezzoli_2014/fig6``. `texts` maps labels to the texts
    in which words are searched for besides `name` and `meaning`, the best place first.
    """

    name: str
    kind: str
    meaning: str
    aliases: tuple[str, ...] = ()
    texts: Mapping[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Match:
    """An entry that was found at a stage of `STAGES`, and why."""

    entry: Searchable
    stage: str
    reason: str


def search(query: str, entries: Iterable[Searchable], *, nearest: int = 3) -> tuple[Match, ...]:
    """Find entries by a name, a part of it, or words of a description, in the order of `STAGES`."""
    wanted = " ".join(query.split())[:_LONGEST_QUERY]
    if not wanted:
        return ()
    candidates = list(entries)
    ranked = [(*found, place) for place, entry in enumerate(candidates) if (found := _judge(wanted, entry))]
    if ranked:
        ordered = sorted(ranked, key=lambda item: (item[0], item[2]))
        return tuple(match for _, match, _ in ordered)
    return closest_entries(wanted, candidates, count=nearest)


def closest_entries(query: str, entries: Iterable[Searchable], *, count: int = 3) -> tuple[Match, ...]:
    """Find the entries whose names are spelled most similarly, whatever else would be found."""
    scored = [(_likeness(query[:_LONGEST_QUERY], entry), place, entry) for place, entry in enumerate(entries)]
    near = sorted((item for item in scored if item[0] >= _NEAR), key=lambda item: (-item[0], item[1]))
    if not near or near[0][0] < _LIKE:
        return ()
    return tuple(Match(entry, SPELLING, "similar spelling") for _, _, entry in near[:count])


def suggestions(query: str, entries: Iterable[Searchable], *, count: int = 3) -> tuple[Match, ...]:
    """Choose what someone may have meant: what a search finds, and then the names that are spelled most similarly."""
    candidates = list(entries)
    found = search(query, candidates, nearest=count)[:count]
    names = {match.entry.name for match in found}
    close = closest_entries(query, candidates, count=2 * count)
    more = [match for match in close if match.entry.name not in names]
    return (*found, *more[: count - len(found)])


def as_question(matches: Iterable[Match]) -> str:
    """Write ``" Did you mean 'x' (what it is), 'y' (...) or 'z' (...)?"``; empty without matches."""
    return asked((match.entry.name, match.entry.meaning) for match in matches)


def asked(meanings: Iterable[tuple[str, str]]) -> str:
    """Ask, as `as_question`, for names with what each is."""
    return question([f"'{name}' ({_shortened(meaning)})" for name, meaning in meanings])


def near(name: str, meanings: Mapping[str, str], *, kind: str) -> str:
    """Ask for the three names that a wrong one is most like, with the meaning of each; else list all names."""
    entries = [Searchable(name=key, kind=kind, meaning=meaning) for key, meaning in meanings.items()]
    return as_question(suggestions(name, entries)) or nearest(name, meanings)


def _judge(query: str, entry: Searchable) -> tuple[tuple[float, ...], Match] | None:
    """Rank one entry, smaller is better; None if it has nothing of the query."""
    low, name, squeezed = query.casefold(), entry.name, _squeezed(query)
    named: tuple[tuple[bool, tuple[float, ...], str, str], ...] = (
        (squeezed == _squeezed(name), (0.0, float(name != query)), NAME, "name"),
        (low == name.rpartition("/")[2].casefold(), (1.0,), LAST, LAST),
        (squeezed in map(_squeezed, entry.aliases), (2.0,), ALIAS, f"'{query}' is another name of {name}"),
        (low.removesuffix("s") == entry.kind.casefold().removesuffix("s"), (3.5,), KIND, "its kind"),
    )
    for is_found, rank, stage, reason in named:
        if is_found:
            return rank, Match(entry, stage, reason)
    parts = _PART.findall(name)
    starts = [name, *name.split("/"), *("".join(parts[at:]) for at in range(1, len(parts)))]
    if len(squeezed) > 1 and any(_squeezed(start).startswith(squeezed) for start in starts):
        return (4.0, float(not name.casefold().startswith(low))), Match(entry, PREFIX, "part of the name")
    return _by_words(query, entry)


def _by_words(query: str, entry: Searchable) -> tuple[tuple[float, ...], Match] | None:
    """Find every word of the query in the entry; the place of the worst one counts."""
    names = [*_PART.findall(entry.name), *entry.aliases]
    texts = {"meaning": entry.meaning, **entry.texts, "name": " ".join(names)}
    worst, reason = -1, ""
    for word in _words(query):
        places = [place for place, text in enumerate(texts.values()) if _has(text, word)]
        if not places:
            return None
        if places[0] > worst:
            worst = places[0]
            label = list(texts)[worst]
            reason = f"{label}: {_excerpt(texts[label], word)}" if worst else "its description"
    return ((5.0, float(worst)), Match(entry, WORDS, reason)) if reason else None


def _words(text: str) -> list[str]:
    """Split a text into words in small letters; ``touch screen`` is the word ``touchscreen``."""
    return _WORD.findall(_joined(text).casefold())


def _joined(text: str) -> str:
    return _TWO_WORDS.sub(r"\1\2", text)


def _has(text: str, word: str) -> bool:
    return any(_fits(found, word) for found in _words(text))


def _fits(found: str, word: str) -> bool:
    """Tell whether a word of a text is the wanted one, begins with it, or is its singular."""
    if found == word or (len(word) > _SHORTEST_PREFIX and found == word.removesuffix("s")):
        return True
    return len(word) >= _SHORTEST_PREFIX and found.startswith(word)


def _excerpt(text: str, word: str) -> str:
    """Cut the part of a text around a word, at blanks."""
    plain = " ".join(_joined(text).split())
    at = next((found.start() for found in _WORD.finditer(plain) if _fits(found[0].casefold(), word)), 0)
    start = 0 if at < _LONGEST_EXCERPT // 2 else plain.rfind(" ", 0, at - _LONGEST_EXCERPT // 3) + 1
    part = plain[start : start + _LONGEST_EXCERPT]
    if start + _LONGEST_EXCERPT < len(plain):
        part = f"{part.rpartition(' ')[0]} ..."
    return f"... {part}" if start else part


def _shortened(text: str) -> str:
    plain = " ".join(text.split()).rstrip(".")
    return plain if len(plain) <= _LONGEST_EXCERPT else f"{plain[:_LONGEST_EXCERPT].rpartition(' ')[0]} ..."


def _likeness(query: str, entry: Searchable) -> float:
    """Likeness of a name, or of its part after the slash, to what was written, 0 to 1."""
    names = [entry.name, *entry.aliases] + ([] if "/" in query else [entry.name.rpartition("/")[2]])
    return max(difflib.SequenceMatcher(None, query.casefold(), name.casefold()).ratio() for name in names)


def _squeezed(text: str) -> str:
    return "".join(_WORD.findall(text.casefold())).replace("_", "")
