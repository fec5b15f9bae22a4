"""Optional parts of a scenario that a change adds: a layer at the interface, or a table that was not given."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from electrovib.core.discovery import find_members
from electrovib.core.errors import Problem, suggestion
from electrovib.physics.interface import IMPLIED, ORDER

if TYPE_CHECKING:
    from electrovib.core.model import Model


def with_parts(
    kind: type[Model], content: dict[str, Any], changes: Mapping[str, Any]
) -> tuple[dict[str, Any], list[Problem]]:
    """Prepare nested tables for changes that add optional parts; a new layer gets its place in ``stack`` here.

    A layer is added where its role is known: implied by the name (``insulator``, ``gap``,
    ``stratum_corneum``) or given as its ``role``. A gap is air unless a material is given; any other layer
    needs one. Changes of a part whose model has to be chosen first are left out, with one problem for each.
    """
    found, problems = dict(changes), list[Problem]()
    for name, role in _place_layers(content, found).items():
        table = found.setdefault(f"stack.{name}", {})
        path = f"stack.{name}.material"
        given = isinstance(table, Mapping) and "material" in table
        if role != "gap" and not given and not any(_table(each) == path for each in changes):
            problems.append(
                Problem("missing: the material of the new layer; only a gap is air without one", path=path)
            )
    for path in changes:
        part, family = _absent(kind, content, path.split(".")[:-1])
        if not part or any(part == each or part.startswith(f"{each}.") for each in map(_table, changes)):
            continue
        if family is None:
            found.setdefault(part, {})
        else:
            del found[path]
            problems.append(
                Problem(
                    f"'{part}' is not given; choose its model too, {part}.model, one of: {_members(family)}",
                    path=path,
                )
            )
    return found, problems


def _table(path: str) -> str:
    return path.removesuffix(".model")


def _members(family: type[Model]) -> str:
    return ", ".join(sorted(find_members(family)))


def _place_layers(content: dict[str, Any], changes: dict[str, Any]) -> dict[str, Any]:
    """Insert an empty table for each new layer into the stack, which may be new as a whole; return names and roles."""
    tables = changes if isinstance(changes.get("stack"), Mapping) else content
    stack = tables.get("stack")
    if not isinstance(stack, Mapping):
        return {}
    placed, added = dict(stack), dict[str, Any]()
    for path in changes:
        name = path.split(".")[1] if path.startswith("stack.") else ""
        role = _role(name, changes)
        if name and name not in placed and role in ORDER:
            layers = list(placed.items())
            place = sum(
                _lies_before(added.get(other) or _own_role(other, table), role) for other, table in layers
            )
            placed = dict([*layers[:place], (name, {}), *layers[place:]])
            added[name] = role
    tables["stack"] = placed
    return added


def _role(name: str, changes: Mapping[str, Any]) -> Any:
    """Role of a new layer: that of its name, else the declared one, else None."""
    table = changes.get(f"stack.{name}")
    declared = table.get("role") if isinstance(table, Mapping) else changes.get(f"stack.{name}.role")
    return IMPLIED.get(name, declared)


def _own_role(name: str, table: Any) -> Any:
    """Role of a layer of the stack: that of its name, else the declared one, else None."""
    return IMPLIED.get(name) or (table.get("role") if isinstance(table, Mapping) else None)


def _lies_before(role: Any, new: Any) -> bool:
    """Return whether a layer of one role lies on the plate's side of a new layer of another role."""
    return role in ORDER and (ORDER.index(role) < ORDER.index(new) or role == new == "plate")


def _absent(kind: type[Model], content: Any, keys: Sequence[str]) -> tuple[str, type[Model] | None]:
    """Find the first optional part on a path that is not given, and its family if a model has to be chosen."""
    table, model = content, kind
    for depth, key in enumerate(keys, 1):
        part = model.part(key)
        if part is None or not isinstance(table, Mapping) or key not in table:
            return "", None
        table = table[key]
        if table is None:
            return ".".join(keys[:depth]), part if part.is_family else None
        chosen = part.chosen(table) if isinstance(table, Mapping) else None
        if chosen is None:
            return "", None
        model = chosen
    return "", None


def how_to_add(kind: type[Model], content: Mapping[str, Any], path: str) -> str:
    """Explain how to add the optional part that a path leads into; empty where it leads into none."""
    *parents, last = parts = path.split(".")
    stack = content.get("stack")
    if isinstance(stack, Mapping) and parts[0] == "stack" and "".join(parts[1:2]) not in {"", *stack}:
        name, layers = parts[1], ", ".join(stack)
        if name not in IMPLIED:
            meant = suggestion(name, [*stack, *IMPLIED])
            return (
                f"the stack has no layer '{name}'; its layers are {layers}.{meant} A new layer needs a thickness, a material"
                " and a role, 'plate', 'gap' or 'finger'"
            )
        return (
            f"the stack has no layer '{name}'; its layers are {layers}. Add it, for instance with"
            f" --set stack.{name}='{{ thickness = \"5 um\" }}' or as the table [stack.{name}] of the file"
        )
    part, family = _absent(kind, content, parents)
    if not part:
        return ""
    first = f'model = "{min(find_members(family))}", ' if family is not None else ""
    return f"'{part}' is not given. Add it, for instance with --set {part}='{{ {first}{last} = ... }}'"
