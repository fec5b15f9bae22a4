"""An experiment as one frozen tree of models, read from TOML."""

from __future__ import annotations

import importlib
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Field, model_validator

from electrovib.core.discovery import paper
from electrovib.core.errors import InputError, nearest
from electrovib.core.files import relative_to
from electrovib.core.model import Model, read_model
from electrovib.core.paths import put
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.circuit import Circuit
from electrovib.physics.contact import Contact
from electrovib.physics.drive.base import Drive
from electrovib.physics.finger import Finger
from electrovib.physics.force import ForceLaw
from electrovib.physics.friction import Friction, Load
from electrovib.physics.moisture import Moisture
from electrovib.physics.motion import Motion
from electrovib.physics.perception import Perception
from electrovib.physics.rig import Rig
from electrovib.physics.safety import Limits
from electrovib.physics.stack import Stack
from electrovib.solve.transfer import Real

if TYPE_CHECKING:
    import xarray

SCHEMA = 1
DEFAULT = "vezzoli_2014/fig6"


class InitialState(Model, family=True):
    """What came before time 0."""


class AtRest(InitialState):
    """No field before time 0: the drive is switched on then."""


class PeriodicState(InitialState):
    """The drive has been repeating for ever."""


class TimeGrid(Model):
    """When the result is wanted."""

    duration: Annotated[
        Number | None, Quantity("s", 1e-9, 1e5, "how long; the drive's own length if absent")
    ] = None
    samples: int | None = None
    initial_state: InitialState = AtRest()

    @model_validator(mode="after")
    def _enough(self) -> Self:
        if self.samples is not None and not 2 <= self.samples <= 10**8:
            raise ValueError("samples must be a whole number from 2 to 1e8")
        return self

    def times(self, drive: Drive) -> Real:
        """Even times over the duration; the stamps of a measured drive unless either is given."""
        if self.duration is None and self.samples is None and drive.time_stamps is not None:
            return drive.time_stamps
        return np.linspace(0.0, self.duration or drive.duration, self.samples or 2001)


class FrequencyGrid(Model):
    """Over which frequencies the response is wanted, and over which materials are reduced to Debye terms."""

    low: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "lowest frequency")] = 1.0
    high: Annotated[Number, Quantity("Hz", 1e-6, 1e12, "highest frequency")] = 1e6
    samples: int = 121

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if self.low >= self.high or not 2 <= self.samples <= 10**6:
            raise ValueError("low must be below high, and samples a whole number from 2 to 1e6")
        return self

    def frequencies(self) -> Real:
        """Evenly spaced in the logarithm."""
        return np.geomspace(self.low, self.high, self.samples)


