"""The contact at rest under a load, with or without attraction.

Over a voltage that changes slowly each rest begins with the former, so that hysteresis is followed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.budget import Work, refuse_beyond
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.solve.rough_contact.attracted import attract
from electrovib.solve.rough_contact.cell import Attraction, Cell, Compliance, Local, MaxwellStress
from electrovib.solve.rough_contact.pressed import press

TOLERANCE = 1e-6
ROUGH = 1e-4
"""Penetration over the rms height of the contact without attraction from which one with attraction begins."""

EVEN = 1e-3
"""Rms height, over how far the load bends the spring, below which surfaces are even."""

OF_A_POINT = 1e-6
"""Computing time of a point of a contact [s], within a factor of two from 512 points along a side on."""
HELD = 30
"""Maps that the solver holds at once."""


STEEP = 0.3
"""Rms slope above which a doubt is told."""


def doubts(*, rms_slope: float, steepness: float) -> list[str]:
    """Say where slopes are not small, and where the grid is too coarse for the attraction."""
    said = []
    if rms_slope > STEEP:
        said.append(f"the roughness has an rms slope of {rms_slope:.2g}, but slopes are taken as small")
    if steepness > 1:
        said.append(
            f"the grid does not resolve the attraction at the edges of the contact, which is {steepness:.2g} times as steep as"
            " its shortest wave is stiff: contact share and attraction may change on a finer grid; give more points"
        )
    return said


def refuse_beyond_budget(points: int, contacts: int, *, kept: int = 0) -> None:
    """Refuse so many contacts of so many points along a side, of which some are kept with their maps, beyond the budget."""
    what = f"{contacts} contacts of {points} x {points} points"
    work = Work(
        what=what,
        time=OF_A_POINT * contacts * points**2,
        memory=8.0 * points**2 * (HELD + 3 * kept),
        remedy="ask for fewer points, draws or voltages",
    )
    refuse_beyond([work], what="this contact")


class Transforms(NamedTuple):
    """Fourier transforms there and back on the finest grid, those on coarser ones by their number of points."""

    exact: float
    single: float


@dataclass(frozen=True, kw_only=True)
class Rest:
    """A contact at rest: maps on the grid, and what they add up to.

    `gap` [m], `pressure` of the contact [Pa], 0 where it is open, `attraction` [Pa]; `energy` per area, elastic, of the load and
    of the attraction [J/m2]; `residual`, error of the gap over the rms height (of even surfaces over a thousandth of how far the
    load bends the spring);
    `rounds` of the solver and its `transforms`; `fell`: the start was beyond a pull-in or a release, and this is another rest;
    `steepness`: largest slope of the attraction over the stiffness of the shortest wave that the grid has, below 1 where the grid
    resolves the attraction.
    """

    gap: Real
    pressure: Real
    attraction: Real
    energy: float
    residual: float
    rounds: int
    transforms: Transforms
    fell: bool
    steepness: float

    def with_field_share(self, share: float) -> Rest:
        """Return the same gaps where faces that are pressed together keep this share of the field [1] of an insulating spot.

        No gap opens: a place that lets go has its whole field again, which pulls it back. So the rim of a spot stays in the gap 0
        without pressure, and keeps of the attraction what balances the bodies; inside, the pressure falls with the attraction.
        """
        lost = np.minimum(self.pressure, (1 - share**2) * self.attraction)
        return replace(self, pressure=self.pressure - lost, attraction=self.attraction - lost)

    @property
    def contact_share(self) -> float:
        """Share of the points that are pressed together [1]."""
        return float(np.mean(self.pressure > 0))

    @property
    def mean_attraction(self) -> float:
        """Mean attraction per area [Pa]."""
        return float(self.attraction.mean())

    @property
    def mean_gap(self) -> float:
        """Mean gap [m]."""
        return float(self.gap.mean())


@dataclass(frozen=True, kw_only=True)
class Loaded:
    """Rough heights [m] on a periodic grid, the body that they press, and the load.

    `heights` of the composite roughness, towards the body, periods [m] along both axes, `compliance` [m/Pa] at wave numbers
    [1/m], mean `pressure` of the load [Pa]. With a `spring` [Pa/m] behind the body, `pressure` is that at a mean surface of
    the body in the height 0, and grows as the body is pushed back.
    """

    heights: Real
    periods: tuple[float, float]
    compliance: Compliance = field(repr=False)
    pressure: float
    spring: float = 0.0
    tolerance: float = TOLERANCE

    def __post_init__(self) -> None:
        """Refuse what cannot be pressed."""
        heights = np.asarray(self.heights, dtype=float)
        if heights.ndim != 2 or min(heights.shape) < 2 or not np.isfinite(heights).all():
            raise InputError(
                f"heights of shape {heights.shape}: a grid of finite heights with two axes is expected"
            )
        if not all(0 < period < math.inf for period in self.periods):
            raise InputError(f"periods = {self.periods}: both are finite and above 0, for instance 1e-3 m")
        if not math.isfinite(self.pressure) or (self.pressure <= 0 and not self.spring > 0):
            raise InputError(
                f"pressure = {self.pressure}: a load is finite and above 0, for instance 5e3 Pa; less only with a spring"
            )
        if not 1e-10 <= self.tolerance <= 1e-2:
            raise InputError(f"tolerance = {self.tolerance}: from 1e-10 to 1e-2, for instance 1e-6")
        object.__setattr__(self, "heights", heights)

    def rest(self, attraction: Attraction | None = None, *, start: Real | None = None) -> Rest:
        """Return the contact at rest, with an attraction near the gap to start from or near the contact without attraction."""
        softness = float(self.compliance(np.array([2 * math.pi / max(self.periods)]))[0])
        length = self._length()
        unit = length / softness  # of pressure: every number of the solver is near 1
        cell = Cell(
            self.heights.shape,
            self.periods,
            lambda wavenumber: self.compliance(wavenumber) / softness,
            spring=self.spring * softness,
        )
        heights, load = self.heights / length, self.pressure / unit

        def scaled(gap: Real) -> Local:
            found = (attraction or _none)(gap * length)
            return Local(found.energy / (unit * length), found.stress / unit, found.slope * softness)

        if attraction is None and not self.spring:
            pressed = press(heights, cell, load=load, tolerance=self.tolerance)
            gap, pressure, pull = np.maximum(pressed.gap, 0.0), pressed.pressure, np.zeros(heights.shape)
            gap[pressure > 0] = 0.0
            bent = pressed.gap + heights
            energy = float(np.mean(pressure * (bent - bent.mean()))) / 2 + load * float(gap.mean())
            residual, rounds, fell = pressed.residual, pressed.rounds, False
        else:
            begin = self._start(heights, cell, load) if start is None else np.maximum(start, 0.0) / length
            gap, pressure, pull, energy, residual, rounds, fell = attract(
                heights, cell, scaled, begin, load=load, tolerance=self.tolerance
            )
        rows = heights.shape[0]
        steepness = float(np.abs(scaled(gap).slope).max() / min(cell.stiff[rows // 2, 0], cell.stiff[0, -1]))
        if not residual <= self.tolerance:
            raise ElectrovibError(_not_at_rest(residual, self.tolerance, steepness))
        return Rest(
            gap=gap * length,
            pressure=pressure * unit,
            attraction=pull * unit,
            energy=energy * unit * length,
            residual=residual,
            rounds=rounds,
            transforms=Transforms(cell.exact, cell.single),
            fell=fell,
            steepness=steepness,
        )

    def _length(self) -> float:
        """Return the unit of length [m]: the rms height, of even surfaces a share of how far the load bends the spring."""
        bent = EVEN * abs(self.pressure) / self.spring if self.spring else 0.0
        return max(float(self.heights.std()), bent) or 1.0

    def _start(self, heights: Real, cell: Cell, load: float) -> Real:
        """Return the gap without attraction; with a spring that of a body that is not bent."""
        if self.spring:
            apart: Real = np.maximum(-load / cell.stiff[0, 0] - heights, 0.0)
            return apart
        pressed = press(heights, cell, load=load, tolerance=max(self.tolerance, ROUGH))
        return np.where(pressed.pressure > 0, 0.0, np.maximum(pressed.gap, 0.0))


def words_of_spots(share: float) -> list[str]:
    """Say what the field does where faces touch, unless the spots insulate."""
    if share == 1:
        return []
    return [
        f"where faces touch they have {100 * share:.3g} % of the field of spots that insulate; the gaps are those of such spots,"
        " because a place that lets go is pulled back by its whole field"
    ]


def _none(gap: Real) -> Local:
    nothing = np.zeros_like(gap)
    return Local(nothing, nothing, nothing)


def _not_at_rest(residual: float, tolerance: float, steepness: float) -> str:
    return (
        f"the contact did not come to rest: the gap is uncertain by {residual:.1e} of the rms height, tolerance = {tolerance:g};"
        f" the attraction is {steepness:.2g} times as steep as the shortest wave of the grid is stiff. Raise the voltage in"
        " smaller steps, or take a finer grid, which resolves the attraction where that number is below 1"
    )


Pull = Callable[[float], Attraction]
"""Attraction at a voltage [V]."""


def follow(
    loaded: Loaded, pull: Pull, voltages: Iterable[float], *, start: Real | None = None
) -> tuple[Rest, ...]:
    """Return the rest at each voltage [V], which begins with the gap of the former one; the first with `start`."""
    rests: list[Rest] = []
    for voltage in voltages:
        rests.append(loaded.rest(pull(voltage), start=start))
        start = rests[-1].gap
    return tuple(rests)


def follow_voltages(
    loaded: Loaded, voltages: Iterable[float], *, electrical_thickness: float
) -> tuple[Rest, ...]:
    """Return the rest at each voltage [V] across layers of an electrical thickness [m] and the gap, in this order."""
    return follow(
        loaded,
        lambda voltage: MaxwellStress(voltage=voltage, electrical_thickness=electrical_thickness),
        voltages,
    )
