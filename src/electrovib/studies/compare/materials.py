"""One scenario with a layer of different materials: attraction, field and breakdown strength of each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from electrovib.core.answer import Answer, Document, Drawing, Table
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import STATES, Diagnostic, read_diagnostics
from electrovib.core.errors import ElectrovibError, InputError, gathered, nearest, refuse
from electrovib.core.units import format_quantity
from electrovib.physics.material import Material
from electrovib.physics.material.library import UNVERIFIED, find_substance, materials
from electrovib.physics.safety import FILM, GAP_CLOSED
from electrovib.physics.stack import in_one_piece
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.assumptions import SETTLED_CHARGE
from electrovib.solve.quantities.answer import validity
from electrovib.solve.simulate import simulate
from electrovib.studies.check.result import breakdown_row
from electrovib.studies.compare.coatings import (
    MOST,
    OF_PEOPLE,
    Coating,
    coating_figure,
    coatings_of,
    recommended,
)

AS_IT_IS: Final = "as it is"
"""Name of the entry with the scenario's own material."""
_FREQUENCY = 1e3
"""At which permittivities are compared [Hz]."""
HEADINGS: Final = (
    "material",
    "permittivity at 1 kHz",
    "relaxation",
    "largest attraction",
    "largest field",
    "strength",
    "margin",
    "margin, gap closed",
    "breakdown",
    "source status",
)


@dataclass(frozen=True, kw_only=True)
class MaterialEntry:
    """A scenario with one material in a layer.

    - `name`: of the material; `AS_IT_IS` for the scenario's own.
    - `permittivity`: real relative permittivity at 1 kHz, without conduction.
    - `relaxation_time`: permittivity over conductivity [s]; infinite without conduction.
    - `force`: largest electrostatic attraction of the run [N].
    - `field`, `strength`: largest absolute field in the layer, and the breakdown strength it is compared with
      [V/m]; `margin`: strength over field; `closed_margin`: the same while a ridge or sweat closes the gap, so that the films
      have the whole voltage of the plate. All are NaN where no strength is known.
    - `breakdown`, `why`: the worse of both states, ``"ok"``, ``"unknown"`` or ``"warning"``, and its text.
    - `status`: statuses of the sources of the values taken from the library, the strength included.
    - `caution`: warning that the charge in the layer has relaxed for longer than an experiment lasts; empty
      without it.
    """

    name: str
    permittivity: float
    relaxation_time: float
    force: float
    field: float
    strength: float
    margin: float
    closed_margin: float
    breakdown: str
    status: str
    why: str
    caution: str


