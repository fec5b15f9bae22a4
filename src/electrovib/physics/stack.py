"""Layers in series, which of them belong to plate, gap or finger, and the quantities of them that a force law may use."""

from __future__ import annotations

from typing import (
    TYPE_CHECKING,
    Annotated,
    Any,
    ClassVar,
    Final,
    Literal,
    Protocol,
    Self,
    TypeAlias,
    get_args,
)

import numpy as np
from pydantic import Field, model_validator
from pydantic_core import InitErrorDetails, PydanticCustomError, ValidationError

from electrovib.core.arrays import Complex
from electrovib.core.constants import VACUUM_PERMITTIVITY
from electrovib.core.errors import InputError, nearest
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity
from electrovib.core.unchangeable import FrozenDict
from electrovib.physics.conduction import Conduction
from electrovib.physics.material import Constant, Material

if TYPE_CHECKING:
    from collections.abc import Iterable, Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike


Linear: TypeAlias = Any
"""A quantity linear in the drive: phasors over frequency, or a transfer function in poles and gains.

Both can be added, subtracted and multiplied, so one formula of a law serves both.
"""


class Layer(Model):
    """One slab of the stack; a leak conducts in parallel with the material and is non-ohmic.

    Only a gap may be without a material: it is vacuum. `Stack` refuses any other layer that names none.
    """

    how_to_omit: ClassVar[str] = (
        "; to leave a layer out, delete its table in the file of the scenario ('electrovib init SCENARIO -o my.toml' writes"
        " one), or give all other layers by --set stack='{ NAME = { ... }, ... }'"
    )
    equation: ClassVar[Mapping[str, str]] = {
        "impedance": "thickness/(2*pi*I*frequency*eps0*material.complex_permittivity(frequency))",
    }
    example: ClassVar[dict[str, Any]] = {
        "thickness": 90e-6,
        "material": {"model": "Constant", "permittivity": 3.35},
    }

    thickness: Annotated[Number, Quantity("m", 1e-10, 1e-1, "thickness of the layer")]
    role: Annotated[
        Role | None,
        Field(description="'plate', 'gap' or 'finger': the side of the interface on which the layer lies"),
    ] = None
    material: Annotated[
        Material, Field(description="dielectric that fills the layer; a gap alone is vacuum without one")
    ] = Constant(permittivity=1.0)
    leak: Conduction | None = None
    initial_charge: Annotated[
        Number, Quantity("C/m2", -1, 1, "free charge at time 0 on the face towards the finger")
    ] = 0.0
    breakdown_field: Annotated[
        Number | None, Quantity("V/m", 1e4, 1e10, "field at which the layer breaks down, if known")
    ] = None

    @np.errstate(invalid="ignore")  # a NaN is handed on
    def impedance(self, frequency: ArrayLike) -> Complex:
        """Impedance times area, T/(j w eps0 eps*) [ohm m2], at frequencies in Hz; without the leak."""
        axis = 2j * np.pi * np.asarray(frequency, dtype=float)
        permittivity = VACUUM_PERMITTIVITY * self.material.complex_permittivity(frequency)
        total: Complex = self.thickness / (axis * permittivity)
        return total


_NO_MATERIAL: Final = (
    'missing: only a gap is vacuum without one. Declare it, for instance material = { model = "Constant", permittivity = 3.35 },'
    " or by the name of one that 'electrovib list material' or 'electrovib list skins' shows"
)


