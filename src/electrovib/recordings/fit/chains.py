"""The chains of a posterior distribution as a dataset."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    import xarray

    from electrovib.recordings.fit.posterior import Posterior


def chains_of(posterior: Posterior, units: Mapping[str, str]) -> xarray.Dataset:
    """Return the chains of a posterior distribution over ``parameter``, ``step`` and ``chain``, with their diagnostics."""
    import xarray

    names = list(posterior.chains)
    return xarray.Dataset(
        {
            "value": (("parameter", "step", "chain"), np.stack([posterior.chains[name] for name in names])),
            "log_density": (("step", "chain"), posterior.log_density),
            "autocorrelation_time": ("parameter", [posterior.autocorrelation_time[name] for name in names]),
        },
        coords={"parameter": names, "unit": ("parameter", [units[name] for name in names])},
        attrs={
            "title": "samples of a posterior distribution",
            "burn_in": posterior.burn_in,
            "acceptance": posterior.acceptance,
            "seed": posterior.seed,
            "problems": json.dumps(list(posterior.problems)),
        },
    )
