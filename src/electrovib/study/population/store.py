"""The zarr store of a study: what it is, how far it has come, and its result."""

from __future__ import annotations

import hashlib
import importlib.util
import json
import shutil
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.allowance import megabytes
from electrovib.core.errors import DataFileError, InputError
from electrovib.study.population.declared import BLOCK, FORMAT
from electrovib.study.population.lock import NAME as LOCK
from electrovib.study.population.result import draws_of
from electrovib.study.population.tile import computing_versions

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    import xarray
    from numpy.typing import NDArray

    from electrovib.study.population.declared import DeclaredStudy
    from electrovib.study.population.result import StoredArray
    from electrovib.study.population.tile import Evaluator

SUFFIX: Final = ".zarr"
_CHECKPOINT: Final = "checkpoint"
_PARTIAL: Final = ".partial"
_COMPLETE: Final = "complete"
_SAME: Final = "an unfinished study continues only with the same, because its numbers have to be the same to the last bit"


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
    zarr does not write chunks that equal the fill value, so chunks do not tell what is complete. The array
    ``checkpoint/done`` does: the number of fingers that are complete, and the slot that holds their sums. The sums are
    written into the other slot first; replacing the one file of ``done`` makes them valid. A process killed at any
    moment leaves the former state or the new one.
    """

    def __init__(self, path: Path, evaluator: Evaluator) -> None:
        import zarr

        self.path, self.declared, self.evaluator = path, evaluator.declared, evaluator
        with written(path):
            _remove_partial(path)
            root: Any = (
                zarr.open_group(str(path), mode="r+")
                if (path / "zarr.json").exists()
                else zarr.create_group(str(path), attributes=attributes(evaluator))
            )
            self.root = root
            self.checkpoint: Any = root.require_group(_CHECKPOINT)
            done = self.checkpoint["done"][:].tolist() if "done" in self.checkpoint else [0, 0]
            self.slot, self.fingers = int(done[0]), int(done[1])
            self._make_rows()
        self.stored = self._whole(self.fingers)

    def _make_rows(self) -> None:
        """Make the arrays of the signals of every finger where they are kept: of the result, or until its end."""
        declared = self.declared
        self.rows: dict[str, Any] = {}
        if not self.evaluator.kept:
            return
        group = self.root if declared.draws else self.checkpoint
        for name in declared.signals:
            if name not in group:
                dims, words = draws_of(name, declared.axis)
                shape = (declared.fingers, self.evaluator.samples)
                _array(
                    group,
                    name,
                    dims,
                    words,
                    shape=shape,
                    dtype="float32",
                    chunks=(min(BLOCK, shape[0]), shape[1]),
                )
            self.rows[name] = group[name]

    def _whole(self, fingers: int) -> int:
        return fingers if fingers == self.declared.fingers else fingers - fingers % BLOCK

    def restored(self) -> tuple[int, dict[str, NDArray[Any]]]:
        """Return the number of fingers that are complete, and the arrays of their sums."""
        if not self.fingers:
            return 0, {}
        with written(self.path):
            slot = self.checkpoint[f"slot{self.slot}"]
            return self.fingers, {name: np.asarray(each[:]) for name, each in slot.arrays()}

    def restore_rows(self, name: str, values: NDArray[np.float32]) -> None:
        """Read the signals of the fingers in complete blocks into an array of all fingers."""
        with written(self.path):
            for begin in range(0, self.stored, BLOCK):
                stop = min(begin + BLOCK, self.stored)
                values[begin:stop] = self.rows[name][begin:stop]

    def write_rows(self, name: str, start: int, values: NDArray[np.float32]) -> None:
        """Write the signals of consecutive fingers, the first of which begins a block."""
        with written(self.path):
            for begin in range(0, len(values), BLOCK):
                part = values[begin : begin + BLOCK]
                self.rows[name][start + begin : start + begin + len(part)] = part

    def commit(self, fingers: int, state: Mapping[str, NDArray[Any]]) -> None:
        """Record that the first fingers are complete, with their sums.

        Parameters
        ----------
        fingers : int
            Number of fingers; the signals of all complete blocks have been written where they are kept.
        state : mapping of str to ndarray
            Their sums.
        """
        other = 1 - self.slot
        with written(self.path):
            slot = self.checkpoint.create_group(f"slot{other}", overwrite=True)
            for name, values in state.items():
                if values.size:
                    _array(slot, name, None, {}, data=values, chunks=values.shape)
            if "done" not in self.checkpoint:
                _array(self.checkpoint, "done", None, {}, shape=(2,), dtype="int64", chunks=(2,))
            self.checkpoint["done"][:] = np.asarray([other, fingers])
        self.slot, self.fingers, self.stored = other, fingers, self._whole(fingers)

    def finish(self, arrays: Mapping[str, StoredArray]) -> None:
        """Write the result, mark the study as complete, and remove what was needed to resume it."""
        with written(self.path):
            for name, each in arrays.items():
                _array(
                    self.root, name, each.dims, each.attributes, data=each.values, chunks=each.values.shape
                )
            self.root.attrs[_COMPLETE] = True
            clear(self.path)


def _array(group: Any, name: str, dims: tuple[str, ...] | None, words: dict[str, str], **how: Any) -> None:
    """Make an array, replacing one that was left incomplete."""
    group.create_array(
        name,
        dimension_names=dims,
        attributes=words,
        compressors=None if how.get("dtype") == "float32" else "auto",
        config={"write_empty_chunks": True},
        overwrite=True,
        **how,
    )


def attributes(evaluator: Evaluator) -> dict[str, Any]:
    """Return what a result states about its origin: scenario, space, seed, versions, kernel and methods."""
    from electrovib.study.population.result import BINNED, EXACT
    from electrovib.study.population.texts import own_model_files, scenario_text

    declared = evaluator.declared
    return {
        "format": FORMAT,
        "title": declared.scenario.title,
        "fingers": declared.fingers,
        "seed": declared.seed,
        "signals": list(declared.signals),
        "definition": _definition(declared),
        "method": evaluator.method,
        "kernel": evaluator.kernel,
        "percentiles_from": EXACT if evaluator.exact else BINNED,
        "versions": computing_versions(),
        "scenario": declared.scenario.to_json(),
        "scenario_toml": scenario_text(declared.scenario),
        "space_toml": declared.space.to_toml(),
        "space_remarks": list(declared.space.remarks),
        "own_models": own_model_files(declared.scenario),
    }


def _definition(declared: DeclaredStudy) -> dict[str, Any]:
    """Return what distinguishes a study from others; long texts as their SHA-256."""
    found = declared.identity()
    return found | {name: hashlib.sha256(found[name].encode()).hexdigest() for name in ("scenario", "space")}


def state_of(path: Path, declared: DeclaredStudy) -> str:
    """Return the state of a store: ``absent``, ``begun`` or ``complete``.

    Parameters
    ----------
    path : Path
        Folder of the store, which may not exist.
    declared : DeclaredStudy
        Study that is to be run.

    Returns
    -------
    state : str
        Of the store.

    Raises
    ------
    InputError
        If the name is not that of a store, something else is there, or the study of another definition.
    """
    if path.suffix.lower() != SUFFIX:
        raise InputError(
            f"a study is stored in a folder whose name ends in {SUFFIX}, not in '{path.suffix}'", path=path
        )
    require_zarr()
    with written(path):
        if not path.exists():
            return "absent"
        if not path.is_dir():
            raise InputError("is a file; a study is stored in a folder. Give another name.", path=path)
        if not (path / "zarr.json").exists():
            if all(each.name == LOCK or each.name.endswith(_PARTIAL) for each in path.iterdir()):
                return "absent"
            raise InputError("exists already and is no study of electrovib; give another name.", path=path)
    found = _attributes(path)
    if found.get("format") != FORMAT:
        raise InputError("exists already and is no study of electrovib; give another name.", path=path)
    ours, theirs = _definition(declared), dict(found.get("definition", {}))
    differing = [
        _difference(name, theirs.get(name), value)
        for name, value in ours.items()
        if theirs.get(name) != value
    ]
    if differing:
        raise InputError(
            f"holds another study: {'; '.join(differing)}. Give another name, or remove that folder.",
            path=path,
        )
    return "complete" if found.get(_COMPLETE) else "begun"


def _difference(name: str, theirs: Any, ours: Any) -> str:
    if name in {"scenario", "space"}:
        return f"its {name} is not the same"
    return f"{name} is {json.dumps(theirs)} there and {json.dumps(ours)} here"


def refuse_other_kernel(path: Path, evaluator: Evaluator) -> None:
    """Refuse to continue a study that was begun with another kernel, version or method.

    Raises
    ------
    InputError
        With what differs.
    """
    theirs, ours = _attributes(path), attributes(evaluator)
    pairs = [
        (name, theirs.get(name), ours[name])
        for name in ("kernel", "method", "percentiles_from", "own_models")
    ]
    versions = dict(theirs.get("versions", {}))
    pairs += [(name, versions.get(name), each) for name, each in ours["versions"].items()]
    differing = [f"{name.replace('_', ' ')} '{was}', here '{now}'" for name, was, now in pairs if was != now]
    if differing:
        raise InputError(
            f"was begun with {'; with '.join(differing)}: {_SAME}. Continue it there, or give another name.",
            path=path,
        )


def refuse_full_disk(path: Path, evaluator: Evaluator) -> None:
    """Refuse a study whose kept signals exceed the free space of the disk.

    Raises
    ------
    InputError
        With both amounts.
    """
    declared = evaluator.declared
    needed = 4.0 * declared.fingers * evaluator.numbers if declared.draws else 0.0
    folder = next((each for each in (path, *path.resolve().parents) if each.exists()), Path())
    free = shutil.disk_usage(folder).free
    if needed > free:
        raise InputError(
            f"the signals of all fingers take {megabytes(needed)}, and {megabytes(free)} are free; omit --draws, or draw"
            " fewer fingers",
            path=path,
        )


def open_study(path: str | Path) -> xarray.Dataset:
    """Open the result of a study.

    Parameters
    ----------
    path : str or Path
        Folder of its store.

    Returns
    -------
    result : xarray.Dataset
        As from `electrovib.study`; signals of every finger are read when they are used.

    Raises
    ------
    InputError
        If it is no study, or not complete.
    """
    import xarray

    require_zarr()
    place = Path(path)
    if not is_study(place):
        raise InputError(
            "is no study of electrovib; expected the folder that 'electrovib study' wrote", path=path
        )
    found = _attributes(place)
    if not found.get(_COMPLETE):
        raise InputError(
            f"is not complete; the command that began it continues it: electrovib study ... -n {found.get('fingers')}"
            f" --seed {found.get('seed')} -o {path}",
            path=path,
        )
    with written(place, "read"):
        result = xarray.open_dataset(str(place), engine="zarr", chunks=None, consolidated=False)
        result.attrs.pop(_COMPLETE, None)
        return result


def is_study(path: str | Path) -> bool:
    """Return whether a folder is the store of a study, complete or not."""
    place = Path(path) / "zarr.json"
    try:
        return bool(json.loads(place.read_bytes()).get("attributes", {}).get("format") == FORMAT)
    except (OSError, ValueError, AttributeError):
        return False


def _attributes(path: Path) -> dict[str, Any]:
    try:
        found = json.loads((path / "zarr.json").read_bytes())["attributes"]
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise DataFileError(f"is damaged: {error}", path=path) from None
    return dict(found)


def clear(path: Path) -> None:
    """Remove what a complete study no longer needs."""
    shutil.rmtree(path / _CHECKPOINT, ignore_errors=True)
    _remove_partial(path)


def _remove_partial(path: Path) -> None:
    """Remove the files that a killed process was writing."""
    for each in list(path.rglob(f"*{_PARTIAL}")):
        with suppress(OSError):
            each.unlink()


@contextmanager
def written(path: Path, how: str = "written") -> Iterator[None]:
    """Report an error of the file system as one sentence.

    Parameters
    ----------
    path : Path
        Folder of the store.
    how : str
        ``written`` or ``read``.

    Yields
    ------
    None
        Within the block.

    Raises
    ------
    InputError
        Instead of an OSError.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise InputError(
            f"cannot be {how}: {reason}. What was stored before is kept: remedy this, and the same command continues.",
            path=path,
        ) from error


def require_zarr() -> None:
    """Refuse to go on without zarr.

    Raises
    ------
    InputError
        With the line that installs it.
    """
    if importlib.util.find_spec("zarr") is None:
        raise InputError(
            "a study is stored with zarr, which is not installed: pip install 'electrovib[study]'"
        )
