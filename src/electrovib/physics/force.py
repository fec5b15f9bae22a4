"""From fields to attraction: at which plane the finger is cut free.

The published static formulas are one displacement divided by the permittivity of different planes, 3.4 to
1650 times apart. Each is a law with a name. The finger can separate from the plate only in the gap, so the
gap plane is the physical one; inside a lossy dielectric a Maxwell stress is a convention.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from electrovib.core.checks import Check
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, nearest
from electrovib.core.lamps import Lamp
from electrovib.core.model import Model

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from electrovib.physics.stack import Layer, LayerState, Linear, Section


class ForceLaw(Model, family=True):
    """Attraction per area from the state of the layers.

    Notes
    -----
    A law has two steps. `amplitudes` names quantities linear in the drive; `pressure` takes them as numbers,
    at one time, under the same names. A law that has no causal form says so; it then has no response to
    anything but one sine.
    """

    plane: ClassVar[str] = "gap"
    causal: ClassVar[bool] = True
    instead: ClassVar[str] = ""
    needs: ClassVar[tuple[str, ...]] = ()

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Name the linear quantities the pressure is made of; by default the gap field E.

        Parameters
        ----------
        section : Section
            Phasors over frequency or transfer functions.

        Returns
        -------
        dict
            Argument name of `pressure` to linear quantity.
        """
        return {"E": gap_field(section)}

    def pressure(self, *args: Any, **kwargs: Any) -> NDArray[np.float64]:
        """Attraction per area [Pa] from the amplitudes at one time [their units], scalar or array."""
        raise NotImplementedError(f"{type(self).__name__} must define pressure({args}, {kwargs})")

    def effective_voltage(self, section: Section) -> Linear | None:
        """Give the part of the voltage that pulls, where the law has such a notion."""
        del section
        return None

    def lamps(self, layers: Mapping[str, Layer]) -> tuple[Lamp, ...]:
        """Say what a user should know of this law with these layers."""
        del layers
        return ()


def layer_of(section: Section, name: str) -> LayerState:
    """Find a layer a law needs.

    Raises
    ------
    InputError
        With the layers there are.
    """
    if name not in section.names:
        raise InputError(f"stack: the force law needs a layer '{name}'.{nearest(name, section.names)}")
    return section[name]


def gap_field(section: Section) -> Linear:
    """Field in the gap; without a layer named gap, that of a vanishing gap that does not leak.

    Where bridges cover a share of the gap, the field times the root of the share that pulls: its stress is the
    mean over the area.
    """
    if "gap" in section.names:
        gap = section["gap"]
        pulling = gap.material.pulling_share
        return gap.field if pulling == 1 else gap.field * math.sqrt(pulling)
    return layer_of(section, "insulator").displacement * (1 / eps0)


class GapPlane(ForceLaw):
    """Maxwell stress in the air between plate and finger: where they separate.

    Notes
    -----
    p = eps0 E^2/2. Equal to virtual work at fixed voltage on the gap. With no layer named ``gap`` it is the
    limit of a vanishing, non-conducting gap, E = D/eps0. In a gap of `BridgedAir` E is the field times the root
    of the share without bridges, so that p is the mean over the area.
    """

    reference: ClassVar[str] = "virtual work at fixed voltage"
    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}
    plane: ClassVar[str] = "gap"
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 1.66667e7},
            expect=1235.0,
            rtol=1.5e-2,
            source="Rauf 2025, finite elements of its public code: permittivity 3, gap 1 um, over 12 mm2",
            status="abstract",
        ),
        Check(
            "pressure",
            given={"E": 1.01351e8},
            expect=45967.0,
            rtol=6e-2,
            source="the same: permittivity 50, gap 1 um; it has fringes",
            status="abstract",
        ),
    )

    def pressure(self, E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from the gap field [V/m]."""
        return eps0 * E**2 / 2


class InsulatorPlane(ForceLaw):
    """Stress evaluated inside the insulator: a convention, low by its permittivity.

    Notes
    -----
    p = E D/2 with the insulator's own field and bound displacement.
    """

    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "E*D/2"}
    plane: ClassVar[str] = "insulator"
    needs: ClassVar[tuple[str, ...]] = ("insulator",)
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 1.10583e7, "D": 3.28008e-4},
            expect=1814.0,
            rtol=1e-3,
            source="181.4 mN on 1 cm2 of the founding film at 1000 V, computed apart from this code",
            status="derived",
        ),
    )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Give field and bound displacement of the insulator."""
        layer = layer_of(section, "insulator")
        return {"E": layer.field, "D": layer.displacement}

    def pressure(self, E: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from field [V/m] and displacement [C/m2]."""
        return E * D / 2


class StratumCorneumPlane(ForceLaw):
    """Stress evaluated inside the stratum corneum: a convention, low by its permittivity.

    Notes
    -----
    p = E D/2 with the skin's own field and bound displacement, the real permittivity at the frequency for one
    sine; it decays as the skin conducts although no charge crosses the interface.
    """

    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "E*D/2"}
    plane: ClassVar[str] = "stratum_corneum"
    needs: ClassVar[tuple[str, ...]] = ("stratum_corneum",)
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 2.37474e4, "D": 3.28008e-4},
            expect=3.895,
            rtol=1e-3,
            source="0.3895 mN on 1 cm2 of the founding film at 1000 V, computed apart from this code",
            status="derived",
        ),
    )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Give field and bound displacement of the stratum corneum."""
        layer = layer_of(section, "stratum_corneum")
        return {"E": layer.field, "D": layer.displacement}

    def pressure(self, E: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from field [V/m] and displacement [C/m2]."""
        return E * D / 2


class EffectiveMediumPlane(ForceLaw):
    """Energy of the capacitor divided by the geometric thickness: the static law of the founding paper.

    Notes
    -----
    p = eps0 V^2/(2 K L), K = T_i/eps_i + T_s/eps_s, L = T_i + T_s, written with the equivalent field
    E = V/sqrt(K L). Equal to virtual work only for one homogeneous dielectric whose thickness changes. No
    charge is ever lost in it.
    """

    reference: ClassVar[str] = (
        "Vezzoli et al., Electrovibration modeling analysis, EuroHaptics 2014, equation (1)"
    )
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}
    plane: ClassVar[str] = "effective medium"
    needs: ClassVar[tuple[str, ...]] = ("insulator", "stratum_corneum")
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 1.13023e7},
            expect=565.5,
            rtol=1e-3,
            source="56.55 mN on 1 cm2 of the founding film at 1000 V, computed apart from this code",
            status="derived",
        ),
    )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Give the equivalent field."""
        return {"E": equivalent_field(section, section.voltage)}

    def pressure(self, E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from the equivalent field [V/m]."""
        return eps0 * E**2 / 2

    def effective_voltage(self, section: Section) -> Linear:
        """Give the whole voltage of the stack."""
        return section.voltage


def equivalent_field(section: Section, voltage: Linear) -> Linear:
    """Field E = V/sqrt(K L) whose stress in vacuum is the founding paper's static force."""
    names = ("insulator", "stratum_corneum")
    length = sum(layer_of(section, name).thickness for name in names)
    return section.inverse_root_thickness(names) * voltage * (1 / length**0.5)
