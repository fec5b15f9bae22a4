"""An experiment as one frozen tree of models."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

from pydantic import AfterValidator, Field, model_validator

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError, suggestion
from electrovib.core.model import Model
from electrovib.core.paths import with_numbers
from electrovib.core.quantity import quantity_of
from electrovib.core.samples import Samples
from electrovib.core.tables import Changed
from electrovib.core.unchangeable import FrozenDict
from electrovib.core.units import format_quantity
from electrovib.physics.circuit import Circuit
from electrovib.physics.contact import Contact, RoughContact
from electrovib.physics.drive.base import Drive
from electrovib.physics.finger import Finger, Moisture
from electrovib.physics.force import ForceLaw, TabulatedAttraction, needed_layer, wanted_layer
from electrovib.physics.friction import Friction, Load
from electrovib.physics.limits import Limits
from electrovib.physics.motion import HeldOff, Motion
from electrovib.physics.perception import Perception
from electrovib.physics.rig import Rig
from electrovib.physics.stack import IMPLIED, Layer, Stack, in_one_piece, pieces
from electrovib.scenario.files import read_part, sources_of_offers
from electrovib.scenario.grids import FrequencyGrid, TimeGrid
from electrovib.scenario.sources import BY_THE_USER, ready_made
from electrovib.scenario.toml import SCHEMA, to_toml

if TYPE_CHECKING:
    from collections.abc import Collection, Iterator

    from electrovib.core.quantity import Quantity


class Scenario(Model):
    """A finger on a plate under a drive: everything that `simulate` needs.

    Notes
    -----
    `title` and `sources` are descriptions: they enter neither the hash nor equality.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "drive": {"model": "Step", "level": 100},
        "force": {"model": "MaxwellStressInGap"},
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {"model": "FixedArea", "area": 1e-4},
        "load": {"normal_force": 0.5},
        "circuit": Circuit.example,
        "stack": Stack.example,
    }

    title: Annotated[str, Field(description="title of the experiment")] = ""
    drive: Drive
    force: ForceLaw
    friction: Friction
    contact: Contact
    load: Load
    motion: Motion = Motion()
    finger: Finger | None = None
    rig: Rig | None = None
    perception: Perception | None = None
    moisture: Moisture | None = None
    circuit: Circuit
    stack: Stack
    time: TimeGrid = TimeGrid()
    frequency: FrequencyGrid = FrequencyGrid()
    limits: Limits = Limits()
    sources: Annotated[
        dict[str, str],
        Field(description="source of each value, by its dotted path"),
        AfterValidator(FrozenDict),
    ] = FrozenDict()

    @model_validator(mode="after")
    def _law_finds_its_layers(self) -> Self:
        roles = self.stack.roles
        for wanted in self.force.needs:
            if needed_layer(roles, wanted) is None:
                raise ValueError(f"{type(self.force).__name__} needs {wanted_layer(wanted)}")
        return self

    @model_validator(mode="after")
    def _law_has_its_table(self) -> Self:
        law = self.force
        if (
            isinstance(law, TabulatedAttraction)
            and law.is_solved
            and not isinstance(self.contact.surface, RoughContact)
        ):
            raise ValueError(
                "force = TabulatedAttraction: there is no table; give a file, voltage_samples and attraction_samples, or"
                ' contact.surface = { model = "RoughContact", ... }, which a run solves for it'
            )
        return self

    @model_validator(mode="after")
    def _touches(self) -> Self:
        if self.contact.gross_area(self.load.normal_force) <= 0:
            raise ValueError(
                f"contact = {type(self.contact).__name__}: without a load there is no contact area; give load.normal_force,"
                " or contact.model = FixedArea"
            )
        return self

    @model_validator(mode="after")
    def _held_off_has_a_gap(self) -> Self:
        if isinstance(self.motion.distance, HeldOff) and self.stack.gap_name is None:
            raise ValueError(
                "motion.distance = HeldOff: the finger is as far off the plate as the gap is thick, and the stack has"
                " none; add [stack.gap] with a thickness, or omit motion.distance for a finger that touches"
            )
        return self

    @model_validator(mode="after")
    def _moistened(self) -> Self:
        """Let moisture set its parameters, so that every table shows the values of the computation."""
        if self.moisture is not None:
            moved = with_numbers(self.model_copy(update={"moisture": None}), moistened(self, self.moisture))
            object.__setattr__(self, "stack", moved.stack)
            object.__setattr__(self, "friction", moved.friction)
        return self

    @model_validator(mode="after")
    def _charge_sits_on_one_contact(self) -> Self:
        charged = [name for name, layer in self.stack.layers.items() if layer.initial_charge]
        if charged and self.circuit.return_path.second_contact(1.0):
            raise ValueError(
                f"stack.{charged[0]}.initial_charge is possible with one contact only, and a SecondElectrode is a second one:"
                " remove the charge, or use another return path"
            )
        return self

    @property
    def contact_area(self) -> float:
        """Gross contact area under the full load [m2]."""
        return self.contact.gross_area(self.load.normal_force)

    def canonical(self) -> str:
        """Return the canonical JSON of the physics, without title and sources."""
        content = self.model_copy(update={"title": "", "sources": {}})
        return Model.canonical(content)

    @classmethod
    def how_to_add(cls, content: Mapping[str, Any], path: str) -> str:
        """Explain how to add the layer or table that a dotted path leads into; empty where it leads into none."""
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
        part, family = _absent(cls, content, parents)
        if not part:
            return ""
        first = f'model = "{min(find_members(family))}", ' if family is not None else ""
        return f"'{part}' is not given. Add it, for instance with --set {part}='{{ {first}{last} = ... }}'"

    @classmethod
    def rebuilt(cls, content: dict[str, Any]) -> Self:
        """Build a scenario from changed tables, reading the files that are newly named."""
        return read_part(cls, content)

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Return a copy with some parameters changed and their sources marked as set by the user.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to number, text with a unit, or table.

        Returns
        -------
        scenario : Scenario
            Validated copy.

        Raises
        ------
        InputError
            Every mistake at once.
        """
        found = Changed(self)
        built = self._after(found.within(changes, self), found.problems)
        stated = sources_of_offers(found)
        if built.moisture is not None:
            refuse_what_moisture_sets(built, found.stored)
        tables = tuple(f"{path.removesuffix('.model')}." for path in found.stored)
        kept = {
            path: text
            for path, text in self.sources.items()
            if path not in found.stored and not path.startswith(tables)
        }
        tables = tuple(f"{path}." for path in found.stored)
        theirs = {
            path: f"{BY_THE_USER} to {stated[path]}" if path in stated else BY_THE_USER
            for path in dict.fromkeys([*(path for path, _, _ in built.parameters()), *stated])
            if path in found.stored or path.startswith(tables)
        }
        return built.model_copy(update={"sources": kept | theirs})

    def titled(self, *, without: Collection[str] = ()) -> str:
        """Return the title, and after that of a ready-made scenario what was changed: ``..., changed: drive.high = 500 V``.

        Parameters
        ----------
        without : collection of str
            Dotted paths of changes that are not stated.

        Returns
        -------
        title : str
            With at most three changes, and the number of the others.
        """
        origin = ready_made(self.title)
        changed = [] if origin is None or self == origin else _changes(self, origin, "", None)
        listed = [f"{path} = {text}" for path, text in changed if path not in without]
        more = f" and {len(listed) - _MOST_CHANGES} more" if len(listed) > _MOST_CHANGES else ""
        return f"{self.title}, changed: {', '.join(listed[:_MOST_CHANGES])}{more}" if listed else self.title

    def __repr__(self) -> str:
        """Write title and parts, a line each; those that keep their default are omitted."""
        return "\n  ".join([f"Scenario: {self.titled() or 'without a title'}", *lines_of(self)])

    __str__ = __repr__

    def to_toml(self) -> str:
        """Write the TOML file that builds this scenario again, with the meaning of every parameter."""
        return to_toml(self)

    def to_json(self) -> str:
        """Return everything, measured samples included, as one line of JSON."""
        marks = dict[str, Samples]()

        def mark(samples: Samples) -> str:
            marks[samples.sha256] = samples
            return samples.sha256

        text = json.dumps({"schema": SCHEMA} | self.to_dict(), default=mark)
        for each, samples in marks.items():  # afterwards: json looks for characters to escape in every text
            text = text.replace(each, samples.packed())
        return text


_MOST_CHANGES = 3
"""Changes that a title lists."""


def _changes(now: Any, before: Any, path: str, quantity: Quantity | None) -> Iterator[tuple[str, str]]:
    """Yield path and text of the innermost parts that differ."""
    if isinstance(now, Model) and type(now) is type(before):
        parts, former = dict(now), dict(before)
        for name in [each for each in {**former, **parts} if each not in {"title", "sources"}]:
            inner = f"{path}.{name}" if path else name
            yield from _changes(parts.get(name), former.get(name), inner, quantity_of(type(now), name))
    elif now != before and quantity is not None and now is not None:
        yield path, format_quantity(now, quantity.unit, digits=4)
    elif now != before:
        yield path, now if isinstance(now, str) else "none" if now is None else _text(now).removesuffix("()")


def lines_of(model: Model) -> Iterator[str]:
    """Write the parts of a model that are not the default, one line each; of a stack one line for each layer."""
    fields = type(model).model_fields
    for name, value in model:
        if not isinstance(value, Model) or (name in fields and fields[name].default == value):
            continue
        layers = getattr(value, "layers", None)
        if isinstance(layers, dict):
            yield from (f"{name}.{layer}: {in_words(part)}" for layer, part in layers.items())
        else:
            yield f"{name}: {in_words(value)}"


def in_words(model: Model) -> str:
    """Write a model in one line, its parameters that are not the default: ``Trapezium(high = 100 V, rise = 1 ms)``."""
    kind = type(model)
    given = []
    for name, value in model:
        field = kind.model_fields.get(name)
        if value is None or (field is not None and field.default == value):
            continue
        quantity = quantity_of(kind, name)
        given.append(
            f"{name} = {format_quantity(value, quantity.unit, digits=4) if quantity else _text(value)}"
        )
    return f"{kind.__name__}({', '.join(given)})"


def _text(value: Any) -> str:
    if isinstance(value, Model):
        return in_words(value)
    if isinstance(value, Samples):
        return str(value)
    if isinstance(value, tuple):
        return f"({', '.join(map(_text, value))})"
    return repr(value) if isinstance(value, str) else str(value)


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


def moistened(scenario: Scenario, moisture: Moisture) -> dict[str, float]:
    """Return the changes that bring a scenario to a moisture, for `Scenario.replace`; only of parameters that it has."""
    found = {}
    known = {path for path, _, _ in scenario.parameters()}
    skin, gap = _skin(scenario), scenario.stack.gap_name
    for name, piece in skin.items():
        found[f"stack.{name}.material.conductivity"] = moisture.skin_conductivity(piece.thickness)
    for name in ("conductivity", "spot_conductivity") if gap else ():
        found[f"stack.{gap}.material.{name}"] = 1 / moisture.gap_resistivity()
    for where in ("friction", "friction.steady"):
        found[f"{where}.coefficient"] = moisture.coefficient()
    return {path: value for path, value in found.items() if path in known}


def _skin(scenario: Scenario) -> dict[str, Layer]:
    """Return the pieces of the layer that moisture acts on, that of the finger at the interface, each as thick as all of it."""
    roles = scenario.stack.roles
    finger = {name: layer for name, layer in scenario.stack.layers.items() if roles[name] == "finger"}
    whole = in_one_piece(finger)
    return {name: whole[name] for slab in pieces(finger)[:1] for name in slab}


def moisture_diagnostic(scenario: Scenario) -> Diagnostic | None:
    """List the values that moisture has set, in place of those in the tables, and what has no value to set."""
    if scenario.moisture is None:
        return None
    units = {path: quantity.unit for path, _, quantity in scenario.parameters()}
    moved = moistened(scenario, scenario.moisture)
    shown = ", ".join(f"{path} = {format_quantity(value, units[path])}" for path, value in moved.items())
    text = f"moisture.level = {scenario.moisture.level:g} sets {shown or 'nothing'}"
    skin, gap = (f"stack.{name}." for name in (next(iter(_skin(scenario)), None), scenario.stack.gap_name))
    starts = {skin: "the skin", gap: "the gap", "friction": "friction"}
    idle = [name for start, name in starts.items() if not any(path.startswith(start) for path in moved)]
    if idle:
        text += f"; this scenario has no parameter of {' and '.join(idle)} that moisture sets"
    return Diagnostic("moisture", "warning" if idle else "ok", text)


def refuse_what_moisture_sets(scenario: Scenario, changes: Collection[str]) -> None:
    """Refuse changes that moisture would undo."""
    moisture = scenario.moisture
    undone = [] if moisture is None else [path for path in moistened(scenario, moisture) if path in changes]
    if undone:
        raise InputError(
            f"{path}: is set by moisture. Change moisture.level or its dry and wet values, or omit the table [moisture]"
            for path in undone
        )