class Stack(Model):
    """The layers in the order of the file, from the plate to the finger.

    Notes
    -----
    Each layer has the name of its table and belongs to the plate, the gap or the finger: its role. The names
    ``insulator``, ``gap`` and ``stratum_corneum`` imply theirs; any other layer declares it. The physics depends on the
    roles alone: renaming a layer changes no number.
    """

    offered_by: ClassVar[tuple[str, ...]] = ("stacks", "scenarios")
    model_config = Model.model_config | {"extra": "allow"}
    __pydantic_extra__: dict[str, Layer] = Field(init=False)

    example: ClassVar[dict[str, Any]] = {
        "insulator": Layer.example,
        "stratum_corneum": {
            "thickness": 200e-6,
            "material": {"model": "Constant", "permittivity": 1560, "conductivity": 1.8e-6},
        },
    }

    @classmethod
    def part(cls, name: str) -> type[Layer]:
        """Return the kind of every table: a layer."""
        del name
        return Layer

    @classmethod
    def with_place(cls, tables: dict[str, Any], name: str, given: Mapping[str, Any]) -> dict[str, Any]:
        """Insert an empty table for a layer whose role is known: implied by its name (``insulator``) or given."""
        if (role := IMPLIED.get(name) or given.get("role")) not in ORDER:
            return tables
        layers = [*tables.items()]
        place = sum(_lies_before(IMPLIED.get(other) or _role(table), role) for other, table in layers)
        return dict([*layers[:place], (name, {}), *layers[place:]])

    @classmethod
    def from_offer(cls, offer: Any) -> Self:
        """Return the stack of a ready-made scenario, or a stack as it is."""
        return cls.model_validate(getattr(offer, "stack", offer))

    @model_validator(mode="after")
    def _has_layers(self) -> Self:
        if not self.layers:
            raise ValueError("a stack needs at least one layer")
        if any(layer.initial_charge for layer in [*self.layers.values()][-1:]):
            why = (
                f"initial_charge of the last layer '{[*self.layers][-1]}' would lie on the conducting finger"
            )
            raise ValueError(why)
        wrong = [
            name
            for name in self.layers
            if not name.isidentifier() or name == INTERFACE or hasattr(Stack, name)
        ]
        if wrong:
            why = (
                f"'{wrong[0]}' cannot name a layer: use letters, digits and _, and none of the reserved names"
            )
            details = [
                InitErrorDetails(type=PydanticCustomError("layer", "{why}", {"why": why}), input=wrong[0])
            ]
            raise ValidationError.from_exception_data("Stack", details)
        return self

    @model_validator(mode="after")
    def _has_one_interface(self) -> Self:
        layers = self.layers
        problems, roles = role_problems(layers)
        wrong = [
            (name, "role", "role" if layers[name].role else "missing_parameter", why)
            for name, why in problems.items()
        ]
        wrong += [
            (name, "material", "missing_parameter", _NO_MATERIAL)
            for name, role in roles.items()
            if role != "gap" and "material" not in layers[name].model_fields_set
        ]
        details = [
            InitErrorDetails(
                type=PydanticCustomError(kind, "{why}", {"why": why}),
                loc=(name, parameter),
                input=getattr(layers[name], parameter),
            )
            for name, parameter, kind, why in wrong
        ]
        if details:
            raise ValidationError.from_exception_data("Stack", details)
        return self

    @property
    def layers(self) -> dict[str, Layer]:
        """Name to layer, plate to finger."""
        return FrozenDict(self.__pydantic_extra__ or {})

    @property
    def roles(self) -> dict[str, Role]:
        """Name to role of each layer, plate to finger."""
        return roles_of(self.layers)

    @property
    def gap_name(self) -> str | None:
        """Name of the layer between plate and finger; None where they touch."""
        return beside_interface(self.roles, "gap")

    def __iter__(self) -> Iterator[tuple[str, Any]]:  # type: ignore[override]
        """Iterate over name and layer."""
        return iter(self.layers.items())

    @property
    def thickness(self) -> float:
        """Sum of the thicknesses [m]."""
        return sum(layer.thickness for layer in self.layers.values())


def _role(layer: Any) -> object:
    """Return the role that a layer, or the table of one, declares."""
    return layer.get("role") if isinstance(layer, dict) else getattr(layer, "role", None)


def _lies_before(role: Any, new: Any) -> bool:
    """Tell whether a layer of one role lies on the plate's side of a new layer of another role."""
    return role in ORDER and (ORDER.index(role) < ORDER.index(new) or role == new == "plate")


def pieces(layers: Mapping[str, Layer]) -> list[tuple[str, ...]]:
    """Group the names of adjacent layers of one material and leak without charge between them: one slab, with one field."""
    found: list[tuple[str, ...]] = []
    before: Layer | None = None
    for name, layer in layers.items():
        alike = before is not None and (layer.material, layer.leak) == (before.material, before.leak)
        if alike and before is not None and not before.initial_charge:
            found[-1] += (name,)
        else:
            found.append((name,))
        before = layer
    return found


def in_one_piece(layers: Mapping[str, Layer]) -> dict[str, Layer]:
    """Return layers with the thickness of the slab that they are pieces of, on which strength and voltage depend."""
    found: dict[str, Layer] = {}
    for slab in pieces(layers):
        whole = sum(layers[name].thickness for name in slab)
        found |= {name: layers[name].model_copy(update={"thickness": whole}) for name in slab}
    return found


