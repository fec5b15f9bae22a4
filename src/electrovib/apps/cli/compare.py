"""``electrovib compare``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Everything
from electrovib.apps.cli.terminal import say, show, warned

if TYPE_CHECKING:
    from collections.abc import Mapping


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare", context_settings={"allow_extra_args": True})(command)


def command(
    context: typer.Context,
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario; without one, the static forces of the published laws on two stacks.",
            show_default=False,
        ),
    ] = "",
    changes: Changes = None,
    models: Annotated[
        list[str] | None,
        typer.Option(
            metavar="A,B,...|FILE.py",
            help="Force laws, all if absent; or a Python file with laws of your own. Repeatable.",
        ),
    ] = None,
    everything: Everything = False,
    over: Annotated[
        list[str] | None,
        typer.Option(
            metavar="PATH=FROM:TO:N[log]", help="Draw the static force over a parameter; repeatable."
        ),
    ] = None,
    materials: Annotated[
        str | None,
        typer.Option(
            metavar="A,B,...", help="Materials of the insulator instead of force laws; 'all' of the library."
        ),
    ] = None,
    layer: Annotated[
        str,
        typer.Option(
            metavar="NAME", help="Layer of --materials, if the plate has several.", show_default=False
        ),
    ] = "",
    output: Annotated[str | None, typer.Option("--output", "-o", help="Write an HTML page.")] = None,
    force: Force = False,
) -> None:
    """Compare force laws, or materials, on one stack.

    State which law to believe and why they differ; with --materials, compare materials of the insulator.
    """
    from electrovib.apps.changes import read_changes

    _refuse_several(scenario, context.args)
    changed = read_changes(changes or [])
    of_laws: dict[str, object] = {"--models": models or None, "--over": over, "--output": output}
    if not scenario:
        _print_static({"--set": changed or None, "--materials": materials, **of_laws})
    elif materials is not None:
        _refuse_with_materials(of_laws)
        _print_materials(scenario, changed, materials, layer)
    else:
        _print_laws(scenario, changed, models or [], over or [], output, everything=everything, force=force)


def _refuse_several(first: str, others: list[str]) -> None:
    """Refuse more than one scenario, and name the command that overlays several Traces."""
    from electrovib.core.errors import InputError

    if others:
        listed = " ".join((first, *others))
        raise InputError(
            f"{listed}: compare takes one scenario and compares laws or materials on it; 'electrovib report {listed} -o"
            " overlay.html' overlays several Traces"
        )


def _print_static(options: dict[str, object]) -> None:
    from electrovib.apps.cli.table import as_text
    from electrovib.study.surfaces import ANSWER, compare_surfaces

    _refuse_without_scenario(options)
    say(ANSWER)
    show(as_text(compare_surfaces()))


def _print_laws(
    scenario: str,
    changes: Mapping[str, Any],
    models: list[str],
    over: list[str],
    output: str | None,
    *,
    everything: bool,
    force: bool,
) -> None:
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.view.compare import compare

    names = _laws(models)
    with tracked("comparing force laws"):
        found = compare(scenario, set=changes, models=names, over=over, output=output, force=force)
    say(found.answer, "")
    for table in found.tables:
        show(as_text(table))
    say(*warned(found))
    if everything:
        for page in found.pages:
            show(f"{page.title}\n")
            show("\n\n".join(page.paragraphs) + "\n")
    elif not output:
        say("--all explains why the laws differ, and lists where their papers contradict each other.")
    if output:
        say(f"written: {output}")


def _print_materials(scenario: str, changes: Mapping[str, Any], materials: str, layer: str) -> None:
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.scenario import load
    from electrovib.study.compare import compare_materials

    names = [name.strip() for name in materials.split(",") if name.strip()]
    with tracked("comparing materials"):
        found = compare_materials(
            load(scenario, changes=changes), layer=layer, materials=None if names == ["all"] else names
        )
    for table in found.tables:
        show(as_text(table))
    say(*warned(found))


def _refuse_with_materials(options: dict[str, object]) -> None:
    from electrovib.core.errors import InputError

    given = [name for name, value in options.items() if value]
    if given:
        raise InputError(f"{name}: compares force laws; omit it, or --materials" for name in given)


def _laws(texts: list[str]) -> list[str] | None:
    """Import the files among what ``--models`` names; the rest are laws, or None for all of them."""
    from electrovib.core.own_models import use_models

    given = [name.strip() for text in texts for name in text.split(",")]
    for file in [name for name in given if name.endswith(".py")]:
        use_models(file)
    names = [name for name in given if not name.endswith(".py")]
    return [name for name in dict.fromkeys(names) if name] if names else None


def _refuse_without_scenario(options: dict[str, object]) -> None:
    from electrovib.core.errors import InputError

    given = [name for name, value in options.items() if value is not None]
    if given:
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{name}: needs a scenario, for instance {example} {name} ..." for name in given)
