"""``electrovib study``."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import answered, complain, say, show_answer
from electrovib.apps.exit_codes import INTERRUPTED
from electrovib.core.errors import InputError, gathered, refuse


@takes("""
scenario
-n N              Number of fingers; of base draws, a power of 2, of --sensitivity. [required]
--seed N          Seed of the draws: the same seed draws the same fingers. [required]
--space
--quantity NAME,... -> signal  Signal, electrostatic_force if absent, over frequency mean_force; of --sensitivity one as for run;
    repeatable.
--sensitivity     Report instead which parameters one quantity depends on most, and which to measure first.
--percentiles P,P,...  Percentiles over the fingers. [default: 5,50,95]
--exceed VALUE,...  Threshold whose exceedance probability is wanted: '5 mN'; repeatable.
--records -> draws  Keep the parameters and signals of every finger too.
--budget-memory MEMORY  Memory within which percentiles are exact: fingers x samples x 4 bytes; beyond it within 0.3 %.
    [default: 1 GB]
--workers N|ADDRESS  Number of worker processes on this machine, or the Dask scheduler of a cluster: tcp://host:8786.
-o, --output DIR  Folder of the result, DIR.zarr, in which the same command continues an interrupted study, and files of the
    bands: .csv, a figure (.pdf, .svg, .png), a table (.tex); of --sensitivity one file, or the folder for report.html,
    indices.csv, elasticities.csv, space.toml and the figure; repeatable.
--style
--report
--set
--models
--force
""")
def study(given: Arguments) -> None:
    """Compute bands of a force over a population of fingers.

    The bands are over time or frequency; with --sensitivity, the parameters on which a quantity depends most.
    """
    if "space" not in given:
        raise InputError("not given; for instance --space fingers", path="--space")
    given.put_changes()
    from electrovib.view.files import SUFFIXES

    outputs = given.pop("output", [])
    if given.pop("sensitivity", False):
        given.only("scenario n seed space signal sensitivity output set", "--sensitivity")
        _print_sensitivity(given, outputs)
        return
    bands = [name for name in outputs if Path(name).suffix.lower() in {".csv", *SUFFIXES}]
    stores = [name for name in outputs if name not in bands]
    if len(stores) != 1:
        raise InputError("name one folder DIR.zarr; further outputs are files of the bands", path="--output")
    _print_bands(given | _processes(given.pop("workers", None)), stores[0], bands)


def _processes(workers: str | None) -> dict[str, int | str | None]:
    """Read a number of processes, or the address of a scheduler."""
    if workers is None or ":" in workers:
        return {"scheduler": workers}
    if not workers.isdecimal():
        why = "expected a number, or the address of a scheduler: tcp://host:8786"
        raise InputError(why, path="--workers", value=workers)
    return {"workers": int(workers)}


def _print_sensitivity(given: Arguments, outputs: list[str]) -> None:
    from electrovib.studies.sensitivity import Sensitivity, sensitivity

    quantities = given.pop("signal", [])
    if len(quantities) != 1 or len(outputs) > 1:
        name = "--output" if len(outputs) > 1 else "--quantity"
        why = "--sensitivity takes exactly one: 'mean electrostatic_force', and one folder"
        raise InputError(why, path=name)
    wanted = given.take("scenario space n seed force")
    wanted |= {"quantity": quantities[0], "output": next(iter(outputs), None)}
    answered(Sensitivity, sensitivity, "evaluating draws", wanted)


def _print_bands(given: dict[str, Any], store: str, bands: list[str]) -> None:
    """Compute the bands, print them, and write the outputs beside the store."""
    from electrovib.apps.progress import tracked
    from electrovib.exports.save import save
    from electrovib.studies.population import study
    from electrovib.studies.population.answer import StudyResult
    from electrovib.view.files import check_answer
    from electrovib.view.pages import check_page

    force, problems = given.pop("force", False), list[str]()
    for each in bands:
        with gathered(problems):
            check_answer(StudyResult, each, force=force)
    if "report" in given:
        with gathered(problems):
            check_page(given["report"], force=force)
        bands = [*bands, given.pop("report")]
    refuse(problems)
    done = [0, given["n"]]
    try:
        with tracked("evaluating fingers", counted=True) as progress:

            def note(fingers: int, total: int) -> None:
                done[:] = fingers, total
                progress(fingers, total)

            found = study(**given, output=store, progress=note)
    except KeyboardInterrupt:
        complain(f"{done[0]} of {done[1]} fingers are complete; the same command continues with the next")
        raise SystemExit(INTERRUPTED) from None
    show_answer(found)
    say(f"written: {store}")
    for each in bands:
        say(*(f"written: {path}" for path in save(found, each, force=force)))
