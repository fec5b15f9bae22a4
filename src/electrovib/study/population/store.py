"""The zarr store of a study: what it is, how far it has come, and its result."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.study.population.declared import BLOCK
from electrovib.study.population.folder import CHECKPOINT, COMPLETE, clear, remove_partial, written
from electrovib.study.population.origin import attributes
from electrovib.study.population.result import draws_of

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.study.population.result import StoredArray
    from electrovib.study.population.tile import Evaluator


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
            remove_partial(path)
            root: Any = (
                zarr.open_group(str(path), mode="r+")
                if (path / "zarr.json").exists()
                else zarr.create_group(str(path), attributes=attributes(evaluator))
            )
            self.root = root
            self.checkpoint: Any = root.require_group(CHECKPOINT)
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
        """Read the signals of the fingers in complete blocks.

        Parameters
        ----------
        name : str
            Signal.
        values : ndarray of float32, shape (fingers of the study, n)
            Receives them.
        """
        with written(self.path):
            for begin in range(0, self.stored, BLOCK):
                stop = min(begin + BLOCK, self.stored)
                values[begin:stop] = self.rows[name][begin:stop]

    def write_rows(self, name: str, start: int, values: NDArray[np.float32]) -> None:
        """Write the signals of consecutive fingers.

        Parameters
        ----------
        name : str
            Signal.
        start : int
            Index of the first finger, which begins a block.
        values : ndarray of float32, shape (fingers, n)
            Signals.
        """
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
            self.root.attrs[COMPLETE] = True
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
