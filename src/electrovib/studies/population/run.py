"""Run a study: evaluate its fingers, keep what is complete, and return the bands."""

from __future__ import annotations

import functools
import logging
import time
from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import ExitStack, closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.budget import Work, allowed, megabytes, refuse_beyond
from electrovib.core.deprecation import former_value
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.data.atomic import HeldError, held, output_path
from electrovib.solve.meter import Meter, measured
from electrovib.studies.population import store
from electrovib.studies.population.declared import (
    BLOCK,
    PART_OF_MEMORY,
    PERCENTILES,
    DeclaredStudy,
    read_study,
)
from electrovib.studies.population.files import written
from electrovib.studies.population.result import arrays, attributes, draws_of
from electrovib.studies.population.tiles import Collected, Evaluator, Tile, tiles_of_cluster, tiles_of_process

if TYPE_CHECKING:
    from electrovib.scenario import Source
    from electrovib.scenario.space import SpaceSource
    from electrovib.studies.population.answer import StudyResult

    Progress = Callable[[int, int], bool | None]

_LOG: Final = logging.getLogger("electrovib.study")
PAUSE: Final = 1.0
"""Least time between two checkpoints [s]; a study that is killed loses at most about this, or the time that follows."""
_SHARE: Final = 4.0
"""A checkpoint follows the last one after at least this many times the time that it takes."""
_RATE: Final = 2e8
"""Signals that are written in a second, about [bytes/s]: what is computed as fast is not worth a checkpoint."""
_LONGEST: Final = 60.0
"""Time after which a checkpoint is written however long it takes [s]."""
_FEWER: Final = "draw fewer fingers"
_WORKER: Final = 4.0
"""Computing time until a worker process has started [s]."""
_WORKER_MEMORY: Final = 2.5e8
"""Memory of a worker process [bytes]."""


class StudyCancelledError(ElectrovibError):
    """A study that its caller has ended; what is stored can be continued."""


@measured()
def study(
    scenario: Source,
    space: SpaceSource,
    *,
    n: int,
    seed: int,
    output: str | Path | None = None,
    quantity: str | Sequence[str] = "electrostatic_force",
    percentiles: Sequence[float | str] = PERCENTILES,
    exceed: Sequence[str | float] | str | float = (),
    records: bool = False,
    workers: int | str | None = None,
) -> StudyResult:
    """Compute bands of a signal over a population of fingers.

    The variance is that of the population, estimated over n - 1. Percentiles are exact order statistics of
    float32 values while fingers x samples x 4 bytes fit a quarter of the memory that `electrovib.budget` allows, 1 GB
    by default, and otherwise come from histograms with a relative error below 0.3 %. Threads, workers and
    interruptions change numbers by rounding alone, less than 1e-12 of them.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario with the values that all fingers share, as for `electrovib.load`.
    space : str, Path, mapping or Space
        Distributions of the others, as for `electrovib.read_space`: ``"fingers"``.
    n, seed : int
        Number of fingers, and seed of the draws: the same seed draws the same fingers.
    output : str or Path, optional
        Folder ``name.zarr`` of the result, in which the same call continues an interrupted study.
    quantity : str or sequence of str
        Signals over time, or over frequency: ``"electrostatic_force"``, ``"mean_force"``.
    percentiles : sequence of float
        Percentiles over the fingers, 0 to 100.
    exceed : sequence of str or float
        Thresholds whose exceedance probability is wanted, with units or in SI: ``"5 mN"``.
    records : bool
        Whether parameters and signals of every finger are kept in the store.
    workers : int or str, optional
        Number of processes on this machine, or the address of a Dask scheduler, ``"tcp://host:8786"``; threads of this process
        if absent.

    Returns
    -------
    StudyResult
        An `xarray.Dataset` of mean, variance, percentiles and exceedance probabilities of each signal at each sample, and an
        answer as any other: printed as sentences, written by `electrovib.save` and `electrovib.report`, drawn by
        ``electrovib.plot.bands``.

    Raises
    ------
    InputError
        For every mistake in the arguments, and for a store that is damaged or of another study.
    BudgetError
        If the study would take more time or memory than `electrovib.budget` allows.

    Notes
    -----
    The logger ``electrovib.study`` is told how many fingers are done.

    Examples
    --------
    >>> found = ev.study("bau_2010/sine", "fingers", n=20, seed=1)
    >>> median = found["electrostatic_force_percentile"].sel(percentile=50)
    >>> f"{1e3 * float(median.max()):.0f} mN"
    '772 mN'
    """
    declared = read_study(
        scenario,
        space,
        n=n,
        seed=seed,
        quantity=quantity,
        percentiles=percentiles,
        exceed=exceed,
        records=records,
        budget_memory=former_value("budget_memory", allowed().memory * PART_OF_MEMORY),
    )
    where, progress = _where(workers), former_value("progress", None)
    if output is None:
        return _in_memory(declared, where, progress)
    path = output_path(output)
    if store.state_of(path, declared) == "complete":
        return _complete(path)
    evaluator = _evaluator(declared, where)
    store.refuse_full_disk(path, evaluator)
    made = not path.exists()
    with written(path):
        path.mkdir(exist_ok=True)
    try:
        _stored(path, evaluator, where, progress)
    finally:
        if made and not any(path.iterdir()):
            path.rmdir()
    return store.open_study(path)


