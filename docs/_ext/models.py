"""A page for each declared model: equations, parameters, source status, checks."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from itertools import groupby
from typing import Any, Final, get_type_hints

import formula
from rst import fields, grid, hidden_contents, items, joined, literal, plain, shown, title

from electrovib.core.citation import STATUSES_EXPLAINED, Check, status_text
from electrovib.core.discovery import paper_of
from electrovib.core.model import Model
from electrovib.studies.catalogue import pages as catalogue
from electrovib.studies.catalogue.items import Listed, everything, places

EVERYWHERE: Final = {
    "D": "Bound displacement [C/m2].",
    "E": "Electric field [V/m].",
    "frequency": "Frequency [Hz].",
    "time": "Time [s].",
}
"""Arguments whose meaning is the same in all models, where the method does not describe them."""


def pages() -> dict[str, str]:
    """Return the pages by file name: one for each model, and the list of all."""
    found = [item for item in everything(own=True) if is_model(item)]
    written = {f"models/{place(item.thing, item.kind)}.rst": page(item) for item in found}
    return written | {"models/index.rst": index(found)}


def is_model(item: Listed) -> bool:
    """Return whether an entry of the catalogue is a declared model."""
    return isinstance(item.thing, type)


def place(model: type[Model], kind: str) -> str:
    """Return the name of the page of a model in the folder of models, without its ending."""
    return f"{kind.replace(' ', '_')}/{model.__name__}"


def index(found: list[Listed]) -> str:
    """Write the list of all models, one table for each family."""
    parts = [
        title("Models"),
        "Every model that a scenario can be made of, as the code declares it. The source status states how the source of a"
        f" model was read: {plain(STATUSES_EXPLAINED)}.",
    ]
    for group, members in groupby(found, key=lambda item: item.group):
        rows = []
        for item in members:
            paper = f":doc:`../papers/{item.paper}`" if item.paper else ""
            status = plain(status_text(item.status))
            target = place(item.thing, item.kind)
            rows.append((f":doc:`{target}`", plain(item.meaning), paper, status, str(item.checks)))
        headings = ("model", "what it is", "paper", "source status", "checks")
        parts += [title(f"{group[0].upper()}{group[1:]}", "-"), grid(headings, rows, "22 48 12 12 6")]
    names = [f"{item.name} <{place(item.thing, item.kind)}>" for item in found]
    return joined([*parts, hidden_contents(names)])


def page(item: Listed) -> str:
    """Write the page of one model."""
    from numpydoc.docscrape import NumpyDocString

    model = item.thing
    text = NumpyDocString(inspect.getdoc(model) or "")
    parameters = catalogue.parameters(model)
    where = written_as(model)
    paper = paper_of(model)
    source = [
        ("Source status", plain(status_text(model.status))),
        ("Reference", plain(model.reference)),
        ("Paper", f":doc:`../../papers/{paper}`" if paper else ""),
        ("Code", f"``{model.__module__}``"),
    ]
    return joined(
        [
            title(item.name),
            f"*{item.kind[0].upper()}{item.kind[1:]}.* " + " ".join(text["Summary"]),
            "\n".join(text["Extended Summary"]),
            literal(where, "toml") if where else "",
            *equations(model),
            title("Parameters", "-"),
            shown(parameters) if parameters.rows else "This model has no parameters.",
            plain(model.derived_note and f"{model.derived_note[0].upper()}{model.derived_note[1:]}."),
            *section("Notes", text["Notes"]),
            title("Source", "-"),
            fields(source),
            "\n".join(text["References"]),
            *checks(model.checks),
        ]
    )


def section(name: str, lines: list[str]) -> list[str]:
    """Return a section of a docstring with its title; nothing for an empty one."""
    return [title(name, "-"), "\n".join(lines)] if any(line.strip() for line in lines) else []


def written_as(model: type[Model]) -> str:
    """Return how a scenario file names a member of a family; empty for any other model."""
    found = next((where for family, where in places().items() if issubclass(model, family)), "")
    return f'{found} = {{ model = "{model.__name__}", ... }}' if found and model.is_member else ""


def equations(model: type[Model]) -> list[str]:
    """Return the declared equations as formulas; a test compares the declarations with the code."""
    if not model.equation:
        return []
    parts = [title("Equation" if len(model.equation) == 1 else "Equations", "-")]
    for name, text in model.equation.items():
        parts += [f".. math::\n\n   {line}" for line in formula.lines(name, text)]
    meanings: dict[str, str] = {}
    for key in model.equation:
        for name, words in explained(model, key):
            if not set(name.split(", ")) <= set(", ".join(meanings).split(", ")):
                meanings[name] = words
    texts = " ".join(model.equation.values())
    for name, words in EVERYWHERE.items():
        if re.search(rf"(?<!\.)\b{name}\b", texts) and name not in model.model_fields:
            meanings.setdefault(name, words)
    if meanings:
        parts.append(items(f"``{name}``: {plain(words)}" for name, words in meanings.items()))
    return parts


def explained(model: type[Model], key: str) -> Iterator[tuple[str, str]]:
    """Explain what an equation gives, and the arguments and methods that are used and are no parameters.

    Parameters
    ----------
    model : type
        Its method is documented by itself, or by its family.
    key : str
        Name of the equation.

    Yields
    ------
    tuple of str
        Name and meaning.
    """
    from numpydoc.docscrape import NumpyDocString

    name, text = key.rpartition(".")[2], " ".join(model.equation.values())
    method = "voltage" if key == getattr(model, "quantity", None) else name
    found = [
        NumpyDocString(inspect.cleandoc(owner.__dict__[method].__doc__ or ""))
        for owner in owners(model, key)
        if method in owner.__dict__
    ]
    given = next((each["Returns"][0].desc for each in found if each["Returns"]), None)
    if found:
        yield name, in_short(given or found[0]["Summary"])
    for argument in next((each["Parameters"] for each in found if each["Parameters"]), ()):
        used = [one for one in argument.name.split(", ") if re.search(rf"\b{one}\b", text)]
        if used:
            yield ", ".join(used), in_short(argument.desc)
    for called in re.findall(r"(?<![.\w])(\w+)\(", model.equation.get(key, "")):
        if called not in model.equation and hasattr(model, called):
            yield from explained(model, called)


def owners(model: type[Model], key: str) -> tuple[type, ...]:
    """Return the classes in which a method may be documented; that of a dotted key is of what the first part returns."""
    if key.endswith("'"):
        return ()
    first = key.rpartition(".")[0]
    kind = get_type_hints(getattr(model, first))["return"] if first else model
    assert isinstance(kind, type)
    return kind.__mro__


def in_short(lines: list[str]) -> str:
    """Return a description without what concerns arrays only."""
    text = re.sub(r"[;.]? NaN gives NaN\b|,? (any|same) shape\b", "", " ".join(lines))
    return re.sub(r"^Return (the )?(\w)", lambda match: match[2].upper(), text)


def checks(found: tuple[Check, ...] | Any) -> list[str]:
    """Return the comparisons of a model or a paper with published numbers."""
    if not found:
        return []
    texts = [
        f"{check.name}: {check.expect:g} within {100 * check.rtol:.2g} % ({status_text(check.status)}; {check.source})"
        for check in found
    ]
    return [title("Checks", "-"), items(plain(text) for text in texts)]