class LayerState(Protocol):
    """The quantities of one layer that a force law may use."""

    @property
    def thickness(self) -> float:
        """Thickness [m]."""

    @property
    def material(self) -> Material:
        """Dielectric that fills the layer."""

    @property
    def field(self) -> Linear:
        """Electric field E, towards the finger [V/m per volt of the drive]."""

    @property
    def displacement(self) -> Linear:
        """Bound displacement D = eps0 eps_pol E [C/m2 per volt], without conduction."""


class Section(Protocol):
    """The state of every layer of the stack, as phasors or as transfer functions."""

    @property
    def frequency(self) -> Linear:
        """Frequencies of the phasors [Hz]; a transfer function has none and raises an error."""

    @property
    def voltage(self) -> Linear:
        """Voltage across all layers."""

    @property
    def current_density(self) -> Linear:
        """Total current density, displacement current included [A/m2 per volt]."""

    @property
    def roles(self) -> Mapping[str, Role]:
        """Name to role of each layer, from the plate to the finger."""

    @property
    def names(self) -> Sequence[str]:
        """Names of the layers and of a vanishing gap, from the plate to the finger."""

    @property
    def interface_displacement(self) -> Linear:
        """Displacement at the interface of plate and finger, if there is no gap [C/m2 per volt]."""

    def __getitem__(self, name: str) -> LayerState:
        """Return the state of a layer by name."""

    def inverse_root_thickness(self, names: Sequence[str]) -> Linear:
        """Return (sum T/eps_pol)^(-1/2) over these layers [m^-1/2], a causal filter."""


Role: TypeAlias = Literal["plate", "gap", "finger"]
"""Side of the interface on which a layer lies."""

ORDER: Final[tuple[Role, ...]] = get_args(Role)
"""From the plate to the finger."""

INTERFACE: Final = "interface"
"""Where plate and finger separate, among the layers; no layer has this name."""

IMPLIED: Final[Mapping[str, Role]] = {"insulator": "plate", "gap": "gap", "stratum_corneum": "finger"}
"""Roles that follow from the name of a layer; any other layer declares its own."""


def roles_of(layers: Mapping[str, Layer]) -> dict[str, Role]:
    """Find for each layer, from the plate to the finger, whether it belongs to the plate, to the gap or to the finger.

    Finger and plate have one interface: the layers of the plate come first, then at most one gap, then the
    layers of the finger. Roles that are missing, or contradict the name of their layer or the order, are
    refused, all at once.
    """
    problems, found = role_problems(layers)
    if problems:
        raise InputError(f"stack.{name}.role: {why}" for name, why in problems.items())
    return found


def role_problems(layers: Mapping[str, Layer]) -> tuple[dict[str, str], dict[str, Role]]:
    """Find what is wrong with the roles of layers, and the roles that are known, each by the name of the layer."""
    problems: dict[str, str] = {}
    found: dict[str, Role] = {}
    last, gap = "", ""
    for name, layer in layers.items():
        role = layer.role or IMPLIED.get(name)
        if role is None:
            meant = nearest(name, IMPLIED)
            meant = meant if "mean" in meant else ""
            problems[name] = (
                "is missing: declare on which side of the interface between plate and finger the layer lies, role = 'plate',"
                f" 'gap' or 'finger'. Only these names imply it: {', '.join(IMPLIED)}.{meant}"
            )
            continue
        if role != IMPLIED.get(name, role):
            problems[name] = (
                f"'{role}' contradicts the name, which implies '{IMPLIED[name]}'; rename the layer"
            )
        elif role == "gap" and gap:
            problems[name] = (
                f"'gap' is already the role of '{gap}': a finger has one interface with the plate"
            )
        elif last and ORDER.index(role) < ORDER.index(found[last]):
            problems[name] = (
                f"'{role}' comes after '{last}', whose role is '{found[last]}': layers are in the order plate, gap, finger"
            )
        else:
            last, gap = name, name if role == "gap" else gap
        found[name] = role
    return problems, found


def beside_interface(roles: Mapping[str, Role], role: Role) -> str | None:
    """Find the name of the layer of a role that is nearest to the interface; None where there is no such layer.

    It is the last layer of the plate, the gap, or the first layer of the finger.
    """
    names = [name for name, each in roles.items() if each == role]
    return (names[-1] if role == "plate" else names[0]) if names else None


def interface_place(roles: Iterable[Role]) -> int:
    """Count the layers of the plate: the interface, or the gap, comes after them."""
    return sum(role == "plate" for role in roles)
