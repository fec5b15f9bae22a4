"""``electrovib study``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeAlias

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.options import Text, Texts, many, names_of, only, option
from electrovib.apps.cli.terminal import complain, say

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

N: TypeAlias = Annotated[
    int,
    typer.Option("-n", metavar="N", help="Number of fingers; of base draws, a power of 2, of --sensitivity."),
]
Seed: TypeAlias = Annotated[
    int, typer.Option(metavar="N", help="Seed of the draws: the same seed draws the same fingers.")
]
Quantity: TypeAlias = Annotated[
    Texts,
    many(
        "NAME",
        "Signal, electrostatic_force if absent, over frequency mean_force; of --sensitivity one as for run",
    ),
]
Sensitivity: TypeAlias = Annotated[
    bool,
    typer.Option(
        "--sensitivity",
        help="Report instead which parameters one quantity depends on most, and which to measure first.",
    ),
]
Percentiles: TypeAlias = Annotated[str, typer.Option(metavar="P,P,...", help="Percentiles over the fingers.")]
Exceed: TypeAlias = Annotated[
    Texts, many("VALUE", "Threshold whose exceedance probability is wanted: '5 mN'")
]
Draws: TypeAlias = Annotated[
    bool, typer.Option("--records", help="Keep the parameters and signals of every finger too.")
]
BudgetMemory: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="MEMORY",
        help="Memory within which percentiles are exact: fingers x samples x 4 bytes; beyond it within 0.3 %.",
    ),
]
Workers: TypeAlias = Annotated[
    Text,
    option(
        "Number of worker processes on this machine, or the Dask scheduler of a cluster: tcp://host:8786.",
        metavar="N|ADDRESS",
    ),
]
Outputs: TypeAlias = Annotated[
    Texts,
    many(
        "DIR",
        "Folder of the result, DIR.zarr, in which the same command continues an interrupted study, and a .csv file for the"
        " bands; of --sensitivity the folder for report.html, indices.csv, elasticities.csv and space.toml",
        "--output",
        "-o",
    ),
]


def command(
    context: typer.Context,
    scenario: options.Scenario,
    n: N,
    seed: Seed,
    space: options.Space = None,
    quantity: Quantity = None,
    sensitivity: Sensitivity = False,
    percentiles: Percentiles = "5,50,95",
    exceed: Exceed = None,
    draws: Draws = False,
    budget_memory: BudgetMemory = "1 GB",
    workers: Workers = None,
    outputs: Outputs = None,
    report: options.Page = None,
    changes: options.Changes = None,
    models: options.Models = None,
    force: options.Force = False,
) -> None:
    """Compute bands of a force over a population of fingers.

    The bands are over time or frequency; with --sensitivity, the parameters on which a quantity depends most.
    """
    from electrovib.apps.changes import read_changes
    from electrovib.core.errors import InputError
    from electrovib.scenario import read_scenario

    if space is None:
        raise InputError("not given; for instance --space fingers", path="--space")
    base = read_scenario(scenario, changes=read_changes(changes)) if changes else scenario
    written = list(outputs or [])
    if sensitivity:
        only(context, "scenario n seed space quantity sensitivity outputs changes", "--sensitivity")
        _print_sensitivity(base, space, quantity or [], n=n, seed=seed, outputs=written, force=force)
        return
    bands = [name for name in written if name.lower().endswith(".csv")]
    stores = [name for name in written if name not in bands]
    if len(stores) != 1 or len(bands) > 1:
        raise InputError("name one folder DIR.zarr, and at most one .csv file for the bands", path="--output")
    asked = {"percentiles": names_of([percentiles]), "exceed": names_of(exceed), "draws": draws}
    asked |= {"budget_memory": budget_memory, "signal": names_of(quantity) or ["electrostatic_force"]}
    _print_bands(
        base, space, stores[0], next(iter(bands), None), report, asked | _processes(workers), n=n, seed=seed,
        force=force,
    )  # fmt: skip


def _processes(workers: str | None) -> dict[str, int | str | None]:
    """Read a number of processes, or the address of a scheduler."""
    from electrovib.core.errors import InputError

    if workers is None or ":" in workers:
        return {"scheduler": workers}
    if not workers.isdecimal():
        raise InputError(
            "expected a number, or the address of a scheduler: tcp://host:8786",
            path="--workers",
            value=workers,
        )
    return {"workers": int(workers)}


def _print_sensitivity(
    base: Any, space: str, quantities: list[str], *, n: int, seed: int, outputs: list[str], force: bool
) -> None:
    from electrovib.core.errors import InputError
    from electrovib.studies.sensitivity import Sensitivity, sensitivity

    if len(quantities) != 1 or len(outputs) > 1:
        name = "--output" if len(outputs) > 1 else "--quantity"
        why = "--sensitivity takes exactly one: 'mean electrostatic_force', and one folder"
        raise InputError(why, path=name)
    answered(
        Sensitivity,
        sensitivity,
        words="evaluating draws",
        output=next(iter(outputs), None),
        force=force,
        scenario=base,
        space=space,
        quantity=quantities[0],
        n=n,
        seed=seed,
        progress=None,
    )


def _print_bands(
    base: Any,
    space: str,
    store: str,
    csv: str | None,
    report: str | None,
    asked: dict[str, Any],
    *,
    n: int,
    seed: int,
    force: bool,
) -> None:
    from electrovib.apps.progress import tracked
    from electrovib.studies.population import study

    _check_outputs(csv, report, force=force)
    done = [0, n]
    try:
        with tracked("evaluating fingers", counted=True) as progress:
            found = study(
                base, space, n=n, seed=seed, output=store, progress=_noting(done, progress), **asked
            )
    except KeyboardInterrupt:
        _interrupted(*done)
    say(*summary(found), f"written: {store}")
    say(*_written(found, csv, report, force=force))


def _written(found: xarray.Dataset, csv: str | None, report: str | None, *, force: bool) -> list[str]:
    """Write the outputs beside the store, and name them."""
    from electrovib.apps.progress import tracked

    lines = []
    if csv is not None:
        from electrovib.exports.save import save

        lines += [f"written: {path}" for path in save(found, csv, force=force)]
    if report is not None:
        from electrovib.view.report import report as write_report

        with tracked("drawing the report"):
            lines.append(f"written: {write_report(found, report, force=force)}")
    return lines


def _check_outputs(csv: str | None, report: str | None, *, force: bool) -> None:
    """Check before the study that its outputs can be written."""
    from pathlib import Path

    from electrovib.core.errors import InputError, gathered
    from electrovib.studies.population.result import check_bands
    from electrovib.view.pages import check_page

    problems: list[str] = []
    with gathered(problems):
        if csv is not None:
            check_bands(Path(csv), force=force)
    with gathered(problems):
        if report is not None:
            check_page(Path(report), force=force)
    if problems:
        raise InputError(problems)


def _noting(done: list[int], progress: Callable[[int, int], None]) -> Callable[[int, int], None]:
    def note(fingers: int, total: int) -> None:
        done[:] = fingers, total
        progress(fingers, total)

    return note


def _interrupted(done: int, total: int) -> NoReturn:
    from electrovib.apps.exit_codes import INTERRUPTED

    complain(f"{done} of {total} fingers are complete; the same command continues with the next")
    raise SystemExit(INTERRUPTED)


def summary(found: xarray.Dataset) -> list[str]:
    """Report each signal where its median is largest, how it was computed, and what of the space is unverified."""
    from electrovib.core.diagnostics import diagnostics_of, warning_lines
    from electrovib.studies.population.result import NOT_JUDGED, method_words, nominal_words, signal_words

    lines = [found.attrs["title"]] if found.attrs["title"] else []
    lines += [line for name in found.attrs["signals"] for line in signal_words(found, name)]
    lines += nominal_words(found) + method_words(found)
    lines += [NOT_JUDGED, *warning_lines(diagnostics_of(found))]
    return lines + [f"note: {remark}" for remark in found.attrs["space_remarks"]]
