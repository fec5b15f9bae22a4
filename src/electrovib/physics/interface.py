"""The interface between plate and finger: each layer belongs to the plate, to the gap between them, or to the finger."""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, Literal, TypeAlias, get_args

from electrovib.core.errors import InputError, nearest

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from electrovib.physics.stack import Layer

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
