"""Run a study: evaluate its fingers, keep what is complete, and return the bands."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.core.allowance import megabytes
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.study.population.declared import BLOCK, MEMORY, PERCENTILES, read_study
from electrovib.study.population.effort import refuse_large
from electrovib.study.population.existing import refuse_full_disk, refuse_other_kernel, state_of
from electrovib.study.population.folder import CHECKPOINT, clear, remove_unbegun, written
from electrovib.study.population.here import tiles_of_process
from electrovib.study.population.lock import locked
from electrovib.study.population.merged import MergedFingers
from electrovib.study.population.opened import open_study
from electrovib.study.population.origin import attributes
from electrovib.study.population.result import StoredArray, arrays, dataset, draws_of
from electrovib.study.population.store import StudyStore
from electrovib.study.population.tile import Evaluator
from electrovib.study.population.writer import CheckpointWriter

if TYPE_CHECKING:
    import xarray

    from electrovib.scenario import Source
    from electrovib.scenario.space import SpaceSource
    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.reduced import TileResult

    Progress = Callable[[int, int], bool | None]


class StudyCancelledError(ElectrovibError):
    """A study that its caller has ended; what is stored can be continued."""


def study(
    scenario: Source,
    space: SpaceSource,
    *,
    n: int,
    seed: int,
    output: str | Path | None = None,
    signal: str | Sequence[str] = "electrostatic_force",
    percentiles: Sequence[float | str] = PERCENTILES,
    exceed: Sequence[str | float] | str | float = (),
    draws: bool = False,
    budget_memory: float | str = MEMORY,
    workers: int | None = None,
    scheduler: str | None = None,
    progress: Progress | None = None,
) -> xarray.Dataset:
    """Compute bands of a signal over a population of fingers.

    The variance is that of the population, estimated over n - 1. Sums are formed in blocks of 1024 fingers
    and merged in the order of their index. Percentiles are exact order statistics of float32 values while
    fingers x samples x 4 bytes fit the memory, and otherwise come from histograms with a relative error below
    0.3 %. All numbers are the same to the last bit for any number of threads and workers, and after any
    interruption.
    """
    declared = read_study(
        scenario,
        space,
        n=n,
        seed=seed,
        signal=signal,
        percentiles=percentiles,
        exceed=exceed,
        draws=draws,
        budget_memory=budget_memory,
    )
    where = _where(workers, scheduler)
    if output is None:
        return _in_memory(declared, where, progress)
    path = Path(output)
    if state_of(path, declared) == "complete":
        return _complete(path)
    evaluator = _evaluator(declared, where)
    refuse_full_disk(path, evaluator)
    made = not path.exists()
    with written(path):
        path.mkdir(exist_ok=True)
    try:
        _stored(path, evaluator, where, progress)
    finally:
        if made and not any(path.iterdir()):
            path.rmdir()
    return open_study(path)


def _complete(path: Path) -> xarray.Dataset:
    """Return a complete study, after removing what a process killed at its very end may have left."""
    found = open_study(path)
    if (path / CHECKPOINT).exists():
        with written(path), locked(path):
            clear(path)
    return found


def _where(workers: int | None, scheduler: str | None) -> dict[str, Any] | None:
    """Return the arguments of a cluster, or None for this process."""
    if workers is None and scheduler is None:
        return None
    if workers is not None and scheduler is not None:
        raise InputError("workers, scheduler: give one of them; a scheduler has its own workers")
    if workers is not None and (isinstance(workers, bool) or not isinstance(workers, int) or workers < 1):
        raise InputError(f"workers = {workers}: expected a number of processes, 1 or more")
    return {"workers": workers, "scheduler": scheduler}


def _evaluator(declared: DeclaredStudy, where: dict[str, Any] | None) -> Evaluator:
    """Prepare the study, and refuse one beyond the budget, or whose blocks do not fit the memory."""
    found = Evaluator(declared)
    block = 2 * 8.0 * min(BLOCK, declared.fingers) * found.numbers
    if block > declared.memory:
        raise InputError(
            f"budget_memory = {megabytes(declared.memory)}: the signals of a block of {min(BLOCK, declared.fingers)} fingers"
            f" with {found.samples} samples take {megabytes(block)}; ask for fewer time.samples, or allow more"
        )
    refuse_large(found, (where or {}).get("workers") or 0)
    return found


def _in_memory(
    declared: DeclaredStudy, where: dict[str, Any] | None, progress: Progress | None
) -> xarray.Dataset:
    """Run a study whose result is kept in memory only."""
    evaluator = _evaluator(declared, where)
    if declared.draws and not evaluator.exact:
        raise InputError(
            f"draws: the signals of all fingers exceed budget_memory = {megabytes(declared.memory)}; give an output, a store"
            " to which they are written, or allow more"
        )
    merged = MergedFingers(evaluator, hold=declared.draws)
    for tile in _tiles(merged, where, progress):
        merged.add(tile)
        _report(progress, merged)
    found = arrays(evaluator, merged)
    if declared.draws:
        for name, each in merged.signals.items():
            assert each.values is not None
            dims, words = draws_of(name, declared.axis)
            found[name] = StoredArray(dims, each.values, words)
    return dataset(found, attributes(evaluator))


def _stored(
    path: Path, evaluator: Evaluator, where: dict[str, Any] | None, progress: Progress | None
) -> None:
    """Run or continue a study in its store."""
    with ExitStack() as stack:
        with written(path):
            stack.enter_context(locked(path))
        state = state_of(path, evaluator.declared)
        if state == "complete":  # by another process, meanwhile
            return
        if state == "begun":
            refuse_other_kernel(path, evaluator)
        try:
            _continued(StudyStore(path, evaluator), where, progress)
        except ElectrovibError as error:
            if state == "absent" and not isinstance(
                error.__cause__, OSError
            ):  # zarr may still be writing then
                remove_unbegun(path)
            raise


def _continued(store: StudyStore, where: dict[str, Any] | None, progress: Progress | None) -> None:
    """Evaluate the fingers that are missing in a store, and write the result."""
    merged = MergedFingers(store.evaluator)
    fingers, sums = store.restored()
    if fingers:
        merged.restore(fingers, sums)
        for name, each in merged.signals.items():
            if each.values is not None:
                store.restore_rows(name, each.values)
    writer = CheckpointWriter(store, merged)
    try:
        _evaluate(merged, writer, where, progress)
        writer.complete()
        store.finish(arrays(store.evaluator, merged))
    finally:
        writer.close()


def _evaluate(
    merged: MergedFingers,
    writer: CheckpointWriter,
    where: dict[str, Any] | None,
    progress: Progress | None,
) -> None:
    """Evaluate the fingers that are missing; keep what is complete if the study is interrupted."""
    try:
        _report(progress, merged)
        for tile in _tiles(merged, where, progress):
            writer.after(merged.add(tile))
            _report(progress, merged)
    except (KeyboardInterrupt, StudyCancelledError):
        writer.finish()
        raise


def _report(progress: Progress | None, merged: MergedFingers) -> None:
    done, total = merged.fingers, merged.declared.fingers
    if progress is not None and progress(done, total) and done < total:
        raise StudyCancelledError(
            f"the study was ended after {done} of {total} fingers; the same call continues it"
        )


def _tiles(
    merged: MergedFingers, where: dict[str, Any] | None, progress: Progress | None
) -> Iterator[TileResult]:
    """Yield the tiles that follow the fingers merged so far, in order."""
    if where is None:
        return tiles_of_process(merged.evaluator, merged.fingers, merged.values)
    from electrovib.study.population.cluster import tiles_of_cluster

    return tiles_of_cluster(
        merged.evaluator, merged.fingers, waiting=lambda: _report(progress, merged), **where
    )
