"""The family of force laws, and the layers that a law needs."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.physics.stack import IMPLIED, ORDER, Role, beside_interface

if TYPE_CHECKING:
    from collections.abc import Mapping

    import numpy as np
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
