"""``electrovib compare``."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.options import Text, Texts, many, names_of, only, output, scenario_names
from electrovib.apps.cli.terminal import say, show, show_answer

if TYPE_CHECKING:
    from collections.abc import Mapping


def command(
    context: typer.Context,
    scenario: Annotated[
        str,
        typer.Argument(
            help="A scenario; without one, the static forces of the published laws on two stacks.",
            autocompletion=scenario_names,
            show_default=False,
        ),
    ] = "",
    others: Annotated[Texts, typer.Argument(hidden=True)] = None,
    changes: options.Changes = None,
    models: Annotated[
        Texts, many("A,B,...|FILE.py", "Force laws, all if absent; or a Python file with laws of your own")
    ] = None,
    everything: options.Everything = False,
    over: options.Over = None,
    material: options.Material = None,
    layer: options.Layer = "",
    file: Annotated[Text, output("Write an HTML page.")] = None,
    force: options.Force = False,
) -> None:
    """Compare force laws, or materials, on one stack.

    State which law to believe and why they differ; with --material, compare materials of the insulator.
    """
    from electrovib.apps.changes import read_changes

    _refuse_several(scenario, others or [])
    changed = read_changes(changes or [])
    if not scenario:
        _print_static(
            {"--set": changed, "--material": material, "--models": models, "--over": over, "--output": file}
        )
    elif material is not None:
        only(
            context,
            "scenario changes everything material layer",
            "--material, which compares no laws",
            "force",
        )
        _print_materials(scenario, changed, names_of([material]), layer)
    else:
        only(context, "scenario changes everything models over file", "the comparison of force laws")
        _print_laws(scenario, changed, models or [], over or [], file, everything=everything, force=force)


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
    from electrovib.core.answer import laid_out
    from electrovib.studies.surfaces import ANSWER, compare_surfaces

    _refuse_without_scenario(options)
    say(ANSWER)
    show(laid_out(compare_surfaces()))


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
    from electrovib.studies.compare import Comparison, compare

    answered(
        Comparison,
        compare,
        words="comparing force laws",
        output=output,
        force=force,
        show=functools.partial(show_answer, everything=everything),
        scenario=scenario,
        set=changes,
        models=_laws(models),
        over=over,
    )
    if not everything and not output:
        say("--all explains why the laws differ, and lists where their papers contradict each other.")


def _print_materials(scenario: str, changes: Mapping[str, Any], names: list[str], layer: str) -> None:
    from electrovib.scenario import load
    from electrovib.studies.compare import MaterialComparison, compare_materials

    given = load(scenario, changes=changes)
    materials = None if names == ["all"] else names
    answered(
        MaterialComparison,
        compare_materials,
        words="comparing materials",
        scenario=given,
        layer=layer,
        materials=materials,
    )


def _laws(texts: list[str]) -> list[str] | None:
    """Import the files among what ``--models`` names; the rest are laws, or None for all of them."""
    from electrovib.core.own_models import use_models

    given = names_of(texts)
    files = [name for name in given if name.endswith(".py")]
    for file in files:
        use_models(file)
    names = [name for name in dict.fromkeys(given) if name not in files]
    return names if names or (texts and not files) else None


def _refuse_without_scenario(options: dict[str, object]) -> None:
    from electrovib.core.errors import InputError

    given = [name for name, value in options.items() if value]
    if given:
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{name}: needs a scenario, for instance {example} {name} ..." for name in given)
