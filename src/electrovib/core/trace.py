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
    from xarray import Dataset, Variable

    # xarray imports dask and pint to see whether an array is one of theirs; of an index, and with `fastpath`, it does not ask
    coords = {}
    for name, values in coordinates.items():
        plain = type(values) is np.ndarray
        coords[name] = (name,), pd.Index(values, dtype=values.dtype) if plain else values, _meaning(name)
    found = {}
    for name, (dims, data) in variables.items():
        signal(name)
        found[name] = Variable(dims, data, _meaning(name), fastpath=type(data) is np.ndarray)
    return Dataset(found, coords=coords, attrs={"format": FORMAT, **attributes})


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
