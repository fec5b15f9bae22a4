"""Evaluation of the tiles of a study by the workers of a Dask cluster."""

from __future__ import annotations

import importlib.util
import logging
from collections import deque
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Final

from electrovib.core.errors import InputError
from electrovib.study.population.declared import BLOCK
from electrovib.study.population.tiles import TileSizes, largest_tile
from electrovib.study.population.worker import computing_versions, refuse_problems, tile_on_worker

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from electrovib.study.population.reduced import TileResult
    from electrovib.study.population.tile import Evaluator

_SECONDS: Final = 1.0
"""Computing time of a task, about [s]: what a worker that is lost costs."""
_AHEAD: Final = 3
"""Tasks for each worker that are given out before the first of them is merged."""
_MOST: Final = 64 * BLOCK
"""Fingers of a task whose signals are not sent back, at most."""
_POLL: Final = 0.2
"""Time after which the progress is reported while a task is awaited [s]."""
_CONNECT: Final = 10.0
"""Time within which a scheduler has to answer [s]."""


def tiles_of_cluster(
    evaluator: Evaluator,
    start: int,
    *,
    workers: int | None,
    scheduler: str | None,
    waiting: Callable[[], None],
) -> Iterator[TileResult]:
    """Yield the tiles from a finger on, in order, evaluated by a Dask cluster.

    A task receives the study as text and the indices of its fingers. The task of a worker that is lost is
    given to another one by the scheduler.
    """
    with _client(workers, scheduler) as client:
        declared, text, versions = evaluator.declared, evaluator.declared.to_text(), computing_versions()
        most = largest_tile(evaluator.numbers)  # signals are sent back, or else a histogram of more fingers
        most = most if evaluator.kept else max(most, _MOST)
        sizes = TileSizes(declared.fingers, most, seconds=_SECONDS, in_arrays=evaluator.in_arrays)
        pending: deque[tuple[int, int, Any]] = deque()
        given = start
        while start < declared.fingers:
            ahead = _AHEAD * max(1, len(client.scheduler_info(n_workers=-1)["workers"]))
            while given < declared.fingers and len(pending) < ahead:
                stop = sizes.stop(given)
                task = client.submit(tile_on_worker, text, given, stop, versions, pure=False)
                pending.append((given, stop, task))
                given = stop
            tile = _result(*pending.popleft(), waiting)
            refuse_problems(tile)
            _refuse_other_kernel(tile, evaluator)
            sizes.measured(tile.stop - tile.start, tile.seconds)
            start = tile.stop
            yield tile


def _result(start: int, stop: int, task: Any, waiting: Callable[[], None]) -> TileResult:
    """Wait for a task."""
    from distributed import TimeoutError as DaskTimeoutError
    from distributed.scheduler import KilledWorker

    while True:
        try:
            found: TileResult = task.result(timeout=_POLL)
        except (DaskTimeoutError, TimeoutError):
            waiting()
        except KilledWorker as error:
            raise InputError(
                f"workers: several were lost while they evaluated fingers {start} to {stop - 1}, the last"
                f" {error.last_worker.address}; its log states why, for instance too little memory"
            ) from None
        else:
            return found


def _refuse_other_kernel(tile: TileResult, evaluator: Evaluator) -> None:
    if tile.kernel != evaluator.kernel:
        raise InputError(
            f"workers: one computes with kernel '{tile.kernel}', this process with '{evaluator.kernel}'; the results would"
            " not be the same to the last bit. Use workers with the same processor and the same versions"
        )


@contextmanager
def _client(workers: int | None, scheduler: str | None) -> Iterator[Any]:
    """Connect to a scheduler, or start a cluster on this machine for the time of the block."""
    if importlib.util.find_spec("distributed") is None:
        raise InputError(
            "workers, scheduler: need Dask, which is not installed: pip install 'electrovib[study]'"
        )
    import dask
    import distributed

    make_cluster: Any = distributed.LocalCluster

    class Client(distributed.Client):
        """A client that is closed by its ``with`` statement; one that met no scheduler would print a traceback at its end."""

        def __del__(self) -> None:
            """Do nothing."""

    make_client: Any = Client

    alone = {
        f"distributed.nanny.pre-spawn-environ.{name}_NUM_THREADS": 1 for name in ("NUMBA", "OMP", "OPENBLAS")
    }
    quiet = {"distributed.admin.large-graph-warning-threshold": "1GB"}
    with dask.config.set(alone | quiet):
        if workers is None:
            assert scheduler is not None
            with _connected(make_client, scheduler) as client:
                yield client
            return
        with (
            make_cluster(
                n_workers=workers,
                threads_per_worker=1,
                processes=True,
                host="127.0.0.1",
                dashboard_address=None,
                memory_limit=0,
                silence_logs=logging.CRITICAL,
            ) as cluster,
            make_client(cluster) as client,
        ):
            yield client


@contextmanager
def _connected(client: Any, scheduler: str) -> Iterator[Any]:
    try:
        found = client(scheduler, timeout=_CONNECT, set_as_default=False)
    except (OSError, ValueError, TypeError) as error:  # TypeError: encryption that is not set up
        raise InputError(
            f"scheduler = {scheduler}: no answer ({error}); expected the address that 'dask scheduler' prints, for instance"
            " tcp://10.0.0.1:8786"
        ) from None
    with found:
        if not found.scheduler_info(n_workers=-1)["workers"]:
            raise InputError(
                f"scheduler = {scheduler}: has no worker; start one with 'dask worker {scheduler}'"
            )
        yield found
