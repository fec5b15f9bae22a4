"""The zarr store of a study: what it is, how far it has come, and its result."""

from __future__ import annotations

import importlib.util
import json
import shutil
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.budget import megabytes
from electrovib.core.errors import DataFileError, InputError
from electrovib.core.units import unit_of_files
from electrovib.studies.population import files
from electrovib.studies.population.declared import BLOCK, FORMAT, DeclaredStudy
from electrovib.studies.population.result import attributes, definition, draws_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.studies.population.answer import StudyResult
    from electrovib.studies.population.tiles import Collected, Evaluator, Rows

SUFFIX: Final = ".zarr"
LOCK: Final = ".lock"
CHECKPOINT: Final = "checkpoint"
"""Folder of a store that holds what is needed to resume the study; absent once it is complete."""
SUMS: Final = f"{CHECKPOINT}/sums"
"""File of the moments, counts and histograms of the fingers that are complete."""
COMPLETE: Final = "complete"
"""Attribute of a store whose study is complete."""


class StudyStore:
    """Store of one study, which the caller has locked.

    Parameters
    ----------
    path : Path
        Folder of the store.
    evaluator : Evaluator
        The study.

    Notes
    -----
    zarr does not write chunks that equal the fill value, so chunks do not tell what is complete. The one file of the sums
    does: it holds the number of fingers that are complete, their sums, and the checksums of all files that this relies on,
    and is replaced as a whole. Signals of complete blocks are written before it, and never written again once it relies on
    them; those of the last, incomplete block stand in it. A process killed at any moment leaves the former state or the new one.
    """

    def __init__(self, path: Path, evaluator: Evaluator) -> None:
        self.path, self.declared = path, evaluator.declared
        self.done: dict[str, Any] = {"fingers": 0}
        with files.written(path):
            if not (path / files.METADATA).exists():
                files.write_group(path, attributes(evaluator))
            self.attributes = files.read_group(path)
            if (path / SUMS).exists():
                self.done, self._sums = files.read_sums(path / SUMS)
                files.refuse_damaged(path, self.done)
            (path / CHECKPOINT).mkdir(exist_ok=True)
            self._make_rows(evaluator)

    def _make_rows(self, evaluator: Evaluator) -> None:
        """Make the arrays of the signals of every finger: of the result, or until its end."""
        declared = self.declared
        self.place = "" if declared.records else f"{CHECKPOINT}/"
        self.rows: dict[str, Any] = {}
        self.tails: dict[str, Rows] = {}
        self.appended = self.done["fingers"]
        for name in declared.signals if declared.records or evaluator.held else ():
            self.tails[name] = np.empty((0, evaluator.samples), np.float32)
            place = self.path / self.place / name
            if self.appended:
                self.rows[name] = files.open_array(place, "r+")
                self.tails[name] = self._sums[f"{name}/tail"]
                continue
            dims, words = draws_of(name, declared.axis)
            shape = (declared.fingers, evaluator.samples)
            chunks = (min(BLOCK, shape[0]), shape[1])
            self.rows[name] = files.make_array(
                place, dims, words, shape=shape, dtype="float32", chunks=chunks
            )

    def restore(self, collected: Collected) -> None:
        """Continue from the fingers that are complete."""
        if not self.appended:
            return
        collected.fingers = self.appended
        for name, each in collected.statistics.items():
            part = f"{name}/"
            each.restore(
                {key.removeprefix(part): values for key, values in self._sums.items() if key.startswith(part)}
            )
        self._sums = {}
        for name, rows in collected.rows.items():
            whole = self.appended - len(self.tails[name])
            with files.rows_read(self.path / self.place / name):
                for begin in range(0, whole, BLOCK):
                    stop = min(begin + BLOCK, whole)
                    rows[begin:stop] = self.rows[name][begin:stop]
            rows[whole : self.appended] = self.tails[name]

    def append(self, rows: Mapping[str, Rows]) -> None:
        """Write the signals of the fingers that follow, and keep those of the block that is not complete.

        `rows` (fingers, n) for each signal.
        """
        for name, values in rows.items():
            start, tail, given = self.appended, self.tails[name], 0
            while given < len(values):
                part = values[given : given + BLOCK - len(tail)]
                given += len(part)
                tail = np.concatenate([tail, part])
                stop = start + given
                if len(tail) == BLOCK or stop == self.declared.fingers:
                    with files.written(self.path):
                        self.rows[name][stop - len(tail) : stop] = tail
                    tail = tail[:0]
            self.tails[name] = tail
        self.appended += len(next(iter(rows.values()), ()))

    def waiting(self, collected: Collected) -> int:
        """Return how many bytes of signals the next `commit` writes."""
        new = slice(self.appended, collected.fingers)
        return 0 if self.declared.records else sum(rows[new].nbytes for rows in collected.rows.values())

    def commit(self, collected: Collected) -> None:
        """Record that the first fingers are complete, with their sums."""
        if collected.fingers == self.done["fingers"]:
            return
        if not self.declared.records:
            new = slice(self.appended, collected.fingers)
            self.append({name: rows[new] for name, rows in collected.rows.items()})
            self.appended = collected.fingers
        sums = {f"{name}/tail": rows for name, rows in self.tails.items()}
        for name, each in collected.statistics.items():
            found = each.arrays()
            sums |= {f"{name}/{key}": values for key, values in found.items()}
        with files.written(self.path):
            places = [f"{self.place}{name}" for name in self.rows]
            done = {"fingers": collected.fingers, **files.stated(self.path, [files.METADATA], places)}
            files.write_sums(self.path / SUMS, done, sums)
        self.done = done

    def finish(self, arrays: xarray.Dataset) -> None:
        """Write the result, mark the study as complete, and remove what was needed to resume it."""
        with files.written(self.path):
            names = [str(name) for name in arrays.variables]
            for name in names:
                each = arrays[name].variable
                files.make_array(self.path / name, each.dims, each.attrs, data=each.values, chunks=each.shape)
            rows = self.rows if self.declared.records else ()
            files.write_group(
                self.path, self.attributes | {COMPLETE: True, **files.stated(self.path, names, rows)}
            )
            clear(self.path)


