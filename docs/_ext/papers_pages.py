"""A page for each paper, the ready-made scenarios, and the bibliography."""

from __future__ import annotations

from collections import Counter
from types import ModuleType
from typing import Any

from models import checks, is_model, place
from rst import fields, grid, hidden_contents, items, joined, linked, literal, plain, shown, title

from electrovib.core.citation import STATUSES, STATUSES_EXPLAINED, Check, counted, status_text
from electrovib.studies.catalogue import pages as catalogue
from electrovib.studies.catalogue.items import Listed, everything, paper_items, scenario_items


def pages() -> dict[str, str]:
    """Return the pages by file name: papers, scenarios and bibliography."""
    found = list(paper_items(own=True))
    models = [item for item in everything(own=True) if is_model(item)]
    written = {f"papers/{item.name}.rst": page(item, models) for item in found}
    citations = "\n\n".join(catalogue.bibtex(item.thing, item.name) for item in found)
    return written | {
        "papers/index.rst": index(found),
        "scenarios.rst": scenarios(),
        "bibliography.rst": bibliography(found),
        "electrovib.bib": f"{citations}\n",
    }


def index(found: list[Listed]) -> str:
    """Write the list of papers."""
    rows = []
    for item in found:
        cells = item.meaning, status_text(item.status), counted(held(item)), item.runnable
        rows.append((f":doc:`{item.name}`", *map(plain, cells)))
    text = (
        "Each paper has its claims, what it does not claim, and what of it can be computed. The source status states how"
        f" the paper was read: {plain(STATUSES_EXPLAINED)}. A check is a number of a source that is computed here; its status"
        " states how that number was read. A paper whose equations were not read runs nothing."
    )
    headings = "paper", "title", "source status", "checks", "can be run"
    table = grid(headings, rows, "16 34 12 14 24")
    return joined(
        [title("Papers"), text, how_read(found), table, hidden_contents(item.name for item in found)]
    )


def held(item: Listed) -> tuple[Check, ...]:
    """Return the checks of a paper."""
    return getattr(item.thing, "CHECKS", ())


def how_read(found: list[Listed]) -> str:
    """State how many papers have each source status, and how many checks."""
    papers = Counter(item.status for item in found)
    ways = "; ".join(f"{papers[each]} {status_text(each)}" for each in STATUSES if papers[each])
    checks = [check for item in found for check in held(item)]
    return plain(f"Of {len(found)} papers: {ways}. Of their {len(checks)} checks: {counted(checks)}.")


def page(item: Listed, models: list[Listed]) -> str:
    """Write the page of one paper."""
    module, name = item.thing, item.name
    claims = catalogue.claims(module)
    unread = " ".join(getattr(module, "NOT_READ", "").split())
    about = [
        ("Source status", plain(status_text(module.STATUS))),
        ("Claims", plain(claims.get("claims", ""))),
        ("Does not claim", plain(claims.get("does not claim", ""))),
        ("Here", plain(claims.get("here", ""))),
        ("Not read", plain(unread)),
    ]
    own = [one for one in models if one.paper == name]
    links = (f":doc:`../models/{place(one.thing, one.kind)}`: {plain(one.meaning)}" for one in own)
    values = catalogue.values(module)
    return joined(
        [
            title(name),
            items(citations(module)),
            fields(about),
            *([title("Models", "-"), items(links)] if own else []),
            *offered(module, name),
            *([title("Values of its scenarios", "-"), shown(values)] if values else []),
            *disagreements(module),
            *checks(getattr(module, "CHECKS", ())),
            title("BibTeX", "-"),
            literal(catalogue.bibtex(module, name), "bibtex"),
        ]
    )


def citations(module: ModuleType) -> list[str]:
    """Return the citations of a paper."""
    found = getattr(module, "CITATIONS", ()) or (module.CITATION,)
    return [linked(plain(str(citation))) for citation in found]


def offered(module: ModuleType, name: str) -> list[str]:
    """Return what a paper offers by name, by kind."""
    titles = {"run": "Scenarios", "skin": "Skins", "material": "Materials", "stack": "Stacks"}
    found: dict[str, list[str]] = {}
    for kind, text in catalogue.ready_made(module, name):
        found.setdefault(kind, []).append(plain(text.removeprefix("electrovib run ")))
    return [part for kind, texts in found.items() for part in (title(titles[kind], "-"), items(texts))]


def disagreements(module: Any) -> list[str]:
    """Return what in a paper does not agree with itself or with other sources."""
    found = getattr(module, "DEFECTS", ())
    return [title("Disagreements", "-"), items(plain(text) for text in found)] if found else []


def scenarios() -> str:
    """Write the list of ready-made scenarios."""
    rows = [(f"``{item.name}``", plain(item.meaning), plain(item.reproduces)) for item in scenario_items()]
    text = (
        "Each can be simulated by its name, ``electrovib run NAME``, written as a file to change,"
        " ``electrovib init NAME -o my.toml``, and changed by ``--set``. The sources of its values are on the page of its"
        " paper."
    )
    table = grid(("name", "what it is", "figure or statement that it reproduces"), rows, "25 40 35")
    return joined([title("Ready-made scenarios"), text, table])


def bibliography(found: list[Listed]) -> str:
    """Write the list of all publications that the papers of the toolkit declare."""
    read = {item.name: f"checks: {counted(held(item))}" for item in found}
    lines = sorted((item.name, text) for item in found for text in citations(item.thing))
    text = (
        "The publications behind the models and scenarios, with the page of each;"
        " :download:`all as BibTeX <electrovib.bib>`. Values of materials and of populations have further sources,"
        " named beside each value on the pages of :doc:`materials </materials>` and :doc:`populations </populations>`."
        " In brackets: how a publication was read here if not in full, and the checks of its page."
    )
    entries = (f"{line} (:doc:`papers/{name}`, {plain(read[name])})" for name, line in lines)
    return joined([title("Bibliography"), text, how_read(found), items(entries)])
