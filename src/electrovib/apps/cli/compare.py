"""``electrovib compare``, ``evidence`` and ``reproduce``: laws beside each other, beside measurements and beside papers."""

from typing import Annotated

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import answered, say, show, show_answer
from electrovib.core.errors import InputError


def compare(
    context: typer.Context,
    *,
    scenario: Annotated[str | None, typer.Argument(autocompletion=options.scenario_names)] = None,
    others: Annotated[list[str] | None, typer.Argument(hidden=True)] = None,
    set: options.Changes = None,
    models: options.Texts = None,
    over: options.Texts = None,
    materials: options.Names = None,
    layer: options.Text = None,
    saved: options.AnswerOptions,
) -> None:
    """Compare force laws, or materials, on one stack.

    State which law to believe and why they differ; with --materials, compare materials of the insulator.

    Parameters
    ----------
    scenario
        A scenario; without one, the static forces of the published laws on two stacks.
    models : A,B,...|FILE.py
        Force laws, all if absent; or a Python file with laws of your own; repeatable.
    """
    from electrovib.studies.compare import Comparison, MaterialComparison, compare, compare_materials

    if others:
        listed = " ".join((str(scenario), *others))
        raise InputError(
            f"{listed}: compare takes one scenario and compares laws or materials on it; 'electrovib report {listed} -o"
            " overlay.html' overlays several Traces"
        )
    if not scenario:
        _print_static(context)
        return
    asked = options.given(layer=layer, over=over)
    if materials:
        accepted = "scenario set all materials layer output"
        options.only(context, accepted, "--materials, which compares no laws")
        named = None if materials == ["all"] else materials
        asked |= {"scenario": options.changed(scenario, set), "materials": named}
        answered(MaterialComparison, compare_materials, "comparing materials", asked, saved)
        return
    options.only(context, "scenario set all models over output", "the comparison of force laws")
    asked |= {"scenario": scenario, "models": options.read_laws(models), "set": options.changes(set)}
    answered(Comparison, compare, "comparing force laws", asked, saved)
    if not (saved.all or saved.output):
        say("--all explains why the laws differ, and lists where their papers contradict each other.")


def _print_static(context: typer.Context) -> None:
    from electrovib.core.answer import laid_out
    from electrovib.studies.surfaces import ANSWER, compare_surfaces

    if flags := options.surplus(context, "scenario all force"):
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{flag}: needs a scenario, for instance {example} {flag} ..." for flag in flags)
    say(ANSWER)
    show(laid_out(compare_surfaces()))


def evidence(
    *,
    measured: Annotated[list[str] | None, typer.Argument()] = None,
    laws: options.Texts = None,
    n: options.Count = 64,
    seed: options.Seed = 0,
    saved: options.AnswerOptions,
) -> None:
    """Judge every law by what was measured.

    Each law is compared with every published measurement that it can predict.

    Parameters
    ----------
    measured
        Part of the name, title or group of measurements, all if absent; or a file of a measurement of your own (.toml), which is
        judged alone unless others are named beside it.
    laws : FILE.toml
        A law and its priors, judged beside the others on the groups that are held out; repeatable.
    n : N
        Draws of what a publication does not print.
    seed : N
        Of the draws.

    Examples
    --------
    electrovib evidence vezzoli -o evidence
    """
    from electrovib.apps.progress import items_shown
    from electrovib.studies.evidence.function import evidence
    from electrovib.studies.evidence.result import Evidence

    asked = options.given(measured=measured, laws=laws, n=n, seed=seed)
    with items_shown("comparing with measurements"):
        answered(Evidence, evidence, "comparing with measurements", asked, saved)


def reproduce(
    *,
    paper: Annotated[str, typer.Argument(autocompletion=options.paper_names)] = "vezzoli_2014",
    output: Annotated[str, typer.Option("--output", "-o", rich_help_panel=options.ANSWER)] = "reproduction",
    skin: options.Text = None,
    force: options.Force = False,
) -> None:
    """Compute everything that a paper states.

    Write report.html, numbers.json and figures with their curves; this takes about a minute.

    Parameters
    ----------
    paper
        author_year
    output : DIR
        Folder to write to.
    skin : FILE.csv
        Table of your own skin: frequency, permittivity, resistivity (.csv).
    """
    from electrovib.apps.progress import items_shown
    from electrovib.view.pages import reproduce

    with items_shown(f"reproducing {paper}"):
        found = reproduce(paper, output, skin=skin, force=force)
    show_answer(found)
    say(f"written: {output}/report.html")