def clear(path: Path) -> None:
    """Remove what a complete study no longer needs, and files that a killed process was writing."""
    shutil.rmtree(path / CHECKPOINT, ignore_errors=True)
    for each in list(path.rglob(f"*{files.PARTIAL}")):
        with suppress(OSError):
            each.unlink()


def remove_unbegun(path: Path) -> None:
    """Remove what a new study wrote unless fingers of it are complete; the lock is that of the caller."""
    if (path / SUMS).exists():
        return
    for each in path.iterdir():
        if each.is_dir():
            shutil.rmtree(each, ignore_errors=True)
        elif not each.name.startswith(LOCK):
            each.unlink(missing_ok=True)


def state_of(path: Path, declared: DeclaredStudy) -> str:
    """Return the state of a store: ``absent``, ``begun`` or ``complete``."""
    if path.suffix.lower() != SUFFIX:
        raise InputError(
            f"a study is stored in a folder whose name ends in {SUFFIX}, such as '{path.with_suffix(SUFFIX)}'",
            path=path,
        )
    _require_zarr()
    with files.written(path):
        if not path.exists():
            return "absent"
        if not path.is_dir():
            raise InputError("is a file; a study is stored in a folder. Give another name.", path=path)
        files.refuse_irregular(path)
        if not (path / files.METADATA).exists():
            if all(
                each.name.startswith(LOCK) or each.name.endswith(files.PARTIAL) for each in path.iterdir()
            ):
                return "absent"
            raise InputError("exists already and is no study of electrovib; give another name.", path=path)
    found = _attributes(path)
    theirs = found["definition"]
    others = {name: value for name, value in definition(declared).items() if theirs.get(name) != value}
    differing = [f"its {name} is not the same" for name in ("scenario", "space") if others.pop(name, None)]
    differing += [
        f"{name} is {json.dumps(theirs.get(name))} there and {json.dumps(value)} here"
        for name, value in others.items()
    ]
    if differing:
        raise InputError(
            f"holds another study: {'; '.join(differing)}. Give another name, or remove that folder.",
            path=path,
        )
    return "complete" if found.get(COMPLETE) else "begun"


