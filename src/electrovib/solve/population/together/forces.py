"""Attraction and friction of many fingers, by the text of the force law and of the friction law."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.solution import TRANSIENT, Solution
from electrovib.solve.mechanics.mechanical import FrictionChain
from electrovib.solve.population.together.tile import write_sum

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.population.together.tile import FingerTile
    from electrovib.solve.population.together.transfers import Transfers


class QuadraticForce(NamedTuple):
    """The attraction of fingers as a factor times the square of a linear quantity.

    Parameters
    ----------
    base : Transfers
        The quantity, per volt.
    factor : ndarray, shape (rows,)
        Factor of each finger, in N over the unit of the quantity squared.
    """

    base: Transfers
    factor: Real


def quadratic_force(scenario: Scenario, rows: int, asked: Mapping[str, Transfers]) -> QuadraticForce | None:
    """Return the attraction of a quadratic law as a factor times the square of one linear quantity."""
    bases = {id(each.base or each): each.base or each for each in asked.values()}
    if len(bases) != 1:
        return None
    (base,) = bases.values()
    shares = {
        name: np.broadcast_to(1.0 if each.base is None else each.share, rows)[:, None]
        for name, each in asked.items()
    }
    factor = attraction(scenario, total_pull(scenario, shares))
    return QuadraticForce(base, np.ascontiguousarray(np.broadcast_to(factor, (rows, 1))[:, 0]))


def write_forces(rows: Real, tile: FingerTile, time: Real, *, quadratic: bool) -> None:
    """Write the attraction of fingers.

    `rows` (fingers, n) [N], `time` (n,) [s].
    """
    asked = tile.scenario.force.amplitudes(tile.section)
    square = quadratic_force(tile.scenario, tile.rows, asked) if quadratic else None
    if square is not None:
        responses = tile.responses(square.base)
        for some in tile.parts():
            write_sum(rows[some], responses, some, factor=square.factor)
        return
    each = {name: tile.responses(transfers) for name, transfers in asked.items()}
    for some in tile.parts():
        values = {name: np.empty(rows[some].shape) for name in each}
        for name, responses in each.items():
            write_sum(values[name], responses, some)
        member = tile.some(some)
        rows[some] = attraction(member, total_pull(member, values), time)


def write_friction(rows: Real, force: Real, tile: FingerTile, time: Real) -> None:
    """Write the friction of fingers without memory.

    `rows` (fingers, n) [N], `force` (fingers, n) [N], `time` (n,) [s].
    """
    for some in tile.parts():
        solution = Solution(found={}, method=TRANSIENT, reason="", force=force[some])
        chain = FrictionChain(tile.some(some), time, solution, lambda _, found=solution: found)  # type: ignore[misc]
        rows[some] = chain.known(chain.steady(time, force[some]))
