"""``electrovib compare``."""

from __future__ import annotations

from typing import Annotated

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.terminal import say, show


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("compare")(command)


def command(
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario; without one, the static comparison of the published force laws of two stacks.",
            show_default=False,
        ),
    ] = "",
    models: Annotated[str | None, typer.Option(metavar="A,B,...", help="Force laws; all if absent.")] = None,
    over: Annotated[
        list[str] | None,
        typer.Option(metavar="PATH=FROM:TO:N[log]", help="Draw the static force over this; repeatable."),
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
    """Compare the force laws on one stack, or the materials of its insulator."""
    from electrovib.apps.cli.table import as_text

    if not scenario:
        from electrovib.study.surfaces import compare_surfaces

        _refuse_without_scenario(
            {"--models": models, "--over": over, "--materials": materials, "--output": output}
        )
        show(as_text(compare_surfaces()))
        return
    if materials is not None:
        _refuse_with_materials({"--models": models, "--over": over, "--output": output})
        _print_materials(scenario, materials, layer)
        return
    from electrovib.apps.progress import tracked
    from electrovib.view.compare import compare

    names = None
    if models is not None:
        names = list(dict.fromkeys(name.strip() for name in models.split(",") if name.strip()))
    with tracked("comparing force laws"):
        found = compare(scenario, models=names, over=over or [], output=output, force=force)
    for table in found.tables:
        show(as_text(table))
    for page in found.pages:
        show(f"{page.title}\n")
        show("\n\n".join(page.paragraphs) + "\n")
    if output:
        say(f"written: {output}")


def _print_materials(scenario: str, materials: str, layer: str) -> None:
    from electrovib.apps.cli.table import as_text
    from electrovib.apps.progress import tracked
    from electrovib.study.compare import compare_materials

    names = [name.strip() for name in materials.split(",") if name.strip()]
    with tracked("comparing materials"):
        found = compare_materials(scenario, layer=layer, materials=None if names == ["all"] else names)
    for table in found.tables:
        show(as_text(table))


def _refuse_with_materials(options: dict[str, object]) -> None:
    from electrovib.core.errors import InputError

    given = [name for name, value in options.items() if value]
    if given:
        raise InputError(f"{name}: compares force laws; leave it out, or --materials" for name in given)


def _refuse_without_scenario(options: dict[str, object]) -> None:
    from electrovib.core.errors import InputError

    given = [name for name, value in options.items() if value is not None]
    if given:
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{name}: needs a scenario, for instance {example} {name} ..." for name in given)
