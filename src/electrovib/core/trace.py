"""A result, computed or measured: an xarray.Dataset whose variables are named from the table of signals."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Any, TypeGuard

import numpy as np

from electrovib.core.signals import SIGNALS, signal

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    import xarray

FORMAT = "electrovib trace 1"
STUDY_FORMAT = "electrovib study"
"""Begin of the format of a study's result."""


def is_trace(source: object) -> TypeGuard[xarray.Dataset]:
    """Return whether an object is a Trace; False without an import of xarray, because no Trace exists then."""
    known = sys.modules.get("xarray")
    return known is not None and isinstance(source, known.Dataset)


def make_trace(
    variables: Mapping[str, tuple[Sequence[str], Any]],
    coordinates: Mapping[str, Any],
    attributes: Mapping[str, Any],
) -> xarray.Dataset:
    """Make a Trace, with ``units`` and ``long_name`` on every signal; structured attributes are JSON text."""
    import pandas as pd
    import xarray

    for name in variables:
        signal(name)
    # xarray imports dask and pint to look whether an array is one of theirs; it does not ask of an index, nor with `fastpath`
    coords = {
        name: ((name,), pd.Index(values, dtype=values.dtype) if _is(values, "fO") else values, _meaning(name))
        for name, values in coordinates.items()
    }
    return xarray.Dataset(
        {
            name: xarray.Variable(dims, data, _meaning(name), fastpath=_is(data, "biufc"))
            for name, (dims, data) in variables.items()
        },
        coords=coords,
        attrs={"format": FORMAT, **attributes},
    )


def _is(values: object, kinds: str) -> bool:
    """Return whether values are an array of numpy itself, of one of some kinds."""
    return type(values) is np.ndarray and values.dtype.kind in kinds


def stamp(trace: xarray.Dataset) -> xarray.Dataset:
    """Return a shallow copy of a Trace with units and meanings of its signals written again, after arithmetic for instance."""
    stamped = trace.copy()
    for name in stamped.variables:
        stamped[name].attrs.update(_meaning(str(name)))
    return stamped


def _meaning(name: str) -> dict[str, str]:
    """Return unit and meaning of a signal; empty for a name outside the nomenclature."""
    if name not in SIGNALS:
        return {}
    known = SIGNALS[name]
    return {"long_name": known.doc} if name == "layer" else {"units": known.unit, "long_name": known.doc}


def is_study_result(found: object) -> bool:
    """Return whether an object is the result of a study of a population: statistics of many fingers, which are no Trace."""
    return str(getattr(found, "attrs", {}).get("format", "")).startswith(STUDY_FORMAT)