def _complete(path: Path) -> StudyResult:
    """Return a complete study, after removing what a process killed at its very end may have left."""
    found = store.open_study(path)
    if (path / store.CHECKPOINT).exists():
        with _locked(path):
            store.clear(path)
    return found


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Hold the lock of a store."""
    with ExitStack() as stack:
        try:
            with written(path):
                stack.enter_context(held(path / store.LOCK))
        except HeldError as error:
            who = f" ({error})" if str(error) else ""
            raise InputError(
                f"another process{who} is writing this study; wait until it ends, or give another name. If it has ended on"
                f" another computer, remove {path / store.LOCK}.",
                path=path,
            ) from None
        yield


def _where(workers: int | str | None) -> dict[str, Any] | None:
    """Return the arguments of a cluster, or None for this process."""
    if workers is None:
        return None
    if isinstance(workers, str) and ":" in workers:
        return {"workers": None, "scheduler": workers}
    if isinstance(workers, str) and workers.isdecimal():
        workers = int(workers)
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        why = "expected a number of processes, 1 or more, or the address of a scheduler: tcp://host:8786"
        raise InputError(why, path="workers", value=str(workers))
    return {"workers": workers, "scheduler": None}


def _evaluator(declared: DeclaredStudy, where: dict[str, Any] | None) -> Evaluator:
    """Prepare the study, and refuse one beyond the budget, or whose blocks do not fit the memory."""
    found = Evaluator(declared)
    block = 2 * 8.0 * min(BLOCK, declared.fingers) * found.numbers
    if block > declared.memory:
        raise InputError(
            f"the signals of a block of {min(BLOCK, declared.fingers)} fingers with {found.samples} samples take"
            f" {megabytes(block)}, and they may take {_memory(declared, block)}"
        )
    workers = (where or {}).get("workers") or 0
    fingers, held = declared.fingers, block / 8.0
    refuse_beyond(
        [
            Work.counted(f"{fingers:.3g} fingers", fingers * found.numbers, held=held, remedy=_FEWER),
            Work(
                what=f"{workers} workers",
                time=workers * _WORKER,
                memory=workers * _WORKER_MEMORY,
                remedy="start fewer workers",
            ),
        ],
        what="this study",
    )
    return found


def _memory(declared: DeclaredStudy, needed: float) -> str:
    """Say how much memory signals may take, and what allows the bytes that are needed."""
    more = megabytes(1.1 * needed / PART_OF_MEMORY)
    return (
        f"{megabytes(declared.memory)}, a quarter of the memory allowed; ask for fewer time.samples, or allow more:"
        f" electrovib --budget '{more}' ..., or electrovib.budget(memory='{more}') in Python"
    )


def _in_memory(
    declared: DeclaredStudy, where: dict[str, Any] | None, progress: Progress | None
) -> StudyResult:
    """Run a study whose result is kept in memory only."""
    from electrovib.studies.population.answer import StudyResult

    evaluator = _evaluator(declared, where)
    if declared.records and not evaluator.exact:
        memory = _memory(declared, 4.0 * declared.fingers * evaluator.numbers)
        raise InputError(
            f"records: the signals of all fingers exceed {memory}; or give an output, a store to which they are written"
        )
    collected = Collected(evaluator, hold=evaluator.held or declared.records)
    with closing(_tiles(collected, where, progress)) as tiles:
        for tile in tiles:
            collected.add(tile)
            _report(progress, collected)
    found = arrays(collected)
    if declared.records:
        for name, rows in collected.rows.items():
            dims, words = draws_of(name, declared.axis)
            found[name] = (dims, rows, words)
    return StudyResult.of(found.assign_attrs(attributes(evaluator)))


def _stored(
    path: Path, evaluator: Evaluator, where: dict[str, Any] | None, progress: Progress | None
) -> None:
    """Run or continue a study in its store."""
    with _locked(path):
        state = store.state_of(path, evaluator.declared)
        if state == "complete":  # by another process, meanwhile
            return
        if state == "begun":
            store.refuse_other_method(path, evaluator)
        try:
            kept, collected = store.StudyStore(path, evaluator), Collected(evaluator, hold=evaluator.held)
            kept.restore(collected)
            _evaluate(kept, collected, where, progress)
            kept.finish(arrays(collected))
        except ElectrovibError as error:
            if state == "absent" and not isinstance(error.__cause__, OSError):
                store.remove_unbegun(path)
            raise


def _evaluate(
    kept: store.StudyStore, collected: Collected, where: dict[str, Any] | None, progress: Progress | None
) -> None:
    """Evaluate the fingers that are missing; keep what is complete from time to time, and if the study is interrupted."""
    last, took, between_tiles = time.monotonic(), 0.0, True
    total = kept.declared.fingers
    try:
        _report(progress, collected)
        with closing(_tiles(collected, where, progress)) as tiles:
            for tile in tiles:
                between_tiles = False
                collected.add(tile)
                if kept.declared.records:
                    kept.append(tile.rows)
                begun, takes = time.monotonic(), max(took, kept.waiting(collected) / _RATE)
                if begun - last >= min(_LONGEST, max(PAUSE, _SHARE * takes)) and tile.stop < total:
                    kept.commit(collected)
                    last = time.monotonic()
                    took = last - begun
                between_tiles = True
                _report(progress, collected)
    except (KeyboardInterrupt, StudyCancelledError):
        if between_tiles:
            kept.commit(collected)
        raise


def _report(progress: Progress | None, collected: Collected) -> None:
    done, total = collected.fingers, collected.evaluator.declared.fingers
    _LOG.info("%d of %d fingers", done, total)
    if progress is not None and progress(done, total) and done < total:
        raise StudyCancelledError(
            f"the study was ended after {done} of {total} fingers; the same call continues it"
        )


def _tiles(
    collected: Collected, where: dict[str, Any] | None, progress: Progress | None
) -> Generator[Tile, None, None]:
    """Yield the tiles that follow the fingers that are known, in order; end once their computing time shows too much."""
    evaluator, start = collected.evaluator, collected.fingers
    spent, count = 0.0, evaluator.declared.fingers - start
    meter = Meter.of_cases(
        "this study",
        f"{count:.3g} fingers",
        count,
        numbers=evaluator.numbers,
        held=2.0 * min(BLOCK, count) * evaluator.numbers,
        remedy=_FEWER,
        seconds=lambda: spent,
    )
    if where is None:
        tiles = tiles_of_process(evaluator, start, collected.rows)
    else:
        waiting = functools.partial(_report, progress, collected)
        tiles = tiles_of_cluster(evaluator, start, waiting=waiting, **where)
    for tile in tiles:
        yield tile
        spent += tile.seconds
        meter.count(tile.stop - start)