class Scenario(Model):
    """A finger on a plate under a drive: everything that `simulate` needs.

    Notes
    -----
    `title` and `sources` are words for people: they do not enter the hash, nor equality.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "drive": {"model": "Constant", "level": 100},
        "force": {"model": "GapPlane"},
        "friction": {"model": "Coulomb", "coefficient": 0.5},
        "contact": {"model": "FixedArea", "area": 1e-4},
        "load": {"normal_force": 0.5},
        "circuit": Circuit.example,
        "stack": Stack.example,
    }

    title: str = ""
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
    sources: dict[str, str] = Field(default_factory=dict)

    @model_validator(mode="after")
    def _law_finds_its_layers(self) -> Self:
        for name in self.force.needs:
            if name not in self.stack.layers:
                known = nearest(name, self.stack.layers)
                raise ValueError(f"{type(self.force).__name__} needs a layer 'stack.{name}'.{known}")
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
    def _moistened(self) -> Self:
        """Let moisture set what it moves, so that every table shows what was computed with."""
        if self.moisture is not None:
            from electrovib.solve.moisture import moistened

            content = self.to_dict()
            put(content, moistened(self, self.moisture))
            object.__setattr__(self, "stack", read_model(Stack, content["stack"]))
            object.__setattr__(self, "friction", read_model(Friction, content["friction"]))
        return self

    @model_validator(mode="after")
    def _charge_sits_on_one_contact(self) -> Self:
        charged = [name for name, layer in self.stack.layers.items() if layer.initial_charge]
        if charged and self.circuit.return_path.second_contact(1.0):
            raise ValueError(
                f"stack.{charged[0]}.initial_charge goes with one contact only: with a SecondElectrode it would have to be"
                " told for both; remove the charge, or use another return path"
            )
        return self

    @property
    def contact_area(self) -> float:
        """Gross contact area under the full load [m2]."""
        return self.contact.gross_area(self.load.normal_force)

    def canonical(self) -> str:
        """Write the canonical JSON of the physics, without the words for people."""
        content = self.model_copy(update={"title": "", "sources": {}})
        return Model.canonical(content)

    def replace(self, changes: Mapping[str, Any]) -> Self:
        """Give a copy with some parameters changed, and their sources marked as the user's.

        Parameters
        ----------
        changes : mapping of str to value
            Dotted path to number, text with a unit, or table.

        Returns
        -------
        Scenario
            Validated.

        Raises
        ------
        InputError
            Every mistake at once.
        """
        changed = Model.replace(self, changes)
        kept = {
            path: text
            for path, text in self.sources.items()
            if not any(
                path == change or path.startswith(f"{change.removesuffix('.model')}.") for change in changes
            )
        }
        paths = [path for path, _, _ in changed.parameters()]
        theirs = {
            p: "set by the user" for p in paths if any(p == c or p.startswith(f"{c}.") for c in changes)
        }
        return changed.model_copy(update={"sources": kept | theirs})

    def to_json(self) -> str:
        """Write everything, measured samples included, as one line of JSON."""
        return json.dumps({"schema": SCHEMA} | self.to_dict(), default=lambda samples: samples.packed())


def load(source: str | Path | Mapping[str, Any], *, changes: Mapping[str, Any] | None = None) -> Any:
    """Read a scenario or a Trace, whatever the source holds.

    Parameters
    ----------
    source : str, Path or mapping
        A TOML file, a Trace file (``.nc``, ``.csv``, ``.mat``), a paper's scenario such as
        ``"vezzoli_2014/fig6"``, or nested tables.
    changes : mapping of str to value, optional
        Dotted path to value, put into the scenario; a file named here is looked for from the working folder.

    Returns
    -------
    Scenario or xarray.Dataset
        A Scenario from TOML, a paper or tables; a Trace from a Trace file, or with `changes` its scenario.

    Raises
    ------
    InputError
        Every mistake of the file at once.
    """
    if isinstance(source, Mapping):
        return _read({"schema": SCHEMA} | dict(source), changes, Path())
    path = Path(source)
    if path.suffix in {".nc", ".csv", ".mat"}:
        trace = _load_trace(path)
        return scenario_of(trace).replace(changes) if changes else trace
    if path.suffix == ".toml" or path.exists():
        return _read(_tables(path), changes, path.parent)
    scenario = paper_scenario(str(source))
    return scenario.replace(changes) if changes else scenario


def _read(content: dict[str, Any], changes: Mapping[str, Any] | None, folder: Path) -> Scenario:
    """Build a scenario; changes may mend what is wrong in the tables."""
    content = _without_schema(content)
    try:
        with relative_to(folder):
            scenario = read_model(Scenario, content)
    except InputError:
        if not changes:
            raise
        put(content, _beside(changes, folder), strict=False)
        with relative_to(folder):
            return read_model(Scenario, content)
    return scenario.replace(changes) if changes else scenario


def _beside(changes: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Write files that the caller names as seen from the scenario's folder."""
    found = dict(changes)
    for path, value in changes.items():
        if path.rpartition(".")[2] == "file" and isinstance(value, str):
            found[path] = os.path.relpath(value, folder)
    return found


def load_scenario(source: str | Path | Mapping[str, Any] | Scenario) -> Scenario:
    """Read a scenario from anything that has one, a Trace included.

    Raises
    ------
    InputError
        If the source has no scenario.
    """
    if isinstance(source, Scenario):
        return source
    found = load(source)
    return found if isinstance(found, Scenario) else scenario_of(found)


def scenario_of(trace: xarray.Dataset) -> Scenario:
    """Give back the scenario a Trace carries.

    Raises
    ------
    InputError
        If it carries none, as a measurement does.
    """
    if "scenario" not in trace.attrs:
        raise InputError("this Trace carries no scenario: it is a measurement, or was made by something else")
    return read_model(Scenario, _without_schema(json.loads(trace.attrs["scenario"])))


def _load_trace(path: Path) -> xarray.Dataset:
    from electrovib.data.traces import load_csv, load_nc

    if path.suffix == ".mat":
        reader = importlib.import_module("electrovib.export.matlab")  # found late: a door, not a part
        found: xarray.Dataset = reader.load_mat(path)
        return found
    return load_nc(path) if path.suffix == ".nc" else load_csv(path)


def _tables(path: Path) -> dict[str, Any]:
    import tomllib

    try:
        text = path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{path}: {error.strerror or error}. Give a .toml file or a paper, for instance {DEFAULT}"
        ) from None
    except UnicodeDecodeError:
        raise InputError(f"{path}: not a text file; a scenario is TOML") from None
    if not text.strip():
        raise InputError(f"{path}: the file is empty. 'electrovib init {DEFAULT}' prints one to start from")
    try:
        return tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError(f"{path}: not valid TOML: {error}") from None


def _without_schema(content: dict[str, Any]) -> dict[str, Any]:
    schema = content.pop("schema", None)
    if schema != SCHEMA:
        raise InputError(
            f"schema = {schema!r}: this version reads 'schema = {SCHEMA}'; write it as the first line"
        )
    return content


def paper_scenario(name: str) -> Scenario:
    """Find a paper's scenario by ``author_year/name``.

    Raises
    ------
    InputError
        With the nearest name.
    """
    author_year, _, wanted = name.partition("/")
    module = paper(author_year)
    found: Mapping[str, Scenario] = module.scenarios() if hasattr(module, "scenarios") else {}
    if not found:
        raise InputError(f"'{author_year}' has no scenario")
    if wanted not in found:
        raise InputError(f"'{name}': {author_year} has no scenario '{wanted}'.{nearest(wanted, found)}")
    return found[wanted]
