"""A law and its priors in one file, which the challenge judges: how it is read, and what it changes of a set-up."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal

from pydantic import BaseModel, ConfigDict, Field

from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.mistakes import near_members, read_entries, shown
from electrovib.core.own_models import family_of
from electrovib.core.parsing import read_toml_file
from electrovib.scenario.space.reading import flattened, read_space
from electrovib.scenario.toml import SCHEMA
from electrovib.studies.evidence.predicted import candidates, judged_model, set_up
from electrovib.studies.evidence.split import split

if TYPE_CHECKING:
    from electrovib.studies.evidence.measurement import Measurement

REASONS: Final = ("source", "choice")
"""Entries of a range, one of which says where it is from."""


class SubmissionFile(BaseModel):
    """A law and what it takes for granted of set-ups that are not printed whole."""

    model_config = ConfigDict(extra="forbid", title="submission")

    schema_: Literal[1] = Field(SCHEMA, alias="schema", description="version of this form")
    title: str = Field(examples=["One gap as deep as the roughness"], description="the law in a few words")
    authors: str = Field(examples=["A. Example"], description="who submits it")
    law: dict[str, Any] = Field(
        examples=[{"model": "MaxwellStressInGap"}],
        description="the model, as a scenario has it in the place that is judged, with what is fixed in it",
    )
    judges: str = Field(
        "force", description="place of the model in a scenario: `force` for a law of attraction"
    )
    priors: dict[str, Any] = Field(
        {},
        description="distributions by dotted path, of the law wherever it is judged and of what a publication does not print;"
        " false for a layer that the law replaces. What is printed stays",
    )
    on: dict[str, dict[str, Any]] = Field(
        {}, description="the same for some measurements, by a part of their name, title or group"
    )
    made_from: list[str] = Field(
        [],
        description="public groups from whose numbers the law or its priors were made, which do not judge it",
    )


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


def submission_schema() -> dict[str, Any]:
    """Return the JSON schema of the file of a submission, for editors that complete and check TOML."""
    return SubmissionFile.model_json_schema()


def read_submissions(
    paths: Sequence[str | Path], measured: Mapping[str, Measurement]
) -> tuple[Submission, ...]:
    """Read the files of several submissions, whose names are not those of models or of each other; mistakes of all at once."""
    found: list[Submission] = []
    problems: list[str] = []
    for path in paths:
        with gathered(problems):
            one = read_submission(path, measured)
            taken = {each.name for each in found}.union(*(candidates(each) for each in measured.values()))
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
    family = family_of(type(judged_model(measured)))
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
    held_out = set(split().held_out)
    return [
        f"made_from: '{group}' is held out, so that its numbers judge every submission; a law or prior made from them is no"
        " prediction: make it from public groups, or from what is not in the data"
        if group in held_out
        else f"made_from: no group of the measured data is called '{group}'.{nearest(group, groups)}"
        for group in made
        if group in held_out or group not in groups
    ]


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
            scenario, tables = set_up(own, found.model, dict(found.stated.law))
            if path in tables:
                read_space(scenario, {"space": {path: table}})
                return
    known = {path for each in measured.values() for path in each.unknown}
    why = f"no set-up leaves it open, and it is no parameter of {found.model}.{nearest(path, known)}"
    raise InputError(f"{found.model} replaces it wherever it is open" if path in known else why, path=path)
