"""``electrovib study``."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.terminal import answered, complain, say, show_answer
from electrovib.apps.exit_codes import INTERRUPTED
from electrovib.core.deprecation import former_value
from electrovib.core.errors import InputError, gathered, refuse

if TYPE_CHECKING:
    from logging import LogRecord


def study(
    context: typer.Context,
    *,
    experiment: options.ScenarioOptions,
    n: options.Count,
    seed: options.Seed,
    space: Annotated[str | None, typer.Option(autocompletion=options.space_names)] = None,
    quantity: Annotated[list[str] | None, typer.Option(callback=options.split)] = None,
    sensitivity: options.Flag = False,
    percentiles: options.Text = "5,50,95",
    exceed: options.Names = None,
    records: options.Flag = False,
    workers: options.Text = None,
    output: Annotated[
        list[str] | None, typer.Option("--output", "-o", rich_help_panel=options.ANSWER)
    ] = None,
    style: options.Style = None,  # noqa: ARG001  # which `Command.invoke` reads
    force: options.Force = False,
) -> None:
    """Compute bands of a force over a population of fingers.

    The bands are over time or frequency; with --sensitivity, the parameters on which a quantity depends most.

    Parameters
    ----------
    n : N
        Number of fingers; of base draws, a power of 2, of --sensitivity.
    seed : N
        Seed of the draws: the same seed draws the same fingers.
    quantity : NAME,...
        Signal, electrostatic_force if absent, over frequency mean_force; of --sensitivity one as for run; repeatable.
    sensitivity
        Report instead which parameters one quantity depends on most, and which to measure first.
    percentiles : P,P,...
        Percentiles over the fingers.
    exceed : VALUE,...
        Threshold whose exceedance probability is wanted: '5 mN'; repeatable.
    records
        Keep the parameters and signals of every finger too.
    workers : N|ADDRESS
        Number of worker processes on this machine, or the Dask scheduler of a cluster: tcp://host:8786.
    output : DIR
        Folder of the result, DIR.zarr, in which the same command continues an interrupted study, and files of the bands: .csv, a
        page (.html), a figure (.pdf, .svg, .png), a table (.tex); of --sensitivity one file, or the folder for report.html,
        indices.csv, elasticities.csv, space.toml and the figure; repeatable.
    """
    from electrovib.view.files import SUFFIXES

    if space is None:
        raise InputError("not given; for instance --space fingers", path="--space")
    asked = {"scenario": experiment.changed, "space": space, "n": n, "seed": seed}
    outputs = [*(output or []), *filter(None, [former_value("report", None)])]
    if sensitivity:
        options.only(context, "scenario n seed space quantity sensitivity output set", "--sensitivity")
        _print_sensitivity(asked, quantity or [], outputs, force=force)
        return
    bands = [name for name in outputs if Path(name).suffix.lower() in {".csv", *SUFFIXES}]
    stores = [name for name in outputs if name not in bands]
    if len(stores) != 1:
        raise InputError("name one folder DIR.zarr; further outputs are files of the bands", path="--output")
    asked |= options.given(
        quantity=quantity, percentiles=options.names_of(percentiles), exceed=exceed, records=records
    )
    asked |= options.given(workers=workers)
    _print_bands(asked, stores[0], bands, force=force)


def _print_sensitivity(
    asked: dict[str, Any], quantities: list[str], outputs: list[str], *, force: bool
) -> None:
    from electrovib.studies.sensitivity import Sensitivity, sensitivity

    if len(quantities) != 1 or len(outputs) > 1:
        name = "--output" if len(outputs) > 1 else "--quantity"
        why = "--sensitivity takes exactly one: 'mean electrostatic_force', and one folder"
        raise InputError(why, path=name)
    saved = options.AnswerOptions(output=next(iter(outputs), None), force=force)
    answered(Sensitivity, sensitivity, "evaluating draws", asked | {"quantity": quantities[0]}, saved)


def _print_bands(asked: dict[str, Any], store: str, bands: list[str], *, force: bool) -> None:
    """Compute the bands, print them, and write the outputs beside the store."""
    from electrovib.apps.progress import heard, tracked
    from electrovib.exports.save import save
    from electrovib.studies.population import study
    from electrovib.studies.population.answer import StudyResult
    from electrovib.view.files import check_answer

    problems: list[str] = []
    for each in bands:
        with gathered(problems):
            check_answer(StudyResult, each, force=force)
    refuse(problems)
    done = [0, asked["n"]]
    try:
        with tracked("evaluating fingers", counted=True) as progress:

            def note(record: "LogRecord") -> None:
                assert isinstance(record.args, tuple)
                done[:] = record.args
                progress(*done)

            with heard("electrovib.study", note):
                found = study(**asked, output=store)
    except KeyboardInterrupt:
        complain(f"{done[0]} of {done[1]} fingers are complete; the same command continues with the next")
        raise SystemExit(INTERRUPTED) from None
    show_answer(found)
    say(f"written: {store}")
    for each in bands:
        say(*(f"written: {path}" for path in save(found, each, force=force)))
