"""The challenge: groups that are held out, a law and its priors in one file, and how it stands beside the shipped laws."""

from __future__ import annotations

import functools
import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from electrovib.core.answer import Table
from electrovib.core.discovery import find_members
from electrovib.core.errors import ElectrovibError, InputError, gathered, in_short, nearest, refuse
from electrovib.core.mistakes import near_members, read_entries, shown
from electrovib.core.own_models import family_of
from electrovib.core.parsing import read_toml_file
from electrovib.scenario.space.reading import flattened, read_space
from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence import predicted
from electrovib.studies.evidence.measurement import Measurement
from electrovib.studies.evidence.standing import LEVEL, CommonSet, Score, comparisons, several, shown_first

FILE: Final = Path(__file__).with_name("split.toml")
PUBLIC, HELD_OUT = "public", "held out"
SIDES: Final = (HELD_OUT, PUBLIC)
"""Sides of the split, the one that judges first."""


class Split(BaseModel):
    """Version of the measured data, the groups on each side, and a fingerprint of the numbers of each publication."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    version: str = Field(pattern=r"^\d+\.\d+$")
    public: tuple[str, ...]
    held_out: tuple[str, ...]
    numbers: Mapping[str, str]

    def side_of(self, group: str) -> str:
        """Return the side of a group; empty for one that is not part of the challenge, as of a file of one's own."""
        return HELD_OUT if group in self.held_out else PUBLIC if group in self.public else ""


@functools.cache
def split() -> Split:
    """Read the split."""
    return read_entries(Split, read_toml_file(FILE, kind="a split", advice=""), of="a split")


def fingerprint(measured: Mapping[str, Measurement]) -> str:
    """Return a short digest of what judges in a publication: groups, quantities, values, spreads and what they count as."""
    told = [
        [name, each.group, each.named, each.unit, each.over, each.bound, each.error_of, each.judges]
        + [each.same_as, each.per, repr(sorted(each.per_changes.items()))]
        + [[f"{number:.9g}" for number in numbers] for numbers in (each.at, each.values, each.spread)]
        for name, each in sorted(measured.items())
    ]
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:16]


REASONS: Final = ("source", "choice")
"""Entries of a range, one of which says where it is from."""


class SubmissionFile(BaseModel):
    """A law and what it takes for granted of set-ups that are not printed whole."""

    model_config = ConfigDict(extra="forbid", use_attribute_docstrings=True, title="submission")

    schema_: Literal[1] = Field(SCHEMA, alias="schema")
    """version of this form"""
    title: str = Field(examples=["One gap as deep as the roughness"])
    """the law in a few words"""
    authors: str = Field(examples=["A. Example"])
    """who submits it"""
    law: dict[str, Any] = Field(examples=[{"model": "MaxwellStressInGap"}])
    """the model, as a scenario has it in the place that is judged, with what is fixed in it"""
    judges: str = "force"
    """place of the model in a scenario: `force` for a law of attraction"""
    priors: dict[str, Any] = Field(
        {},
        description="distributions by dotted path, of the law wherever it is judged and of what a publication does not print;"
        " false for a layer that the law replaces. What is printed stays",
    )
    on: dict[str, dict[str, Any]] = {}
    """the same for some measurements, by a part of their name, title or group"""
    made_from: list[str] = []
    """public groups from whose numbers the law or its priors were made, which do not judge it"""


@dataclass(frozen=True, kw_only=True)
class Submission:
    """A submission as it was read; `name` is that of its file without the suffix."""

    name: str
    stated: SubmissionFile

    @property
    def model(self) -> str:
        """Name of the model."""
        return str(self.stated.law["model"])

    def applied(self, name: str, measured: Measurement) -> Measurement:
        """Return a measurement with the priors of the submission in place of the ranges that are open there."""
        unknown, own = dict(measured.unknown), dict(measured.of_model.get(self.model, {}))
        for path, table in self._priors(name, measured):
            if path.startswith(f"{measured.judges}.") or path in own or table is False:
                own[path] = table or None
            elif path in unknown:
                unknown[path] = table
        return replace(measured, unknown=unknown, of_model={self.model: own})

    def _priors(self, name: str, measured: Measurement) -> Iterator[tuple[str, Any]]:
        """Yield the priors for a measurement, those for some after those for all."""
        yield from flattened(self.stated.priors).items()
        for word, tables in self.stated.on.items():
            if _is_meant(word, name, measured):
                yield from flattened(tables).items()


