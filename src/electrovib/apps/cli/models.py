"""``electrovib models``."""

from __future__ import annotations

import inspect
from types import ModuleType
from typing import TYPE_CHECKING, Annotated

import typer

from electrovib.apps.cli.terminal import say, show

if TYPE_CHECKING:
    from electrovib.core.checks import Check
    from electrovib.core.model import Model


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("models")(command)


def command(
    name: Annotated[
        str, typer.Argument(help="A model or a paper; without one, the list.", show_default=False)
    ] = "",
    bibtex: Annotated[bool, typer.Option("--bibtex", help="Print BibTeX: of one paper, or of all.")] = False,
) -> None:
    """List every model and paper, or show one: equation, parameters, claims, limits, checks, citation."""
    from electrovib.apps.cli.table import as_text
    from electrovib.study import catalogue

    if bibtex:
        _print_bibtex(name)
    elif not name:
        for table in catalogue.tables():
            show(as_text(table))
        say("recalled: nobody here has read the source; such a number is never a check.")
        say(catalogue.NAMES)
    else:
        found = catalogue.find(name)
        lines = paper_lines(found, name) if isinstance(found, ModuleType) else model_lines(found)
        show("\n".join(lines))


def _print_bibtex(name: str) -> None:
    from electrovib.core.discovery import paper_of, papers
    from electrovib.core.errors import InputError
    from electrovib.study import catalogue

    wanted = list(papers())
    if name:
        found = catalogue.find(name)
        wanted = [name if isinstance(found, ModuleType) else paper_of(found)]
        if wanted == [""]:
            raise InputError(f"'{name}' belongs to no paper; its reference: {found.reference or 'none'}")
    for key in wanted:
        show(catalogue.bibtex(papers()[key], key))


def model_lines(model: type[Model]) -> list[str]:
    """Show one model."""
    from electrovib.apps.cli.table import as_text
    from electrovib.core.discovery import paper_of, papers
    from electrovib.study import catalogue

    lines = [model.__name__, "=" * len(model.__name__), inspect.getdoc(model) or "", ""]
    lines += [f"equation   {name} = {text}" for name, text in model.equation.items()]
    table = catalogue.parameters(model)
    lines += ["", as_text(table)] if table.rows else ["parameters none"]
    lines.append(f"source status   {model.status or 'a definition'}")
    if model.reference:
        lines.append(f"reference  {model.reference}")
    name = paper_of(model)
    if name:
        lines.append(f"paper      {name}")
        lines += [f"{key:<10} {text}" for key, text in catalogue.claims(papers()[name]).items()]
        lines += _disagreements(papers()[name])
        lines += _checks(papers()[name])
    lines += _checks_told(model.checks)
    return lines + _beside_the_gap_plane(model)


def _beside_the_gap_plane(model: type[Model]) -> list[str]:
    """Say where a force law stands on the film of Vezzoli et al. 2014."""
    from electrovib.core.errors import ElectrovibError
    from electrovib.core.units import format_quantity
    from electrovib.physics.force import ForceLaw
    from electrovib.study.compare import compare
    from electrovib.study.surfaces import FILM

    if not issubclass(model, ForceLaw):
        return []
    try:
        found = compare(FILM.scenario("MaxwellStressInGap"), models=["MaxwellStressInGap", model.__name__])
    except ElectrovibError:
        return []
    for entry in found.entries:
        if entry.name == model.__name__:
            force = format_quantity(entry.static, "N", digits=4)
            return ["", f"On the film of Vezzoli et al. 2014 at 1000 V: {force}. {entry.why}."]
    return ["", f"On the film of Vezzoli et al. 2014: {found.left_out[model.__name__]}"]


def paper_lines(module: ModuleType, name: str) -> list[str]:
    """Show one paper."""
    from electrovib.apps.cli.table import as_text
    from electrovib.study import catalogue

    lines = [name, "=" * len(name), module.CITATION, "", f"source status   {module.STATUS}"]
    lines += [f"{key:<10} {text}" for key, text in catalogue.claims(module).items()]
    if hasattr(module, "NOT_READ"):
        lines.append(f"not read   {' '.join(module.NOT_READ.split())}")
    lines += [f"{what:<10} {text}" for what, text in catalogue.ready_made(module, name)]
    table = catalogue.values(module)
    if table:
        lines += ["", as_text(table)]
    return lines + _disagreements(module) + _checks(module)


def _disagreements(module: ModuleType) -> list[str]:
    return [f"disagrees  {text}" for text in getattr(module, "DEFECTS", ())]


def _checks(module: ModuleType) -> list[str]:
    return _checks_told(getattr(module, "CHECKS", ()))


def _checks_told(checks: tuple[Check, ...]) -> list[str]:
    return [
        f"check      {check.name}: {check.expect:g} within {100 * check.rtol:.2g} % ({check.status}; {check.source})"
        for check in checks
    ]
