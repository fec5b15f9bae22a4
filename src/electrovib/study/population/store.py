"""The zarr store of a study: what it is, how far it has come, and its result."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.study.population.declared import BLOCK
from electrovib.study.population.folder import CHECKPOINT, COMPLETE, clear, written
from electrovib.study.population.groups import (
    METADATA,
    arrays_of,
    open_array,
    read_group,
    refuse_damaged,
    rows_read,
    stated,
    write_group,
)
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
    zarr does not write chunks that equal the fill value, so chunks do not tell what is complete. The group ``checkpoint``
    does: its attributes hold the number of fingers that are complete, the slot that holds their sums, and the checksums of
    all files that this relies on. The sums are written into the other slot first; replacing the one file of the group makes
    them valid. A process killed at any moment leaves the former state or the new one.
    """

    def __init__(self, path: Path, evaluator: Evaluator) -> None:
        self.path, self.declared, self.evaluator = path, evaluator.declared, evaluator
        self.checkpoint = path / CHECKPOINT
        with written(path):
            if not (path / METADATA).exists():
                write_group(path, attributes(evaluator))
            self.attributes = read_group(path)
            done: dict[str, Any] = {"slot": 0, "fingers": 0, "files": {}}
            if (self.checkpoint / METADATA).exists():
                done = read_group(self.checkpoint)
                refuse_damaged(path, done)
            self.slot, self.fingers = done["slot"], done["fingers"]
            self.sums = arrays_of(done, f"{CHECKPOINT}/slot{self.slot}")
            self._make_rows()
        self.stored = self._whole(self.fingers)

    def _make_rows(self) -> None:
        """Make the arrays of the signals of every finger where they are kept: of the result, or until its end."""
        declared = self.declared
        self.rows: dict[str, Any] = {}
        self.kept_in = "" if declared.draws else f"{CHECKPOINT}/"
        for name in declared.signals if self.evaluator.kept else ():
            place = self.path / self.kept_in / name
            if self.fingers:
                self.rows[name] = open_array(place, "r+")
                continue
            dims, words = draws_of(name, declared.axis)
            shape = (declared.fingers, self.evaluator.samples)
            chunks = (min(BLOCK, shape[0]), shape[1])
            self.rows[name] = _array(place, dims, words, shape=shape, dtype="float32", chunks=chunks)

    def _whole(self, fingers: int) -> int:
        return fingers if fingers == self.declared.fingers else fingers - fingers % BLOCK

    def restored(self) -> tuple[int, dict[str, NDArray[Any]]]:
        """Return the number of fingers that are complete, and the arrays of their sums."""
        if not self.fingers:
            return 0, {}
        with written(self.path, "read"):
            slot = self.checkpoint / f"slot{self.slot}"
            return self.fingers, {name: np.asarray(open_array(slot / name)[:]) for name in self.sums}

    def restore_rows(self, name: str, values: NDArray[np.float32]) -> None:
        """Read the signals of the fingers in complete blocks.

        `values` (fingers of the study, n).
        """
        with rows_read(self.path / self.kept_in / name):
            for begin in range(0, self.stored, BLOCK):
                stop = min(begin + BLOCK, self.stored)
                values[begin:stop] = self.rows[name][begin:stop]

    def write_rows(self, name: str, start: int, values: NDArray[np.float32]) -> None:
        """Write the signals of consecutive fingers.

        `values` (fingers, n).
        """
        with written(self.path):
            for begin in range(0, len(values), BLOCK):
                part = values[begin : begin + BLOCK]
                self.rows[name][start + begin : start + begin + len(part)] = part

    def commit(self, fingers: int, state: Mapping[str, NDArray[Any]]) -> None:
        """Record that the first fingers are complete, with their sums."""
        other = 1 - self.slot
        slot = f"{CHECKPOINT}/slot{other}"
        with written(self.path):
            shutil.rmtree(self.path / slot, ignore_errors=True)
            for name, values in state.items():
                if values.size:
                    _array(self.path / slot / name, None, {}, data=values, chunks=values.shape)
            rows = [f"{self.kept_in}{name}" for name in self.rows]
            done = {"slot": other, "fingers": fingers, **stated(self.path, [METADATA, slot], rows)}
            write_group(self.checkpoint, done)
        self.slot, self.fingers, self.stored = other, fingers, self._whole(fingers)

    def finish(self, arrays: Mapping[str, StoredArray]) -> None:
        """Write the result, mark the study as complete, and remove what was needed to resume it."""
        with written(self.path):
            for name, each in arrays.items():
                _array(
                    self.path / name, each.dims, each.attributes, data=each.values, chunks=each.values.shape
                )
            rows = self.rows if self.declared.draws else ()
            write_group(self.path, self.attributes | {COMPLETE: True, **stated(self.path, arrays, rows)})
            clear(self.path)


def _array(place: Path, dims: tuple[str, ...] | None, words: dict[str, Any], **how: Any) -> Any:
    """Make an array, replacing one that was left incomplete; the signals of fingers end with a checksum in each chunk."""
    import zarr
    from zarr.codecs import Crc32cCodec

    return zarr.create_array(
        str(place),
        dimension_names=dims,
        attributes=words,
        compressors=[Crc32cCodec()] if how.get("dtype") == "float32" else "auto",
        config={"write_empty_chunks": True},
        overwrite=True,
        **how,
    )
