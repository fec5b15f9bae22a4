"""One module for each publication, found automatically: its laws and checks; what it states is data beside it, without Python.

`published/author_year.toml` has citations, status, values, skins, materials, scenarios, checks and quantities,
`measured/author_year.toml` what was measured; both are read as files of a user are. The docstring of a module says what the paper
claims and what it does not. It declares CITATIONS, CITATION, STATUS and CHECKS, which functions of it compute, and by name what
it has to give: laws are subclasses of a family; `skins`, `materials`, `stacks`, `scenarios`, `quantities` and `reproduce` are
functions.
"""

from __future__ import annotations

import functools
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeVar

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from electrovib.core.citation import STATUSES, Check, Citation, cited
from electrovib.core.errors import InputError, located, nearest
from electrovib.core.mistakes import read_entries
from electrovib.core.parsing import read_toml

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real
    from electrovib.physics.material import Material
    from electrovib.physics.skin import Skin
    from electrovib.scenario import Scenario
    from electrovib.scenario.sources import PresetNote
    from electrovib.studies.evidence.quantities import ComputedQuantity

_OURS: Final = f"{__name__}."
Found = TypeVar("Found")


class StatedEntries(BaseModel):
    """Offers of a file, none but those that are declared."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class ValueEntries(StatedEntries):
    """A number of the publication, or an interval."""

    value: float | tuple[float, float] = Field(description="in the unit; of an interval both ends")
    unit: str = Field(description="SI unit; 1 for a plain number")
    meaning: str = Field(description="what it is, and whether it is printed or a choice")


class SkinEntries(StatedEntries):
    """Electrical values of stratum corneum, or of skin that is used in its place."""

    name: str = Field(description="for legends")
    material: dict[str, Any] = Field(description="as in a scenario")
    status: str = Field(description="how the source was read", json_schema_extra={"enum": list(STATUSES)})
    note: str = Field(description="site, assumptions and limits of use")
    source: str = Field("", description="the publication itself if absent")
    reproduces_force: bool = Field(True, description="false where only its time constant may be shown")


class ScenarioEntries(StatedEntries):
    """A set-up of the publication, ready to run."""

    title: str = Field(description="begins with author and year")
    reproduces: str = Field("", description="what it shows of the publication")
    keywords: str = Field("", description="words to be found by that title and stack do not have")
    scenario: str = Field(
        "", description="from which it begins: by its name in this file, or author_year/name"
    )
    changes: dict[str, Any] = Field({}, description="changes of that scenario, by dotted path")
    sources: dict[str, str] = Field(
        {}, description="where a value or a table of values is from, by dotted path"
    )
    unchanged: str = Field("", description="source of what is not changed, which keeps its own if absent")


class CheckEntries(StatedEntries):
    """A number that the publication states, or that follows from it, beside the one that a function of its module computes."""

    name: str = Field(description="what is compared")
    expect: float = Field(description="the number, in SI")
    rtol: float | None = Field(None, description="relative tolerance, from the digits that the source prints")
    within: float | None = Field(None, description="the same as a difference, in the place of `rtol`")
    source: str = Field(description="where the number stands, or from what it follows")
    status: str = Field(
        "derived", description="how that was read", json_schema_extra={"enum": list(STATUSES)}
    )
    compute: str = Field(description="function of the module that computes it")
    given: dict[str, Any] = Field({}, description="what the function takes, by name")
    part: int | None = Field(None, description="which of the numbers that it returns, from 0")


class QuantityEntries(StatedEntries):
    """A quantity of a scenario that measurements of the publication name, and that a function of its module computes."""

    title: str = Field(description="what it is")
    unit: str = Field(description="SI unit; 1 for a plain number")
    compute: str = Field(description="function of the module that computes it")
    given: dict[str, Any] = Field({}, description="what the function takes besides the scenario, by name")


class Stated(StatedEntries):
    """The file of a publication."""

    model_config = ConfigDict(extra="forbid", frozen=True, title="publication")

    schema_: Literal[1] = Field(alias="schema", description="version of this form")
    status: str = Field(description="how it was read", json_schema_extra={"enum": list(STATUSES)})
    citations: tuple[dict[str, Any], ...] = Field(
        description="entries of `electrovib.core.citation.Citation`"
    )
    not_read: str = Field("", description="what was not read of it")
    defects: tuple[str, ...] = Field((), description="where it is at odds with others or with itself")
    values: dict[str, ValueEntries] = Field({}, description="numbers that its laws and checks take, by name")
    materials: dict[str, dict[str, Any] | str] = Field({}, description="materials by name, as in a scenario")
    skins: dict[str, SkinEntries] = Field({}, description="skins by name")
    scenarios: dict[str, ScenarioEntries] = Field({}, description="scenarios by name")
    checks: tuple[CheckEntries, ...] = Field((), description="numbers that its laws are held to")
    quantities: dict[str, QuantityEntries] = Field({}, description="quantities of its measurements by name")


class Offers(Mapping[str, Found]):
    """What a publication gives by name, each built when it is asked for."""

    def __init__(self, names: Iterable[str], build: Callable[[str], Found]) -> None:
        self._names, self._build = tuple(names), build

    def __getitem__(self, name: str) -> Found:
        """Build one."""
        return self._build(name)

    def __contains__(self, name: object) -> bool:
        """Tell whether there is one, without building it."""
        return name in self._names

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._names)

    def __len__(self) -> int:
        """Count the names."""
        return len(self._names)


class Declared(NamedTuple):
    """What the module of every paper declares, in this order."""

    citations: tuple[Citation, ...]
    citation: str
    status: str
    not_read: str
    defects: tuple[str, ...]
    presets: dict[str, PresetNote]


@dataclass(frozen=True, eq=False)
class Published:
    """The file of one publication, with what the module of a paper offers of it."""

    name: str
    stated: Stated

    @property
    def declared(self) -> Declared:
        """Citations, all of them as one text, status, what was not read, defects, and what each scenario shows."""
        from electrovib.scenario.sources import PresetNote

        found = tuple(
            Citation(**each | {"authors": tuple(each.get("authors", ()))}) for each in self.stated.citations
        )
        notes = {
            key: PresetNote(each.reproduces, each.keywords) for key, each in self.stated.scenarios.items()
        }
        return Declared(
            found, cited(found), self.stated.status, self.stated.not_read, self.stated.defects, notes
        )

    def number(self, name: str) -> float:
        """Return a number in SI."""
        return float(self.stated.values[name].value)  # type: ignore[arg-type]

    def interval(self, name: str) -> tuple[float, float]:
        """Return the least and the largest of a number in SI."""
        low, high = self.stated.values[name].value  # type: ignore[misc]
        return low, high

    def checks(self, *functions: Callable[..., Any]) -> tuple[Check, ...]:
        """Return the checks, with the functions of the module that compute them."""
        return tuple(self._check(each, functions) for each in self.stated.checks)

    def quantities(self, *functions: Callable[..., Any]) -> Callable[[], dict[str, ComputedQuantity]]:
        """Return what offers the quantities, with the functions of the module that compute them."""

        def offered() -> dict[str, ComputedQuantity]:
            from electrovib.studies.evidence.quantities import ComputedQuantity

            return {
                name: ComputedQuantity(
                    title=each.title,
                    unit=each.unit,
                    compute=self._computing(each, functions, f"quantities.{name}"),
                )
                for name, each in self.stated.quantities.items()
            }

        return offered

    def _computing(
        self, each: CheckEntries | QuantityEntries, functions: tuple[Callable[..., Any], ...], path: str
    ) -> Callable[..., Any]:
        """Return the function that an entry names, with what is given to it."""
        known = {function.__name__: function for function in functions}
        if each.compute not in known:
            why = f"the module has no such function for it.{nearest(each.compute, known)}"
            raise InputError(why, path=f"{self.name}.{path}.compute", value=each.compute)
        function = known[each.compute]
        return functools.partial(function, **each.given) if each.given else function

    def _check(self, each: CheckEntries, functions: tuple[Callable[..., Any], ...]) -> Check:
        computing = self._computing(each, functions, f"checks.{each.name}")
        with located(f"{self.name}.checks.{each.name}"):
            if (each.rtol is None) == (each.within is None):
                raise InputError("it takes one of rtol and within")
        rtol = (each.within or 0.0) / abs(each.expect) if each.rtol is None else each.rtol

        def compute() -> float:
            found: Any = computing()
            return float(found if each.part is None else found[each.part])

        return Check(
            each.name, expect=each.expect, rtol=rtol, source=each.source, compute=compute, status=each.status
        )

    def materials(self) -> Mapping[str, Material]:
        """Return the materials."""
        stated = self.stated.materials
        return Offers(stated, lambda name: self._material(stated[name], f"materials.{name}"))

    def skins(self) -> Mapping[str, Skin]:
        """Return the skins."""
        return Offers(self.stated.skins, self._skin)

    def scenarios(self) -> Mapping[str, Scenario]:
        """Return the scenarios."""
        return Offers(self.stated.scenarios, functools.partial(_scenario, self))

    def _skin(self, name: str) -> Skin:
        from electrovib.physics.skin import Skin

        each = self.stated.skins[name]
        return Skin(
            name=each.name,
            material=self._material(each.material, f"skins.{name}.material"),
            status=each.status,
            source=each.source or self.declared.citation,
            note=each.note,
            reproduces_force=each.reproduces_force,
        )

    def _material(self, content: Mapping[str, Any] | str, path: str) -> Material:
        from electrovib.physics.material import Material
        from electrovib.scenario.files import read_part

        with located(f"{self.name}.{path}"):
            return read_part(Material, content)  # type: ignore[type-abstract]


@functools.cache
def _scenario(publication: Published, name: str) -> Scenario:
    """Build a scenario after the one with which it begins."""
    from electrovib.scenario import preset

    entries, path = publication.stated.scenarios, f"{publication.name}.scenarios.{name}"
    each, before = entries[name], [name]
    while (begins := entries[before[-1]].scenario) in entries:
        if begins in before:
            raise InputError("it begins with itself", path=f"{path}.scenario")
        before.append(begins)
    base = _scenario(publication, each.scenario) if each.scenario in entries else each.scenario or None
    with located(path):
        return preset(
            base, title=each.title, changes=each.changes, sources=each.sources, unchanged=each.unchanged
        )


def published(module: str) -> Published:
    """Return what a publication states, for the module of its paper, or one inside it, by the name of the module."""
    prefix = _OURS if module.startswith(_OURS) else ""
    name = module.removeprefix(prefix).partition(".")[0]
    whole: Any = sys.modules[f"{prefix}{name}"]
    place = Path(getattr(whole, "__path__", [whole.__file__])[0]).parent
    return read_published(place / "published" / f"{name}.toml")


@functools.cache
def read_published(path: Path) -> Published:
    """Read the file of a publication; every mistake at once."""
    try:
        content = read_toml(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise InputError(str(error), path=path) from None
    with located(path.name):
        return Published(path.stem, read_entries(Stated, content, of="a publication"))


def mean_attraction(scenario: Scenario, frequency: ArrayLike, *, amplitude: float) -> Real:
    """Compute the time mean of the attraction [N] under a sine of this amplitude at each frequency [Hz]."""
    from electrovib.solve.electrics.attraction import mean_force
    from electrovib.solve.stack.expand import phasors

    section = phasors(scenario, np.atleast_1d(np.asarray(frequency, dtype=float)))
    return mean_force(scenario, section, amplitude=amplitude)