def _is_meant(word: str, name: str, measured: Measurement) -> bool:
    return word.casefold() in f"{name} {measured.title} {measured.group}".casefold()


def read_submissions(
    paths: Sequence[str | Path], measured: Mapping[str, Measurement]
) -> tuple[Submission, ...]:
    """Read the files of several submissions, whose names are not those of models or of each other; mistakes of all at once."""
    found: list[Submission] = []
    problems: list[str] = []
    for path in paths:
        with gathered(problems):
            one = read_submission(path, measured)
            taken = {each.name for each in found}.union(
                *(predicted.candidates(each) for each in measured.values())
            )
            if one.name in taken:
                raise InputError(
                    "another law or file has this name; call the file otherwise", path=Path(path)
                )
            found.append(one)
    refuse(problems)
    return tuple(found)


def read_submission(path: str | Path, measured: Mapping[str, Measurement]) -> Submission:
    """Read the file of a submission to these measurements; every mistake at once.

    Parameters
    ----------
    path : str or Path
        The file (.toml).
    measured : mapping of str to Measurement
        What it is to predict, by name.

    Returns
    -------
    Submission
        The law and its priors.

    Raises
    ------
    InputError
        If an entry is wrong, nothing is measured of its place, the law is not known, a prior has neither source nor choice
        or fits no set-up, or the law was made from what judges it.
    """
    advice = "docs/evidence/challenge.md has one to begin with"
    content = read_toml_file(Path(path), kind="a submission", advice=advice)
    stated = read_entries(SubmissionFile, content, of="a submission")
    found = Submission(name=Path(path).stem, stated=stated)
    judged = {name: each for name, each in measured.items() if each.judges == stated.judges}
    if not judged:
        known = dict.fromkeys(each.judges for each in measured.values())
        raise InputError(
            f"nothing is measured of it.{nearest(stated.judges, known)}", path="judges", value=stated.judges
        )
    problems: list[str] = []
    with gathered(problems):
        _check_law(found, next(iter(judged.values())))
    with gathered(problems):
        refuse(_of_made(stated.made_from, {each.group for each in measured.values()}))
    problems += [
        f"on.{word}: no measurement that is judged has this in its name, title or group"
        for word in stated.on
        if not any(_is_meant(word, name, each) for name, each in judged.items())
    ]
    if not problems:
        problems += _of_priors(found, judged)
    refuse(problems)
    return found


def _check_law(found: Submission, measured: Measurement) -> None:
    family = family_of(type(predicted.judged_model(measured)))
    name = found.stated.law.get("model")
    if name not in find_members(family):
        more = "; a law of your own is imported by --models FILE.py" if name else ""
        raise InputError(
            f"expected the name of a {family.__name__}{more}.{near_members(family, str(name))}",
            path="law.model",
            value=str(name or ""),
        )


def _of_made(made: list[str], groups: set[str]) -> list[str]:
    """Say which groups cannot have made a law: those that judge it, and those that nobody knows."""
    known = split().held_out
    held_out = [
        f"made_from: '{group}' is held out, so that its numbers judge every submission; a law or prior made from them is no"
        " prediction: make it from public groups, or from what is not in the data"
        for group in made
        if group in known
    ]
    unknown = [group for group in made if group not in groups.union(known)]
    nobody = "made_from: no group of the measured data is called"
    return held_out + [f"{nobody} '{group}'.{nearest(group, groups)}" for group in unknown]


def _of_priors(found: Submission, measured: Mapping[str, Measurement]) -> list[str]:
    """Say which priors have no reason, cannot be read, or change nothing anywhere."""
    problems: list[str] = []
    tables = {"priors": found.stated.priors} | {f"on.{word}": each for word, each in found.stated.on.items()}
    for within, given in tables.items():
        alone = replace(found, stated=found.stated.model_copy(update={"priors": given, "on": {}}))
        meant = {
            name: each
            for name, each in measured.items()
            if within == "priors" or _is_meant(within.removeprefix("on."), name, each)
        }
        for path, table in flattened(given).items():
            with gathered(problems, within=within):
                _check_prior(path, table, alone, meant)
    return problems


