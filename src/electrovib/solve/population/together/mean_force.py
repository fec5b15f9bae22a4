"""Mean force of sines on many fingers, from the modes of stacks whose materials are sums of Debye terms."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.solve.population.kernels import mean_square_over_frequency
from electrovib.solve.population.together.forces import quadratic_force
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.section import ManySection

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario


def has_modal_mean_force(scenario: Scenario) -> bool:
    """Return whether the modes of a stack give its mean force exactly: every material is a sum of Debye terms."""
    exact = all(layer.material.debye() is not None for layer in scenario.stack.layers.values())
    return exact and scenario.force.causal


def modal_mean_force(
    scenario: Scenario,
    columns: Mapping[str, Real],
    frequency: Real,
    *,
    rows: int,
    amplitude: Any,
) -> tuple[Real, NDArray[np.bool_]]:
    """Compute the time mean of the attraction under one sine.

    `frequency` (n,) [Hz], `amplitude` (rows, 1) [V]; returns `force` (rows, n) [N], `regular` (rows,).
    """
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # fingers of another form
        section = ManySection(scenario, tuple(columns), {}, rows)
    square = quadratic_force(scenario, rows, scenario.force.amplitudes(section))
    if square is None or np.any(square.base.slope):
        raise NotTogetherError("the force is not the square of one sum of modes")
    regular, base = section.modes.regular, square.base
    factor = square.factor * np.broadcast_to(amplitude, (rows, 1))[:, 0] ** 2
    rates, residues = (np.where(regular, each, 1.0).T for each in (base.rates, base.residues))
    direct = np.where(regular, np.broadcast_to(base.direct, rows), 1.0)
    force = mean_square_over_frequency(rates, residues, direct, frequency, factor=factor)
    return force, regular
