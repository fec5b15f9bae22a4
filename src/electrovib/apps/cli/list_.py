"""``electrovib list``."""

from __future__ import annotations

from types import ModuleType

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import show


@takes("""
[query]... [KIND] [WORD]...  A name or words to search for, after 'scenarios' or 'spaces' among these alone; without one, an
    overview.
--all     List every entry on a line of its own.
--bibtex  Print BibTeX: of one paper, or of all.
""")
def command(given: Arguments) -> None:
    """List or search models, materials, papers, scenarios, spaces.

    Without a word an overview; with the name of one entry everything about it; else what the words find.
    """
    from electrovib.studies import catalogue

    kind, *rest = given.get("query", [""])
    words, after = " ".join([kind, *rest]), " ".join(rest)
    if "bibtex" in given:
        show(_bibtex(words))
    elif kind == "scenarios":
        show(str(catalogue.scenarios(after)))
    elif kind == "spaces" or words in {each.name for each in catalogue.spaces()}:
        show(str(catalogue.spaces(words if kind != "spaces" else after)))
    else:
        show(str(catalogue.models(after if kind == "models" else words, complete="all" in given)))


def _bibtex(name: str) -> str:
    from electrovib.core.discovery import paper_of, papers
    from electrovib.core.errors import InputError
    from electrovib.studies import catalogue

    wanted = list(papers())
    if name:
        found = catalogue.find(name)
        wanted = [name if isinstance(found, ModuleType) else paper_of(found)]
        if wanted == [""]:
            raise InputError(f"'{name}' belongs to no paper; its reference: {found.reference or 'none'}")
    return "\n\n".join(catalogue.bibtex(papers()[key], key) for key in wanted)
