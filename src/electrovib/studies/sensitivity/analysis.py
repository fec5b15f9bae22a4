"""Sensitivity analysis of a quantity of a scenario."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.paths import quantity_at
from electrovib.scenario import Source, read_scenario
from electrovib.scenario.space import SpaceSource, read_space
from electrovib.scenario.space.counter import checked_seed
from electrovib.solve.meter import Meter, measured
from electrovib.solve.prepare import Prepared
from electrovib.solve.quantities import read_name
from electrovib.studies.elasticity import Elasticity, slope
from electrovib.studies.sensitivity.indices import Indices, check_power, sobol
from electrovib.studies.sensitivity.result import InputIndices, Sensitivity

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.scenario.space import Space

_HELD: Final = 8
"""Numbers that are held for each evaluation."""


@measured()
def sensitivity(
    scenario: Source,
    space: SpaceSource,
    *,
    quantity: str,
    n: int,
    seed: int,
    progress: Callable[[int, int], None] | None = None,
) -> Sensitivity:
    """Compute which parameters of a space a quantity depends on: Sobol indices with intervals, and local elasticities.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        Scenario with the values that stay fixed, as for `electrovib.load`.
    space : str, Path, mapping or Space
        Distributions of the others, as for `electrovib.read_space`: ``"fingers"``.
    quantity : str
        Name as for `electrovib.sweep`: ``"mean electrostatic_force"``.
    n : int
        Number of base draws, a power of 2; the scenario is evaluated n (inputs + 2) times.
    seed : int
        Seed of the draws, from 0 to 2**64 - 1.
    progress : callable, optional
        Function of the number of evaluations done and of all evaluations.

    Returns
    -------
    sensitivity : Sensitivity
        Indices, elasticities, the sample of the quantity, and ``answer``, which names what to measure first. `electrovib.save`
        writes it into a folder, as ``report.html``, ``indices.csv``, ``elasticities.csv`` and ``space.toml``.

    Raises
    ------
    InputError
        For every mistake in scenario, space and quantity.
    """
    base = read_scenario(scenario)
    found = read_space(base, space)
    named = read_name(" ".join(quantity.split()), tuple(base.stack.layers))
    seed = checked_seed(seed)
    check_power(n)
    prepared = Prepared(base, free=found.paths, quantities=[named.name])
    count = n * (len(found.inputs) + 2)
    meter = Meter.of_cases(
        "this sensitivity analysis",
        f"{count} evaluations",
        count,
        numbers=_HELD,
        remedy="choose a smaller n",
    )
    report = meter.reporting(progress)
    indices = sobol(found, lambda draws: prepared(draws, progress=report)[named.name], n=n, seed=seed)
    return Sensitivity(
        scenario=base,
        space=found,
        quantity=named.name,
        unit=named.unit,
        n=n,
        seed=seed,
        method=prepared.method,
        indices=_ordered(found, indices),
        elasticities=tuple(_elasticities(prepared, found, named.name)),
        sample=indices.sample,
    )


def _ordered(space: Space, indices: Indices) -> tuple[InputIndices, ...]:
    found = [
        InputIndices(
            name=name,
            paths=tuple(each for each in streams if each in space.paths),
            first=float(indices.first[i]),
            first_interval=(float(indices.first_interval[0, i]), float(indices.first_interval[1, i])),
            total=float(indices.total[i]),
            total_interval=(float(indices.total_interval[0, i]), float(indices.total_interval[1, i])),
        )
        for i, (name, streams) in enumerate(space.inputs.items())
    ]
    return tuple(sorted(found, key=lambda each: -each.total))


def _elasticities(prepared: Prepared, space: Space, quantity: str) -> list[Elasticity]:
    """Differentiate the quantity at the medians."""
    middle = space.values({stream: np.array([0.5]) for stream in space.streams})
    medians = {path: float(value[0]) for path, value in middle.items()}
    at = float(prepared(medians)[quantity])
    return [
        Elasticity(
            path=path,
            at=value,
            unit=quantity_at(prepared.base, path).unit,
            value=slope(lambda point: float(prepared(point)[quantity]), medians, path) / at
            if at
            else math.nan,
        )
        for path, value in medians.items()
    ]
