"""Results of studies that are opened from their stores."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.errors import DataFileError, InputError
from electrovib.study.population.declared import FORMAT
from electrovib.study.population.folder import COMPLETE, require_zarr, written
from electrovib.study.population.groups import (
    METADATA,
    arrays_of,
    open_array,
    read_group,
    refuse_damaged,
    refuse_irregular,
)
from electrovib.study.population.result import StoredArray, dataset

if TYPE_CHECKING:
    import xarray


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
        If it is no study, not complete, or not as it was written: every file is compared with the checksum that the store
        states, and the signals of every finger when they are read.
    """
    require_zarr()
    place = Path(path)
    with written(place, "read"):
        if not (place / METADATA).exists():
            raise InputError(
                "is no study of electrovib; expected the folder that 'electrovib study' wrote", path=path
            )
    refuse_irregular(place)
    found = study_attributes(place)
    if not found.pop(COMPLETE, False):
        raise InputError(
            f"is not complete; the command that began it continues it: electrovib study ... -n {found['fingers']}"
            f" --seed {found['seed']} -o {path}",
            path=path,
        )
    refuse_damaged(place, found)
    rows = {each.split("/")[0] for each in found["chunks"]}
    with written(place, "read"):
        arrays = {name: _stored(place / name, lazy=name in rows) for name in arrays_of(found, ".")}
    del found["files"], found["chunks"]
    return dataset(arrays, found)


def _stored(place: Path, *, lazy: bool) -> StoredArray:
    from electrovib.study.population.rows import rows_of

    array = open_array(place)
    values: Any = rows_of(place) if lazy else np.asarray(array[:])
    return StoredArray(array.metadata.dimension_names, values, dict(array.attrs))


def study_attributes(path: Path) -> dict[str, Any]:
    """Read what a store states of its study."""
    found = read_group(path)
    if found.get("format") != FORMAT:
        raise DataFileError("is no study of electrovib, or one of another version.", path=path)
    return found
