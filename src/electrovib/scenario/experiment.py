"""An experiment as one frozen tree of models."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Annotated, Any, ClassVar, Self

from pydantic import Field, model_validator

from electrovib.core.changes import stored_changes
from electrovib.core.errors import Problem
from electrovib.core.model import Model, read_model
from electrovib.core.tables import put
from electrovib.physics.circuit import Circuit
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.finger import Finger
from electrovib.physics.force import ForceLaw, needed_layer, wanted_layer
from electrovib.physics.friction import Friction, Load
from electrovib.physics.limits import Limits
from electrovib.physics.moisture import Moisture
from electrovib.physics.motion import HeldOff, Motion
from electrovib.physics.perception import Perception
from electrovib.physics.rig import Rig
from electrovib.physics.stack import Stack
from electrovib.scenario.files import read_part
from electrovib.scenario.grids import FrequencyGrid, TimeGrid
from electrovib.scenario.in_words import lines_of
from electrovib.scenario.moisture import moistened, refuse_what_moisture_sets
from electrovib.scenario.offers import with_offers
from electrovib.scenario.parts import how_to_add, with_parts
from electrovib.scenario.sources import BY_THE_USER
from electrovib.scenario.toml import SCHEMA, to_toml


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
    sources: Annotated[dict[str, str], Field(description="source of each value, by its dotted path")] = Field(
        default_factory=dict
    )

    @classmethod
    def complete(cls, content: dict[str, Any]) -> dict[str, Any]:
        """Replace names of what papers offer by its tables, and note the source of each value."""
        if isinstance(content.get("stack"), Stack):
            return content  # nothing else can be a name
        content, told = with_offers(content)
        given = content.get("sources", {})
        return content | {"sources": told | given} if told and isinstance(given, dict) else content

    @model_validator(mode="after")
    def _law_finds_its_layers(self) -> Self:
        roles = self.stack.roles
        for wanted in self.force.needs:
            if needed_layer(roles, wanted) is None:
                raise ValueError(f"{type(self.force).__name__} needs {wanted_layer(wanted)}")
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
            content = self.to_dict()
            put(content, moistened(self, self.moisture))
            object.__setattr__(self, "stack", read_model(Stack, content["stack"]))
            friction = read_model(Friction, content["friction"])  # type: ignore[type-abstract]
            object.__setattr__(self, "friction", friction)
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
    def put_into(
        cls, content: dict[str, Any], changes: Mapping[str, Any], *, strict: bool = True
    ) -> list[Problem]:
        """Put changes into tables of a scenario; optional parts that they lead into are added."""
        changes, problems = with_parts(cls, content, changes)
        for problem in put(content, changes, strict=strict):
            how = how_to_add(cls, content, problem.path)
            problems.append(Problem(how, path=problem.path) if how else problem)
        return problems

    @classmethod
    def how_to_add(cls, content: Mapping[str, Any], path: str) -> str:
        """Explain how to add the layer or table that a dotted path leads into; empty where it leads into none."""
        return how_to_add(cls, content, path)

    def to_change(self, changes: Mapping[str, Any]) -> dict[str, Any]:
        """Return the nested tables of the parts that changes lead into; the other parts stay the models that they are."""
        return self.opened({path.split(".")[0] for path in changes})

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
        stored, problems = stored_changes(self, changes)
        if problems:
            return Model.replace(self, changes)  # which refuses them, with every other mistake
        changes, told = with_offers(stored)
        changed = Model.replace(self, changes)
        if changed.moisture is not None:
            refuse_what_moisture_sets(changed, changes)
        kept = {
            path: text
            for path, text in self.sources.items()
            if not any(
                path == change or path.startswith(f"{change.removesuffix('.model')}.") for change in changes
            )
        }
        paths = [path for path, _, _ in changed.parameters()]
        theirs = {
            path: f"{BY_THE_USER} to {told[path]}" if path in told else BY_THE_USER
            for path in dict.fromkeys([*paths, *told])
            if any(path == change or path.startswith(f"{change}.") for change in changes)
        }
        return changed.model_copy(update={"sources": kept | theirs})

    def __repr__(self) -> str:
        """Write title and parts, a line each; those that keep their default are omitted."""
        return "\n  ".join([f"Scenario: {self.title or 'without a title'}", *lines_of(self)])

    __str__ = __repr__

    def to_toml(self) -> str:
        """Write the TOML file that builds this scenario again, with the meaning of every parameter."""
        return to_toml(self)

    def to_json(self) -> str:
        """Return everything, measured samples included, as one line of JSON."""
        return json.dumps({"schema": SCHEMA} | self.to_dict(), default=lambda samples: samples.packed())
