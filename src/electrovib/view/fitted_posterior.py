"""The posterior distribution of a fit: its table on the page, its chains as netCDF."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.data.marks import WRITTEN_BY, Form, unsigned
from electrovib.study.reproduction import Table
from electrovib.view.units import pretty_quantity

if TYPE_CHECKING:
    from collections.abc import Sequence

    from electrovib.recordings.fit.posterior import Posterior
    from electrovib.recordings.interval import EstimatedParameter

EMCEE: Final = (
    "D. Foreman-Mackey, D. W. Hogg, D. Lang, J. Goodman, emcee: The MCMC Hammer,"
    " Publ. Astron. Soc. Pac. 125, 306 (2013)"
)


def posterior_table(posterior: Posterior, rows: Sequence[EstimatedParameter]) -> Table:
    """Make the table of a posterior distribution, with its diagnostics of convergence."""
    known = {row.name: row for row in rows}
    shown = []
    for name, samples in posterior.samples.items():
        row = known[name]
        median, lower, upper = (
            pretty_quantity(float(each), row.unit, digits=row.digits)
            for each in (np.median(samples), *posterior.interval(name))
        )
        time = f"{posterior.autocorrelation_time[name]:.3g}"
        shown.append((name, median, f"{lower} to {upper}", time))
    first = next(iter(posterior.chains.values()))
    caption = (
        f"{first.shape[1]} chains of {posterior.steps} steps, the first {posterior.burn_in} omitted; seed {posterior.seed};"
        f" {100 * posterior.acceptance:.0f} % of the proposals accepted. "
    )
    caption += (
        f"The samples may not represent the distribution: {'; '.join(posterior.problems)}."
        if posterior.problems
        else "The diagnostics of convergence raise no objection."
    )
    headings = ("Parameter", "Median", "95 % interval", "Autocorrelation time in steps")
    return Table("Posterior distribution", headings, tuple(shown), caption=caption)


def chains_bytes(posterior: Posterior, rows: Sequence[EstimatedParameter]) -> bytes:
    """Return the chains of a posterior distribution as a netCDF file, with the mark by which a later fit may replace it."""
    from electrovib.data.traces.netcdf import in_memory
    from electrovib.recordings.fit.posterior import chains_of

    chains = chains_of(posterior, {row.name: row.unit for row in rows})
    chains.attrs = {WRITTEN_BY: unsigned(Form.NETCDF)} | chains.attrs
    return in_memory(chains, {}).getvalue()
