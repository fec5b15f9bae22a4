"""The signals of every finger in a complete store, which are read when they are used."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from electrovib.study.population.groups import open_array, rows_read

if TYPE_CHECKING:
    from pathlib import Path


def rows_of(place: Path) -> Any:
    """Return the signal of every finger, unread, for xarray; a damaged chunk is reported as one sentence when it is read."""
    from xarray.backends import BackendArray
    from xarray.core import indexing

    class StoredRows(BackendArray):
        def __init__(self) -> None:
            self.array = open_array(place)
            self.shape, self.dtype = self.array.shape, self.array.dtype

        def __getitem__(self, key: indexing.ExplicitIndexer) -> Any:
            basic = indexing.IndexingSupport.BASIC
            return indexing.explicit_indexing_adapter(key, self.shape, basic, self._read)

        def _read(self, key: tuple[Any, ...]) -> Any:
            with rows_read(place):
                return self.array[key]

        def __reduce__(self) -> tuple[Any, ...]:
            return _array_of, (place,)

    return indexing.LazilyIndexedArray(StoredRows())


def _array_of(place: Path) -> Any:
    """Open the signal of every finger again, for another process."""
    return rows_of(place).array
