"""Force laws: attraction from the fields in the layers, by the surface on which the Maxwell stress is evaluated.

The published static formulas are the Maxwell stress of one displacement, evaluated in media of different permittivity,
and differ by factors of 3.4 to 1650. Each is a law with a name. The finger can separate from the plate only in the gap,
so the Maxwell stress in the gap is the physical one; inside a lossy dielectric the Maxwell stress is a convention.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.citation import Check, derived
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.files import UNREAD
from electrovib.core.model import Model
from electrovib.core.quantity import ColumnName, column_unit
from electrovib.core.samples import Samples
from electrovib.core.units import format_quantity
from electrovib.physics.stack import IMPLIED, ORDER, Role, beside_interface

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.physics.roughness import GaussianGaps
    from electrovib.physics.stack import Layer, LayerState, Linear, Section


class ForceLaw(Model, family=True):
    """Attraction per area from the state of the layers.

    Notes
    -----
    A law has two steps: `amplitudes` gives quantities that are linear in the drive, and `pressure` computes the
    attraction from their values at one time, under the same names. With `causal` false the law has no time-domain form
    and applies to a single sine only. `needs` lists the layers without which the law has no meaning, by role or by name;
    `layer_of` returns the layer of a role that is nearest to the interface. A law whose pressure can be negative
    explains that in `negative`. `of_second_degree` declares that the pressure is a quadratic form of the amplitudes.
    """

    evaluation_surface: ClassVar[str] = "gap"
    causal: ClassVar[bool] = True
    instead: ClassVar[str] = ""
    needs: ClassVar[tuple[str, ...]] = ()
    negative: ClassVar[str] = ""
    of_second_degree: ClassVar[bool] = False

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the linear quantities from which the pressure is computed; by default the gap field E.

        Parameters
        ----------
        section : Section
            Phasors over frequency or transfer functions.

        Returns
        -------
        amplitudes : dict
            Name of an argument of `pressure` to linear quantity, per volt of the drive.
        """
        return {"E": gap_field(section)}

    def pressure(self, *args: Any, **kwargs: Any) -> NDArray[np.float64]:
        """Return the attraction per area [Pa] from the amplitudes at one time [their units], scalar or array.

        Raises
        ------
        InputError
            If the member does not define it.
        """
        del args
        raise InputError(
            f"force.model = '{type(self).__name__}': the class does not define pressure(self, {', '.join(kwargs)}), which"
            " returns the attraction per area in Pa"
        )

    def effective_voltage(self, section: Section) -> Linear | None:
        """Return the part of the voltage that causes the attraction.

        Parameters
        ----------
        section : Section
            Layers per volt of the drive, over frequency or as transfer functions.

        Returns
        -------
        voltage : Linear or None
            Share of the drive voltage [-]; None where the law does not define one.
        """
        del section
        return None

    def gaps(self) -> GaussianGaps | None:
        """Return the distribution of local gaps that the law declares; None where it declares none."""
        return None

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Return what a user should know of this law with these layers; by default nothing.

        Parameters
        ----------
        layers : mapping of str to Layer
            Layers by name, in the order from the plate to the finger.

        Returns
        -------
        diagnostics : tuple of Diagnostic
            One for each statement.
        """
        del layers
        return ()

    def diagnostics_over_frequency(self, section: Section) -> tuple[Diagnostic, ...]:
        """Return diagnostics of this law over frequency, for layers without their leaks.

        Parameters
        ----------
        section : Section
            Layers per volt of the drive over frequency.

        Returns
        -------
        diagnostics : tuple of Diagnostic
            One for each statement.
        """
        del section
        return ()


def layer_of(section: Section, wanted: str) -> LayerState:
    """Return a layer that a law needs: by role the one nearest to the interface, else by name.

    A stack without it is refused.
    """
    name = needed_layer(section.roles, wanted)
    if name is None:
        raise InputError(f"stack: the force law needs {wanted_layer(wanted)}")
    return section[name]


def needed_layer(roles: Mapping[str, Role], wanted: str) -> str | None:
    """Return the name of a layer that a law needs; None where the stack has no such layer.

    `roles` has name to role of each layer, from the plate to the finger. Of a role the layer nearest to the
    interface is taken.
    """
    role = next((each for each in ORDER if each == wanted), None)
    if role is not None:
        return beside_interface(roles, role)
    return wanted if wanted in roles else None


def wanted_layer(wanted: str) -> str:
    """Describe a layer that a law needs, for a message."""
    usual = next((name for name, each in IMPLIED.items() if each == wanted), None)
    if usual is None:
        return f"a layer 'stack.{wanted}'"
    return f"a layer 'stack.{usual}', or one of another name with role = '{wanted}'"


def gap_field(section: Section) -> Linear:
    """Return the field in the gap [V/m per volt], or in a vanishing gap that does not leak where the stack has none.

    Without a gap E = (D_gap(0-) + integral of J dt)/eps0 with the total current density J, because charge
    conducted to the interface accumulates there. It equals the bound displacement of the last layer of the
    plate over eps0 only if no layer of the plate conducts. Where bridges cover a share of the gap, it is the
    field times the square root of the share without bridges, so that its stress is the mean over the area.
    """
    name = beside_interface(section.roles, "gap")
    if name is None:
        return section.interface_displacement * (1 / eps0)
    gap = section[name]
    pulling = gap.material.pulling_share
    return gap.field if pulling == 1 else gap.field * math.sqrt(pulling)


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
        derived(
            "pressure",
            given={"E": 1.10583e7, "D": 3.28008e-4},
            expect=1814.0,
            rtol=1e-3,
            source="181.4 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
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
        derived(
            "pressure",
            given={"E": 2.37474e4, "D": 3.28008e-4},
            expect=3.895,
            rtol=1e-3,
            source="0.3895 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
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
        derived(
            "pressure",
            given={"E": 1.13023e7},
            expect=565.5,
            rtol=1e-3,
            source="56.55 mN on 1 cm2 of the film of Vezzoli et al. 2014 at 1000 V, computed apart from this code",
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


class TabulatedAttraction(ForceLaw):
    """An attraction per area that is known at some constant voltages.

    Notes
    -----
    The voltage is that across the gap and the layers that do not conduct; either sign attracts alike. Between rows the
    attraction over the squared voltage is linear in that square, below the first row it is that of the first, and beyond the
    last one a run is refused. The table is of one load and one surface. The contact follows the voltage at once: where it is
    slower than a period of the drive, the attraction is that of the root mean square times the squared ratio to it.
    `electrovib.save` writes a rough contact that was solved as such a table; without a table a run solves contact.surface =
    { model = "RoughContact", ... } for it.
    """

    status: ClassVar[str] = "derived"
    evaluation_surface: ClassVar[str] = "table"
    example: ClassVar[Mapping[str, Any]] = {
        "voltage_samples": [1000, 2000],
        "attraction_samples": [1e5, 4e5],
    }

    file: Annotated[str, Field(description="csv, npy or nc file with the table")] = ""
    voltage_column: ColumnName = "voltage"
    voltage_unit: Annotated[str, column_unit("V"), Field(description="unit of the column")] = "V"
    attraction_column: ColumnName = "attraction"
    attraction_unit: Annotated[str, column_unit("Pa"), Field(description="unit of the column")] = "Pa"
    voltage_samples: Annotated[Samples, Field(description="voltages [V], in place of a file")] = Samples([])
    attraction_samples: Annotated[
        Samples, Field(description="attractions per area [Pa], in place of a file")
    ] = Samples([])

    @property
    def is_solved(self) -> bool:
        """Whether there is no table, and contact.surface is solved for one."""
        return not (self.file or len(self.voltage_samples) or len(self.attraction_samples))

    @model_validator(mode="after")
    def _is_a_table(self) -> Self:
        voltage, attraction = self.voltage_samples.values, self.attraction_samples.values
        why = ""
        if self.is_solved:
            return self
        if voltage.size != attraction.size:
            why = f"columns differ in length: {voltage.size} voltages and {attraction.size} attractions"
        elif not voltage.any():
            why = f"holds no voltage besides 0: {UNREAD if self.file else 'give voltages and their attractions'}"
        elif not np.all(np.diff(voltage) > 0) or voltage[0] < 0:
            why = (
                "voltages must rise from row to row, from 0 on; of a contact that falls shut keep one branch"
            )
        elif not np.all((attraction >= 0) & (attraction < np.inf) & ((attraction > 0) | (voltage == 0))):
            why = "attractions must be finite and above 0, at 0 V they may be 0"
        if why:
            raise ValueError(why)
        return self

    def amplitudes(self, section: Section) -> dict[str, Linear]:
        """Return the voltage across the gap and the layers that do not conduct."""
        layers = [section[name] for name in section.names]
        first, *others = (
            layer.field * (layer.thickness * (np.asarray(layer.material.conductivity) == 0))
            for layer in layers
        )
        return {"V": sum(others, start=first)}

    def pressure(self, V: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the attraction per area [Pa] from the voltage [V]."""
        if self.is_solved:
            raise InputError(
                "force: TabulatedAttraction has no table here, where contact.surface is not solved as for a run; give one, which"
                " electrovib.save writes of electrovib.rough_contact"
            )
        given = np.asarray(V, dtype=float)
        voltage, attraction = self.voltage_samples.values, self.attraction_samples.values
        largest = np.max(np.abs(given), initial=0.0, where=np.isfinite(given))
        if largest > voltage[-1] * (1 + 1e-9):
            raise InputError(
                f"force: the table ends at {format_quantity(voltage[-1], 'V')}, but gap and layers that do not conduct have"
                f" {format_quantity(float(largest), 'V', digits=4)}; give a table up to there, or lower the drive"
            )
        known = voltage > 0
        squared, asked = voltage[known] ** 2, given**2
        found: NDArray[np.float64] = asked * np.interp(asked, squared, attraction[known] / squared)
        return found

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Return that load and surface are those of the table, which are not judged."""
        del layers
        if self.is_solved:
            return ()
        text = "load, area and surface are those of the table, and the contact follows the voltage at once"
        return (Diagnostic("table of the attraction", "unknown", text),)
