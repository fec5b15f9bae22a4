"""The published static laws: the Maxwell stress of one displacement, evaluated in different media."""

from __future__ import annotations

from typing import TYPE_CHECKING, ClassVar, Final

from electrovib.core.citation import Check
from electrovib.core.constants import eps0
from electrovib.physics.force.base import ForceLaw, layer_of
from electrovib.physics.stack import Role

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
    from numpy.typing import NDArray

    from electrovib.physics.stack import Linear, Section


_PLATE_AND_FINGER: tuple[Role, ...] = ("plate", "finger")

SUMS: Final[Mapping[str, str]] = {
    "K": "sum(layer.thickness/layer.material.bound_permittivity(frequency) for layer in solids)",
    "L": "sum(layer.thickness for layer in solids)",
}
"""Equations of the electrical and of the geometric thickness of the layers of plate and finger."""

_NEGATIVE = (
    "in a layer that polarises slowly the field reverses before the bound displacement does, and their product is then"
    " negative: this follows from the convention of evaluating the stress inside a layer and is no repulsion; the force"
    " between plate and finger is that of the Maxwell stress in the gap"
)


class StressOfField(ForceLaw, family=True):
    """Maxwell stress of one field in vacuum, that in a gap or an equivalent one."""

    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2"}

    def pressure(self, E: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attraction per area [Pa] from the field [V/m]."""
        return eps0 * E**2 / 2


class MaxwellStressInGap(StressOfField):
    """Maxwell stress in the air gap between plate and finger, where they separate.

    Notes
    -----
    p = eps0 E^2/2, equal to the virtual work on the gap at fixed voltage. Without a gap it is the limit of a vanishing
    gap that does not conduct, E = (D_gap(0-) + integral of J dt)/eps0: on a plate that conducts it grows as long as
    the voltage is held (the Johnsen-Rahbek effect), and a diagnostic states from when on no real gap is small enough
    for this limit. In a gap of `BridgedAir` E is the field times the square root of the share without bridges, so that
    p is the mean over the area.
    """

    reference: ClassVar[str] = "virtual work at fixed voltage"
    status: ClassVar[str] = "derived"
    evaluation_surface: ClassVar[str] = "gap"
    of_second_degree: ClassVar[bool] = True
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
            source="the same: permittivity 50, gap 1 um; fringe fields included",
            status="abstract",
        ),
    )


class MaxwellStressInLayer(ForceLaw, family=True):
    """Maxwell stress inside a layer, with its field and bound displacement."""

    status: ClassVar[str] = "derived"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "E*D/2"}
    of_second_degree: ClassVar[bool] = True
    negative: ClassVar[str] = _NEGATIVE

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return field and bound displacement of the layer that the law needs."""
        layer = layer_of(section, self.needs[0])
        return {"E": layer.field, "D": layer.displacement}

    def pressure(self, E: NDArray[np.float64], D: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attraction per area [Pa] from field [V/m] and displacement [C/m2]."""
        return E * D / 2


class MaxwellStressInInsulator(MaxwellStressInLayer):
    """Maxwell stress inside the insulator: a convention, smaller than that in the gap by its permittivity.

    Notes
    -----
    p = E D/2 with the field and the bound displacement of the plate's layer nearest to the interface.
    """

    evaluation_surface: ClassVar[str] = "insulator"
    needs: ClassVar[tuple[str, ...]] = ("plate",)
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 1.10583e7, "D": 3.28008e-4},
            expect=1814.0,
            rtol=1e-3,
            source="181.4 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
            status="derived",
        ),
    )


class MaxwellStressInStratumCorneum(MaxwellStressInLayer):
    """Maxwell stress inside the stratum corneum: a convention, smaller than that in the gap by its permittivity.

    Notes
    -----
    p = E D/2 with the field and the bound displacement of the finger's layer nearest to the interface; for a sine the
    displacement is that of the real permittivity at its frequency. It decays as the skin conducts, although no charge
    crosses the interface.
    """

    evaluation_surface: ClassVar[str] = "stratum_corneum"
    needs: ClassVar[tuple[str, ...]] = ("finger",)
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 2.37474e4, "D": 3.28008e-4},
            expect=3.895,
            rtol=1e-3,
            source="0.3895 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
            status="derived",
        ),
    )


class EffectiveMedium(StressOfField):
    """Energy of the capacitor divided by the geometric thickness: the static law of Vezzoli et al. 2014.

    Notes
    -----
    p = eps0 V^2/(2 K L) with the sums K = sum T/eps and L = sum T over `solids`, the layers of the plate and of the finger;
    the paper has T_i/eps_i + T_s/eps_s and T_i + T_s. The law takes no account of a gap between them. It is written with
    the equivalent field E = V/sqrt(K L), whose V is `voltage`, that of all layers. The equation holds at a `frequency`;
    in time K^(-1/2) is a causal filter. It equals virtual work only for one homogeneous dielectric whose thickness
    changes. Charge does not leak in this law.
    """

    reference: ClassVar[str] = (
        "Vezzoli et al., Electrovibration modeling analysis, EuroHaptics 2014, equation (1)"
    )
    status: ClassVar[str] = "full text"
    equation: ClassVar[Mapping[str, str]] = {"pressure": "eps0*E**2/2", "E": "voltage/sqrt(K*L)", **SUMS}
    evaluation_surface: ClassVar[str] = "effective medium"
    of_second_degree: ClassVar[bool] = True
    needs: ClassVar[tuple[str, ...]] = _PLATE_AND_FINGER
    checks: ClassVar[tuple[Check, ...]] = (
        Check(
            "pressure",
            given={"E": 1.13023e7},
            expect=565.5,
            rtol=1e-3,
            source="56.55 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
            status="derived",
        ),
    )

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the equivalent field."""
        return {"E": equivalent_field(section, section.voltage)}

    def effective_voltage(self, section: Section) -> Linear:
        """Return the whole voltage of the stack."""
        return section.voltage


def equivalent_field(section: Section, voltage: Linear) -> Linear:
    """Return the field E = V/sqrt(K L) [V/m per volt] whose stress in vacuum is the static force of Vezzoli et al. 2014.

    K = sum T/eps and L = sum T are the sums over the layers of plate and finger, V is the `voltage` per volt
    of the drive.
    """
    names = [name for name, role in section.roles.items() if role in _PLATE_AND_FINGER]
    length = sum(section[name].thickness for name in names)
    return section.inverse_root_thickness(names) * voltage * (1 / length**0.5)