def _check_prior(path: str, table: Any, found: Submission, measured: Mapping[str, Measurement]) -> None:
    """Refuse a prior without a reason, one that cannot be read, and one of what no set-up leaves open."""
    if table is False:
        return
    if not isinstance(table, Mapping):
        raise InputError(
            "expected a distribution, or false for a layer that the law replaces",
            path=path,
            value=shown(table),
        )
    if not any(table.get(reason) for reason in REASONS):
        raise InputError("a prior states its source, or calls itself a choice", path=path)
    for name, each in measured.items():
        own = found.applied(name, each)
        if path in own.unknown or path in own.of_model[found.model]:
            scenario, tables = predicted.set_up(own, found.model, dict(found.stated.law))
            if path in tables:
                read_space(scenario, {"space": {path: table}})
                return
    known = {path for each in measured.values() for path in each.unknown}
    why = f"no set-up leaves it open, and it is no parameter of {found.model}.{nearest(path, known)}"
    raise InputError(f"{found.model} replaces it wherever it is open" if path in known else why, path=path)


def submitted(
    found: Submission, name: str, measured: Measurement, *, n: int, seed: int
) -> tuple[predicted.ModelPrediction | None, str]:
    """Compute what a submission predicts of a measurement, or the reason why it cannot."""
    if measured.group in found.stated.made_from:
        return None, "it was made from these numbers"
    try:
        own = found.applied(name, measured)
        one = predicted.prediction(own, found.model, dict(found.stated.law), n=n, seed=seed)
    except ElectrovibError as error:
        return None, in_short(error)
    return replace(one, model=found.name), ""


def refuse_idle(
    entered: Sequence[Submission], scores: Sequence[Score], refused: Mapping[str, Mapping[str, str]]
) -> None:
    """Refuse submissions that predict no measurement, with every reason once."""
    known = {each.model for each in scores}
    problems = {
        f"{law.name} predicts no measurement: {why[law.name]}": None
        for law in entered
        for why in refused.values()
        if law.name not in known and law.name in why
    }
    refuse([*problems])


def sets_of(found: Submission, scores: Sequence[Score], nulls: Sequence[Score]) -> dict[str, list[CommonSet]]:
    """Return, for each side, the common sets on which the submission stands, the one with the most laws first."""
    sides: dict[str, list[CommonSet]] = {}
    for side in SIDES:
        own = [each for each in scores if split().side_of(each.group) == side]
        known = comparisons(found.stated.judges, own, nulls) if own else ()
        sides[side] = [each for each in known if found.name in {one.model for one in each.standings}]
    return sides


def sentences(found: Submission, sides: Mapping[str, list[CommonSet]]) -> list[str]:
    """Say how a submission stands on one common set of each side, that of `shown_first`."""
    said = []
    for side, sets in sides.items():
        which = f"{found.name} on groups that are {side}"
        if not sets:
            said.append(f"{which}: it predicts none of them{' and has no rank' * (side == HELD_OUT)}.")
            continue
        shown = shown_first(sets)
        row = _row(found, side, shown)
        said.append(
            f"{which}, {several(shown.numbers, 'number')} of {several(shown.groups, 'group')}: skill {row['skill']}"
            f" ({row[INTERVAL]}) over '{row['null model']}', width {row['width']} decades, rank {row['rank']}."
        )
    return said


INTERVAL = f"{100 * LEVEL:.0f} % of it"


def table(found: Submission, sides: Mapping[str, list[CommonSet]]) -> Table:
    """List how a submission stands on every common set of each side."""
    rows = [_row(found, side, each) for side, sets in sides.items() for each in sets]
    title = f"Challenge {split().version}: {found.name}, {found.stated.title} ({found.stated.authors})"
    looks = dict.fromkeys((1, 2, 3, 4, 6, 7, 8), "number")
    headings = tuple(rows[0] if rows else ())
    return Table(title, headings, tuple(tuple(row.values()) for row in rows), looks=looks)


def _row(found: Submission, side: str, each: CommonSet) -> dict[str, str]:
    """Return how a submission stands on a common set, by heading."""
    (own,) = (one for one in each.standings if one.model == found.name)
    rank = 1 + sum(one.skill > own.skill for one in each.standings)
    return {
        "side": side,
        "numbers": str(each.numbers),
        "groups": str(each.groups),
        "skill": f"{own.skill:.2f}",
        INTERVAL: f"{own.low:.2f} to {own.high:.2f}" if each.groups > 1 else "no interval from one group",
        "null model": each.null,
        "width": f"{own.width:.2f}",
        "within 90 %": f"{100 * own.covered:.0f} %",
        "rank": f"{rank} of {len(each.standings)}",
        "the best": each.standings[0].model,
    }
