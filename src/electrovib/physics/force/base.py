"""The family of force laws, and how a law finds the layers that it reads."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, ClassVar

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.model import Model
from electrovib.physics.interface import IMPLIED, ORDER, Role, beside_interface

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
    anything but one sine. `needs` tells the layers that it reads: by role, which is the one nearest to the
    interface, or by the name of a layer of its own.
    A law whose pressure can be negative says in `negative` why its attraction may be.
    """

    evaluation_surface: ClassVar[str] = "gap"
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

    def diagnostics(self, layers: Mapping[str, Layer]) -> tuple[Diagnostic, ...]:
        """Say what a user should know of this law with these layers."""
        del layers
        return ()

    def diagnostics_over_frequency(self, section: Section) -> tuple[Diagnostic, ...]:
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
