"""``electrovib study``."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, NoReturn, TypeAlias

import typer

from electrovib.apps.cli.force import Force
from electrovib.apps.cli.options import Changes, Models
from electrovib.apps.cli.terminal import complain, say

if TYPE_CHECKING:
    from collections.abc import Callable

    import xarray

Number: TypeAlias = Annotated[int, typer.Option("-n", metavar="N", help="Number of fingers.")]
Seed: TypeAlias = Annotated[
    int, typer.Option(metavar="N", help="Seed of the draws: the same seed draws the same fingers.")
]
Output: TypeAlias = Annotated[
    str,
    typer.Option(
        "--output",
        "-o",
        metavar="DIR.zarr",
        help="Folder of the result. If the study is interrupted, the same command continues it there.",
    ),
]
Signals: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        "--signal",
        metavar="NAME",
        help="Signal, electrostatic_force if absent; over frequency mean_force. Repeatable.",
    ),
]
Percentiles: TypeAlias = Annotated[str, typer.Option(metavar="P,P,...", help="Percentiles over the fingers.")]
Exceed: TypeAlias = Annotated[
    list[str] | None,
    typer.Option(
        metavar="VALUE", help="Threshold whose exceedance probability is wanted: '5 mN'. Repeatable."
    ),
]
Draws: TypeAlias = Annotated[
    bool, typer.Option("--draws", help="Keep the parameters and signals of every finger too.")
]
Memory: TypeAlias = Annotated[
    str,
    typer.Option(
        metavar="MEMORY",
        help="Memory within which percentiles are exact: fingers x samples x 4 bytes; beyond it within 0.3 %.",
    ),
]
Workers: TypeAlias = Annotated[
    int | None, typer.Option(metavar="N", help="Number of worker processes on this machine (Dask).")
]
Scheduler: TypeAlias = Annotated[
    str | None, typer.Option(metavar="ADDRESS", help="Dask scheduler of a cluster: tcp://host:8786.")
]
Bands: TypeAlias = Annotated[
    str | None, typer.Option("--csv", metavar="FILE", help="Write the bands as CSV.")
]
Page: TypeAlias = Annotated[
    str | None, typer.Option("--report", metavar="FILE", help="Write an HTML report.")
]


def register(app: typer.Typer) -> None:
    """Add the command."""
    app.command("study")(command)


def command(
    scenario: Annotated[
        str, typer.Argument(help="A TOML file, or a paper's scenario such as vezzoli_2014/fig6.")
    ],
    space: Annotated[
        str,
        typer.Argument(
            help="Parameters that differ between fingers: a TOML file, or a name such as fingers."
        ),
    ],
    n: Number,
    seed: Seed,
    output: Output,
    signal: Signals = None,
    percentiles: Percentiles = "5,50,95",
    exceed: Exceed = None,
    draws: Draws = False,
    budget_memory: Memory = "1 GB",
    workers: Workers = None,
    scheduler: Scheduler = None,
    csv: Bands = None,
    report: Page = None,
    changes: Changes = None,
    models: Models = None,
    force: Force = False,
) -> None:
    """Compute bands of a force over a population of fingers.

    The bands are over time or frequency; an interrupted study continues.
    """
    del models  # imported by now
    from electrovib.apps.progress import tracked
    from electrovib.scenario import read_scenario
    from electrovib.study.population import study

    base = read_scenario(scenario, changes=_read(changes)) if changes else scenario
    _check_outputs(csv, report, force=force)
    asked: dict[str, Any] = {"percentiles": _names([percentiles]), "exceed": _names(exceed), "draws": draws}
    asked |= {"budget_memory": budget_memory, "workers": workers, "scheduler": scheduler}
    done = [0, n]
    try:
        with tracked("evaluating fingers", counted=True) as progress:
            found = study(
                base,
                space,
                n=n,
                seed=seed,
                output=output,
                signal=_names(signal) or ["electrostatic_force"],
                progress=_noting(done, progress),
                **asked,
            )
    except KeyboardInterrupt:
        _interrupted(*done)
    say(*summary(found), f"written: {output}")
    say(*_written(found, csv, report, force=force))


def _written(found: xarray.Dataset, csv: str | None, report: str | None, *, force: bool) -> list[str]:
    """Write the outputs beside the store, and name them."""
    from electrovib.apps.progress import tracked

    lines = []
    if csv is not None:
        from electrovib.export.save import save

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
    from electrovib.study.population.words import check_bands
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


def _read(changes: list[str]) -> dict[str, object]:
    from electrovib.apps.changes import read_changes

    return dict(read_changes(changes))


def _names(texts: list[str] | None) -> list[str]:
    return [name.strip() for text in texts or [] for name in text.split(",") if name.strip()]


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
    from electrovib.study.population.words import NOT_JUDGED, method_words, nominal_words, signal_words

    lines = [found.attrs["title"]] if found.attrs["title"] else []
    lines += [line for name in found.attrs["signals"] for line in signal_words(found, name)]
    lines += nominal_words(found) + method_words(found)
    lines += [NOT_JUDGED, *warning_lines(diagnostics_of(found))]
    return lines + [f"note: {remark}" for remark in found.attrs["space_remarks"]]