@dataclass(frozen=True, kw_only=True, repr=False)
class MaterialComparison(Answer):
    """Materials of one layer, compared.

    - `scenario`, `layer`: as it was given, and the layer whose material is exchanged.
    - `entries`: the scenario's own material first, the others from the largest to the smallest attraction.
    - `left_out`: material to why the scenario does not run with it.
    - `tables`: the same as text.
    - `coatings`: force over fingers and margins of each, from the largest force on; of up to five materials that are named.
    """

    scenario: Scenario
    layer: str
    entries: tuple[MaterialEntry, ...]
    left_out: dict[str, str]
    tables: tuple[Table, ...]
    coatings: tuple[Coating, ...] = ()

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario as it was given."""
        return validity(self.scenario)

    @property
    def document(self) -> Document:
        """The tables; of a few coatings which one to take, with force and margins, on one screen."""
        title = f"Materials compared: {self.scenario.titled() or 'a stack'}"
        whole = Document(title=title, sentences=[], diagnostics=self.diagnostics, tables=self.tables)
        if not self.coatings:
            return whole
        stack = Drawing(
            id="stack",
            title=f"Stack; '{self.layer}' is exchanged",
            plot="stack",
            of=self.scenario,
            size=(4.6, 3.0),
        )
        figures, said = [stack, coating_figure(self.coatings)], recommended(self.coatings)
        return replace(whole, sentences=said, figures=figures, alone="coatings", one_screen=True)


def compare_materials(
    scenario: Source, *, layer: str = "", materials: Sequence[str] | None = None
) -> MaterialComparison:
    """Run a scenario with different materials in one layer of the same thickness.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`.
    layer : str
        Name of the layer; the only one of the plate if empty.
    materials : sequence of str, optional
        Names of the library, or ``author_year/name`` of papers; the whole library if absent.

    Returns
    -------
    MaterialComparison
        Attraction, field, strength and margin of each.

    Raises
    ------
    InputError
        For a layer or a material that does not exist, or if the scenario runs with none of them.

    Examples
    --------
    >>> found = ev.compare_materials("bau_2010/sine", materials=["silica", "pet"])
    >>> [f"{each.name}: {1e3 * each.force:.4g} mN" for each in found.entries]
    ['as it is: 387.2 mN', 'silica: 387.2 mN', 'pet: 373.6 mN']
    """
    given = read_scenario(scenario)
    chosen = layer_of_plate(given, layer)
    entries, left_out, cases = [], dict[str, str](), dict[str, Scenario]()
    wanted = known_materials() if materials is None else dict.fromkeys(materials)
    if not wanted:
        raise InputError(f"no material is named; known: {', '.join(known_materials())}")
    for name, material in {AS_IT_IS: "", **named_materials(wanted)}.items():
        try:
            cases[name] = with_material(given, chosen, material) if material else given
            entries.append(_entry(name, cases[name], chosen))
        except ElectrovibError as error:
            left_out[name] = str(error)
    if not entries:
        raise InputError(f"no material can be compared here. {name}: {why}" for name, why in left_out.items())
    coatings: tuple[Coating, ...] = ()
    if materials is not None and len(wanted) <= MOST:
        compared = {name: case for name, case in cases.items() if name not in {AS_IT_IS, *left_out}}
        try:
            coatings = coatings_of(compared, chosen)
        except ElectrovibError as error:  # such as a stack without skin, in which people do not differ
            left_out[OF_PEOPLE] = str(error)
    entries.sort(key=lambda entry: (entry.name != AS_IT_IS, -entry.force))
    return MaterialComparison(
        scenario=given,
        layer=chosen,
        entries=tuple(entries),
        left_out=left_out,
        tables=_tables(chosen, given, entries, left_out),
        coatings=coatings,
    )


def known_materials() -> list[str]:
    """Return the names of the library."""
    return [each.name for each in materials()]


def layer_of_plate(scenario: Scenario, layer: str) -> str:
    """Find the layer whose material is exchanged: the only one of the plate if no name is given."""
    plate = [name for name, role in scenario.stack.roles.items() if role == "plate"]
    known = scenario.stack.layers
    if layer and layer not in known:
        raise InputError(f"layer '{layer}': the stack has none of this name.{nearest(layer, known)}")
    if not layer and len(plate) != 1:
        has = f"has {len(plate)} layers of the plate" if plate else "has no layer of the plate"
        raise InputError(
            f"layer: the stack {has}: name the layer whose material is exchanged, of {', '.join(known)}"
        )
    return layer or plate[0]


def named_materials(names: Iterable[str]) -> dict[str, str]:
    """Return materials by the names that the library gives them; every one that is unknown or named twice is refused."""
    problems, found = list[str](), dict[str, str]()
    for text in names:
        name = " ".join(text.split())
        with gathered(problems):
            Material.offer(name)
            shown = getattr(find_substance(name), "name", name)
            if shown in found:
                raise InputError(f"materials: '{name}' is named twice")
            found[shown] = name
    refuse(problems)
    return found


def with_material(scenario: Scenario, layer: str, name: str) -> Scenario:
    """Return the scenario with a material in a layer, without the breakdown field that belongs to its own material."""
    changes: dict[str, str | None] = {f"stack.{layer}.material": name}
    if scenario.stack.layers[layer].breakdown_field is not None:
        changes |= {f"stack.{layer}.breakdown_field": None}
    return scenario.replace(changes)


def _entry(name: str, scenario: Scenario, layer: str) -> MaterialEntry:
    """Run the scenario with one material."""
    material = scenario.stack.layers[layer].material
    permittivity = float(material.bound_permittivity(np.array(_FREQUENCY)).real)
    trace = simulate(scenario)
    title = f"{FILM}, {layer}"
    diagnostics = {each.name: each for each in read_diagnostics(trace.attrs["validity"])}
    rows = [breakdown_row(diagnostics[each]) for each in (title, title + GAP_CLOSED) if each in diagnostics]
    first = rows[0] if rows else None
    worst = max(
        (diagnostics[row.quantity] for row in rows), key=lambda each: STATES.index(each.state), default=None
    )
    margins = [math.nan if row.margin is None else row.margin for row in rows]
    conductivity = material.conductivity
    return MaterialEntry(
        name=name,
        permittivity=permittivity,
        relaxation_time=eps0 * permittivity / conductivity if conductivity else math.inf,
        force=float(np.nanmax(trace.electrostatic_force.values)),
        field=math.nan if first is None or first.value is None else first.value,
        strength=math.nan if first is None or first.limit is None else first.limit,
        margin=margins[0] if margins else math.nan,
        closed_margin=margins[-1] if margins else math.nan,
        breakdown="unknown" if worst is None else worst.state,
        status=_status(scenario, layer),
        why="" if worst is None else worst.text,
        caution=diagnostics[SETTLED_CHARGE].text if SETTLED_CHARGE in diagnostics else "",
    )


def _status(scenario: Scenario, layer: str) -> str:
    """List the statuses of the values that a layer takes from the library, for a material of the library."""
    slab = in_one_piece(scenario.stack.layers)[layer]
    substance = None if slab.material.substance is None else find_substance(slab.material.substance)
    if substance is None:
        return "of the scenario"
    strength = substance.strength_of(slab.thickness)
    taken = {
        what if what == "conductivity" else "permittivity": status
        for what, status in substance.taken_by(slab.material.to_dict()).items()
    }
    taken |= {} if strength is None else {"strength": strength.status}
    by_status: dict[str, list[str]] = {}
    for what, status in taken.items():
        by_status.setdefault(status, []).append(what)
    return "; ".join(f"{status}: {', '.join(parts)}" for status, parts in by_status.items())


def _tables(
    layer: str, scenario: Scenario, entries: Sequence[MaterialEntry], left_out: dict[str, str]
) -> tuple[Table, ...]:
    rows = tuple(
        (
            entry.name,
            f"{entry.permittivity:.4g}",
            _shown(entry.relaxation_time, "s", endless="no conduction"),
            format_quantity(entry.force, "N", digits=4),
            _shown(entry.field, "V/m"),
            _shown(entry.strength, "V/m"),
            *(
                "not known" if math.isnan(each) else f"{each:.3g}"
                for each in (entry.margin, entry.closed_margin)
            ),
            entry.breakdown,
            entry.status,
        )
        for entry in entries
    )
    thickness = format_quantity(scenario.stack.layers[layer].thickness, "m")
    title = f"Materials of the layer '{layer}', {thickness} thick"
    caption = (
        "Margin: breakdown strength over largest field with the gap as declared; with the gap closed by a ridge or by sweat the"
        f" films have the whole voltage of the plate. '{UNVERIFIED}' values are cited from memory. Relaxation: charge"
        " relaxation time, permittivity over conductivity; a voltage held for much longer reaches the finger through the"
        " layer. 'electrovib list NAME' lists the sources."
    )
    found = [Table(title, HEADINGS, rows, caption=caption)]
    cautions = tuple((entry.name, entry.caution) for entry in entries if entry.caution)
    if cautions:
        found.append(Table("The attraction is reached only after a long time", ("material", "why"), cautions))
    if left_out:
        found.append(Table("Not in this comparison", ("material", "why"), tuple(left_out.items())))
    return tuple(found)


def _shown(value: float, unit: str, *, endless: str = "") -> str:
    if math.isnan(value):
        return "not known"
    return endless if math.isinf(value) else format_quantity(value, unit, digits=3)
