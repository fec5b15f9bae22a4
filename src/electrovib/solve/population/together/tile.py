"""Fingers whose arrays are in memory together, and their responses to the drive."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.solve.population.together.arrays import stored_columns, with_columns
from electrovib.solve.population.together.response import Response
from electrovib.solve.population.together.section import ManySection

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.population.together.amplitude import SharedDrive
    from electrovib.solve.population.together.reduced import SharedReduction
    from electrovib.solve.population.together.transfers import Transfers

RESPONSES: Final = 64
"""Fingers whose responses are in memory together."""
FEWEST: Final = 8
"""Fewest rows of an array: numpy forms sums over modes row by row only for two fingers or more."""


def padded(scenario: Scenario, draws: Mapping[str, Real]) -> tuple[dict[str, Real], int]:
    """Return the values of fingers as columns of at least `FEWEST` rows, of which the last repeat the last finger."""
    columns = stored_columns(scenario, draws)
    fingers = len(next(iter(columns.values())))
    if fingers < FEWEST:
        more = ((0, FEWEST - fingers), (0, 0))
        columns = {path: np.pad(column, more, "edge") for path, column in columns.items()}
    return columns, fingers


def of_scenario(columns: Mapping[str, Real]) -> dict[str, Real]:
    """Return the columns [SI units] that are put into the scenario: all but those of the drive."""
    return {path: column for path, column in columns.items() if not path.startswith("drive.")}


class FingerTile(NamedTuple):
    """Fingers in arrays.

    Parameters
    ----------
    base, scenario : Scenario
        Values that all fingers share; the same with columns.
    section : ManySection
        Their stacks.
    columns : dict of str to ndarray, shape (rows, 1)
        Values of the free parameters by stored path.
    fingers : int
        Number of fingers; further rows repeat the last one.
    drive : SharedDrive
        Drive as a function of its free parameters.
    settled : dict of (int, int) to ndarray
        States in the periodic state that are known, by the identities of rates and pieces.
    """

    base: Scenario
    scenario: Scenario
    section: ManySection
    columns: dict[str, Real]
    fingers: int
    drive: SharedDrive
    settled: dict[tuple[int, int], Real]

    @classmethod
    def of(
        cls,
        base: Scenario,
        draws: Mapping[str, Real],
        reduced: Mapping[str, SharedReduction],
        drive: SharedDrive,
    ) -> FingerTile:
        """Expand the stacks of fingers in relaxation modes."""
        columns, fingers = padded(base, draws)
        inner = of_scenario(columns)
        scenario = with_columns(base, inner)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # fingers of another form
            section = ManySection(scenario, tuple(inner), reduced, max(fingers, FEWEST))
        return cls(base, scenario, section, columns, fingers, drive, {})

    @property
    def rows(self) -> int:
        """Number of rows of the arrays."""
        return len(self.section.modes.regular)

    def some(self, part: slice) -> Scenario:
        """Return the scenario with the columns of a range of fingers."""
        inner = of_scenario(self.columns)
        return with_columns(self.base, {path: column[part] for path, column in inner.items()})

    def parts(self) -> list[slice]:
        """Return ranges of fingers whose responses are in memory together."""
        ends = range(0, self.fingers, RESPONSES)
        return [slice(begin, min(begin + RESPONSES, self.fingers)) for begin in ends]

    def responses(self, transfers: Transfers) -> list[Response]:
        """Return the responses of a quantity to the parts of the drive, whose sum is its response."""
        found = []
        for factor, drive in self.drive.terms(self.columns):
            found.append(Response(transfers.under(factor), drive, self.settled))
            transfers = transfers.without_charge()  # charge acts once
        return found

    def write(self, rows: Real, transfers: Transfers) -> None:
        """Write the response of a quantity.

        `rows` (fingers, n).
        """
        responses = self.responses(transfers)
        for some in self.parts():
            write_sum(rows[some], responses, some)


def write_sum(out: Real, responses: list[Response], some: slice, *, factor: Real | None = None) -> None:
    """Write the sum of the responses of some fingers, or a factor times its square.

    `out` (fingers, n), `factor` (rows,).
    """
    if len(responses) == 1:
        responses[0].write(out, some, factor=factor)
        return
    total, more = np.empty((2, *out.shape))
    responses[0].write(total, some)
    for response in responses[1:]:
        response.write(more, some)
        total += more
    if factor is not None:
        np.multiply(total, total, out=total)
        total *= factor[some, None]
    out[:] = total