def refuse_other_method(path: Path, evaluator: Evaluator) -> None:
    """Refuse to continue a study that was begun with another version or method."""
    theirs, ours = files.read_group(path), attributes(evaluator)
    pairs = [(name, theirs.get(name), ours[name]) for name in ("method", "percentiles_from", "own_models")]
    pairs += [(name, theirs["versions"].get(name), each) for name, each in ours["versions"].items()]
    differing = [f"{name.replace('_', ' ')} '{was}', here '{now}'" for name, was, now in pairs if was != now]
    if differing:
        raise InputError(
            f"was begun with {'; with '.join(differing)}: an unfinished study continues only with the same, because its"
            " numbers have to be those of one computation. Continue it there, or give another name.",
            path=path,
        )


def refuse_full_disk(path: Path, evaluator: Evaluator) -> None:
    """Refuse a study whose kept signals exceed the free space of the disk."""
    declared = evaluator.declared
    needed = 4.0 * declared.fingers * evaluator.numbers if declared.records else 0.0
    folder = next((each for each in (path, *path.resolve().parents) if each.exists()), Path())
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise InputError(
            f"the signals of all fingers take {megabytes(needed)}, and {megabytes(free)} are free; omit --records, or draw"
            " fewer fingers",
            path=path,
        )


def open_study(path: str | Path) -> StudyResult:
    """Open the result of a study.

    Parameters
    ----------
    path : str or Path
        Folder of its store.

    Returns
    -------
    result : StudyResult
        As from `electrovib.study`; signals of every finger are read when they are used.

    Raises
    ------
    InputError
        If it is no study, not complete, or not as it was written: every file is compared with the checksum that the store
        states, and the signals of every finger when they are read.

    Examples
    --------
    >>> found = ev.study("bau_2010/sine", "fingers", n=5, seed=1, output="fingers.zarr")
    >>> ev.open_study("fingers.zarr").attrs["fingers"]
    5
    """
    from electrovib.studies.population.answer import StudyResult

    _require_zarr()
    place = Path(path)
    with files.written(place, "read"):
        if not (place / files.METADATA).exists():
            raise InputError(
                "is no study of electrovib; expected the folder that 'electrovib study' wrote", path=path
            )
    files.refuse_irregular(place)
    found = _attributes(place)
    if not found.pop(COMPLETE, False):
        raise InputError(
            f"is not complete; the command that began it continues it: electrovib study ... -n {found['fingers']}"
            f" --seed {found['seed']} -o {path}",
            path=path,
        )
    files.refuse_damaged(place, found)
    rows = {each.split("/")[0] for each in found["chunks"]}
    with files.written(place, "read"):
        arrays = {name: _stored(place / name, lazy=name in rows) for name in files.arrays_of(found)}
    del found["files"], found["chunks"]
    return StudyResult(arrays, attrs=found)


def _stored(place: Path, *, lazy: bool) -> tuple[Any, Any, Any]:
    array = files.open_array(place)
    values: Any = _rows_of(place) if lazy else np.asarray(array[:])
    about = dict(array.attrs)
    if "units" in about:
        about["units"] = unit_of_files(about["units"])
    return array.metadata.dimension_names, values, about


def _rows_of(place: Path) -> Any:
    """Return the signal of every finger, unread, for xarray; a damaged chunk is reported as one sentence when it is read."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class StoredRows(BackendArray):
        def __init__(self) -> None:
            self.array = files.open_array(place)
            self.shape, self.dtype = self.array.shape, self.array.dtype

        def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
            basic = indexing.IndexingSupport.BASIC
            return indexing.explicit_indexing_adapter(key, self.shape, basic, self._read)

        def _read(self, key: tuple[Any, ...]) -> Any:
            with files.rows_read(place):
                return self.array[key]

        def __reduce__(self) -> tuple[Any, ...]:
            return _array_of, (place,)

    return indexing.LazilyIndexedArray(StoredRows())


def _array_of(place: Path) -> Any:
    """Open the signal of every finger again, for another process."""
    return _rows_of(place).array


def _attributes(path: Path) -> dict[str, Any]:
    """Read what a store states of its study."""
    found = files.read_group(path)
    if found.get("format") != FORMAT:
        raise DataFileError("is no study of electrovib, or one of another version.", path=path)
    return found


def _require_zarr() -> None:
    if importlib.util.find_spec("zarr") is None:
        raise InputError(
            "a study is stored with zarr, which is not installed: pip install 'electrovib[study]'"
        )
