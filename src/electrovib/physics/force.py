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
from electrovib.core.errors import InputError
from electrovib.core.lamps import Lamp
from electrovib.core.model import Model
from electrovib.physics.interface import IMPLIED, ORDER, Role, beside_interface

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from electrovib.physics.stack import Layer, LayerState, Linear, Section


_PLATE_AND_FINGER: tuple[Role, ...] = ("plate", "finger")
_NEGATIVE = (
    "in a layer that polarises slowly the field turns before the bound displacement does, and their product is then"
    " negative: a convention of this plane, not a push; a force between plate and finger is that of the gap plane"
)


class ForceLaw(Model, family=True):
    """Attraction per area from the state of the layers.

    Notes
    -----
    A law has two steps. `amplitudes` names quantities linear in the drive; `pressure` takes them as numbers,
    at one time, under the same names. A law that has no causal form says so; it then has no response to
    anything but one sine. `needs` tells the layers that it reads: by role, which is the one nearest to the
    interface, or by the name of a layer of its own.
    A law whose pressure can be negative says in `negative` why its attraction may be.
    """

    plane: ClassVar[str] = "gap"
    causal: ClassVar[bool] = True
    instead: ClassVar[str] = ""
    needs: ClassVar[tuple[str, ...]] = ()
    negative: ClassVar[str] = ""

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
        """Attraction per area [Pa] from the amplitudes at one time [their units], scalar or array.

        Raises
        ------
        NotImplementedError
            If the member defines none.
        """
        raise NotImplementedError(f"{type(self).__name__} must define pressure({args}, {kwargs})")

    def effective_voltage(self, section: Section) -> Linear | None:
        """Give the part of the voltage that pulls, where the law has such a notion."""
        del section
        return None

    def lamps(self, layers: Mapping[str, Layer]) -> tuple[Lamp, ...]:
        """Say what a user should know of this law with these layers."""
        del layers
        return ()

    def lamps_over_frequency(self, section: Section) -> tuple[Lamp, ...]:
        """Say what a user should know of this law over these frequencies, of layers without their leaks."""
        del section
        return ()


def layer_of(section: Section, wanted: str) -> LayerState:
    """Give a layer that a law needs, by role the one nearest to the interface, else by name.

    Raises
    ------
    InputError
        If the stack has none.
    """
    name = needed_layer(section.roles, wanted)
    if name is None:
        raise InputError(f"stack: the force law needs {wanted_layer(wanted)}")
    return section[name]


def needed_layer(roles: Mapping[str, Role], wanted: str) -> str | None:
    """Find a layer that a law needs.

    Parameters
    ----------
    roles : mapping of str to str
        Name to role of each layer, from the plate to the finger.
    wanted : str
        An entry of `ForceLaw.needs`.

    Returns
    -------
    str or None
        Name of the layer nearest to the interface if a role is wanted, else the name that is wanted; None where the
        stack has no such layer.
    """
    role = next((each for each in ORDER if each == wanted), None)
    if role is not None:
        return beside_interface(roles, role)
    return wanted if wanted in roles else None


def wanted_layer(wanted: str) -> str:
    """Say which layer a law needs, for a message."""
    usual = next((name for name, each in IMPLIED.items() if each == wanted), None)
    if usual is None:
        return f"a layer 'stack.{wanted}'"
    return f"a layer 'stack.{usual}', or one of another name with role = '{wanted}'"


def gap_field(section: Section) -> Linear:
    """Field where plate and finger separate [V/m per volt]: in the gap, or in a vanishing gap that does not leak.

    Notes
    -----
    Without a gap E = (D_gap(0-) + integral of J dt)/eps0 over the total current density J: whatever conducts up
    to the interface brings its charge there. It is the bound displacement of the plate's last layer over eps0
    only if no layer of the plate conducts. Where bridges cover a share of the gap, it is the field times the
    root of the share that pulls: its stress is then the mean over the area.
    """
    name = beside_interface(section.roles, "gap")
    if name is None:
        return section.interface_displacement * (1 / eps0)
    gap = section[name]
    pulling = gap.material.pulling_share
    return gap.field if pulling == 1 else gap.field * math.sqrt(pulling)


class GapPlane(ForceLaw):
    """Maxwell stress in the air between plate and finger: where they separate.

    Notes
    -----
    p = eps0 E^2/2. Equal to virtual work at fixed voltage on the gap. Without a gap it is the limit of a
    vanishing gap that does not conduct, E = (D_gap(0-) + integral of J dt)/eps0: over a plate that conducts it
    grows as long as the voltage is held (Johnsen and Rahbek's effect), and a diagnostic says from when on no real
    gap is small enough for it. In a gap of `BridgedAir` E is the field times the root
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
    p = E D/2 with field and bound displacement of the plate's layer that is nearest to the interface.
    """

    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "E*D/2"}
    plane: ClassVar[str] = "insulator"
    needs: ClassVar[tuple[str, ...]] = ("plate",)
    negative: ClassVar[str] = _NEGATIVE
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
        layer = layer_of(section, "plate")
        return {"E": layer.field, "D": layer.displacement}

    def pressure(self, E: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
        """Attraction per area from field [V/m] and displacement [C/m2]."""
        return E * D / 2


class StratumCorneumPlane(ForceLaw):
    """Stress evaluated inside the stratum corneum: a convention, low by its permittivity.

    Notes
    -----
    p = E D/2 with field and bound displacement of the finger's layer that is nearest to the interface, the real
    permittivity at the frequency for one sine; it decays as the skin conducts although no charge crosses the interface.
    """

    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "E*D/2"}
    plane: ClassVar[str] = "stratum_corneum"
    needs: ClassVar[tuple[str, ...]] = ("finger",)
    negative: ClassVar[str] = _NEGATIVE
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
        layer = layer_of(section, "finger")
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
    needs: ClassVar[tuple[str, ...]] = _PLATE_AND_FINGER
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
    found = [beside_interface(section.roles, role) for role in _PLATE_AND_FINGER]
    names = [name for name in found if name is not None]
    length = sum(layer_of(section, role).thickness for role in _PLATE_AND_FINGER)
    return section.inverse_root_thickness(names) * voltage * (1 / length**0.5)
