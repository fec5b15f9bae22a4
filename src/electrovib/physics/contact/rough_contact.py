"""A contact of declared roughness and body, which a run solves together with its attraction."""

from __future__ import annotations

import functools
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.physics.contact.surface import FittedSurface, RoughSurface
from electrovib.physics.half_space import Elastic, ElasticBody
from electrovib.physics.roughness import ContactSpots, PullingSpots
from electrovib.physics.topography import FINEST, Topography

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import ArrayLike, NDArray


class RoughContact(RoughSurface):
    """A rough elastic skin whose contact is solved together with its attraction, as by `electrovib.rough_contact`.

    Notes
    -----
    With force = { model = "TabulatedAttraction" }, without a table, a run solves the contact under the load at rising voltages up
    to its largest one, once in a process, and takes attraction and real contact from there. The contact follows the voltage at
    once; beyond a voltage at which it falls shut it is the shut one, which is said. What asks for a law of the mean gap, such as
    `electrovib.equilibrium`, gets `FittedSurface` with rms height, rms slope and modulus of this contact.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "roughness": {
            "model": "SelfAffine",
            "rms": 2e-5,
            "hurst": 0.8,
            "longest": 1e-2,
            "roll_off": 2.5e-3,
            "shortest": 1.25e-3,
        },
        "body": {"model": "Elastic"} | dict(Elastic.example),
    }
    standing: ClassVar[str] = "by the law FittedSurface of its roughness"
    power: ClassVar[float] = FittedSurface.power
    held: ClassVar[float] = FittedSurface.held
    error: ClassVar[str] = FittedSurface.error

    roughness: Topography
    body: ElasticBody
    points: Annotated[int | None, Field(ge=2, le=FINEST, description="points along a side of the grid")] = (
        None
    )
    seed: Annotated[int, Field(ge=0, le=2**31 - 1, description="of the random phases of the roughness")] = 0
    spots: ContactSpots = PullingSpots()

    @model_validator(mode="after")
    def _is_solved_at_any_frequency(self) -> Self:
        if self.spots.leak:
            raise ValueError(
                f"spots = {type(self.spots).__name__}: what leaks depends on the frequency, and a run has many; give PullingSpots"
                " or IdleSpots, or ask electrovib.rough_contact at one frequency"
            )
        return self

    @property
    def law(self) -> FittedSurface:
        """Law of the mean gap of this roughness on this body, whose stiffness is that at the rms wave number."""
        return _law(self.roughness, self.body)

    def doubts(self, share: ArrayLike) -> str:
        """Return where roughness, or a share in contact [1] above 0, is outside those that the law was fitted to."""
        return self.law.doubts(share)

    def pressure(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the repulsion per area [Pa] by the law."""
        return self.law.pressure(gap)

    def slope(self, gap: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the derivative of the repulsion with the gap [Pa/m] by the law."""
        return self.law.slope(gap)

    def gap(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the mean gap under a pressure [m] by the law."""
        return self.law.gap(pressure)

    def real_share(self, pressure: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of the area in contact [1] by the law."""
        return self.law.real_share(pressure)

    def real_growth(self, pressure: float) -> float:
        """Return the derivative of the share in contact with pressure [1/Pa] by the law."""
        return self.law.real_growth(pressure)


@functools.lru_cache(maxsize=32)
def _law(roughness: Topography, body: ElasticBody) -> FittedSurface:
    rms, slope = roughness.rms, roughness.rms_slope(roughness.periods)
    wavenumber = slope / rms
    modulus = 2 / (wavenumber * float(body.compliance(wavenumber)))
    return FittedSurface(modulus=modulus, rms_height=rms, rms_slope=slope)
