"""One scenario with a layer of different materials: attraction, field, breakdown strength; which coating is recommended."""

from __future__ import annotations

import functools
import itertools
import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np

from electrovib.core.answer import Answer, Document, Drawing, Table
from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import STATES, Diagnostic, diagnostics_of
from electrovib.core.errors import ElectrovibError, InputError, computed_or_refused, gathered, nearest, refuse
from electrovib.core.units import format_quantity
from electrovib.physics.material import Material
from electrovib.physics.material.library import UNVERIFIED, find_substance, materials
from electrovib.physics.safety import FILM, GAP_CLOSED
from electrovib.physics.stack import in_one_piece
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.scenario.space import read_space
from electrovib.solve.diagnostics.assumptions import SETTLED_CHARGE
from electrovib.solve.prepare import Prepared
from electrovib.solve.quantities.answer import validity
from electrovib.solve.simulate import simulate
from electrovib.studies.check import CheckResult, checked
from electrovib.studies.check.amplifier import LARGEST, without_its_limits
from electrovib.studies.check.result import ASKED, FAIL, PASS, breakdown_row
from electrovib.studies.widths import TYPICAL_FACTORS, law_width, quantile_ranks

AS_IT_IS: Final = "as it is"
"""Name of the entry with the scenario's own material."""
_FREQUENCY = 1e3
"""At which permittivities are compared [Hz]."""


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
    wanted = known_materials() if materials is None else dict.fromkeys(materials)
    if not wanted:
        raise InputError(f"no material is named; known: {', '.join(known_materials())}")

    def run(name: str, material: str) -> tuple[Scenario, MaterialEntry]:
        case = with_material(given, chosen, material) if material else given
        return case, _entry(name, case, chosen)

    found, left_out = computed_or_refused({AS_IT_IS: "", **named_materials(wanted)}, run)
    if not found:
        raise InputError(f"no material can be compared here. {name}: {why}" for name, why in left_out.items())
    coatings: tuple[Coating, ...] = ()
    if materials is not None and len(wanted) <= MOST:
        compared = {name: case for name, (case, _) in found.items() if name != AS_IT_IS}
        try:
            coatings = coatings_of(compared, chosen)
        except ElectrovibError as error:  # such as a stack without skin, in which people do not differ
            left_out[OF_PEOPLE] = str(error)
    entries = [entry for _, entry in found.values()]
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
    diagnostics = {each.name: each for each in diagnostics_of(trace)}
    films = [diagnostics[each] for each in (title, title + GAP_CLOSED) if each in diagnostics]
    films = films or [Diagnostic(title, "unknown", "")]
    worst = max(films, key=lambda each: STATES.index(each.state))
    margins = [breakdown_row(each).margin for each in films]
    conductivity = material.conductivity
    return MaterialEntry(
        name=name,
        permittivity=permittivity,
        relaxation_time=eps0 * permittivity / conductivity if conductivity else math.inf,
        force=float(np.nanmax(trace.electrostatic_force.values)),
        field=_or_nan(films[0].value),
        strength=_or_nan(films[0].limit),
        margin=_or_nan(margins[0]),
        closed_margin=_or_nan(margins[-1]),
        breakdown=worst.state,
        status=_status(scenario, layer),
        why=worst.text,
        caution=diagnostics[SETTLED_CHARGE].text if SETTLED_CHARGE in diagnostics else "",
    )


def _or_nan(value: float | None) -> float:
    return math.nan if value is None else value


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
    columns: dict[str, Callable[[MaterialEntry], str]] = {
        "material": lambda entry: entry.name,
        "permittivity at 1 kHz": lambda entry: f"{entry.permittivity:.4g}",
        "relaxation": lambda entry: _shown(entry.relaxation_time, "s", endless="no conduction"),
        "largest attraction": lambda entry: format_quantity(entry.force, "N", digits=4),
        "largest field": lambda entry: _shown(entry.field, "V/m"),
        "strength": lambda entry: _shown(entry.strength, "V/m"),
        "margin": lambda entry: _margin_words(entry.margin),
        "margin, gap closed": lambda entry: _margin_words(entry.closed_margin),
        "breakdown": lambda entry: entry.breakdown,
        "source status": lambda entry: entry.status,
    }
    thickness = format_quantity(scenario.stack.layers[layer].thickness, "m")
    title = f"Materials of the layer '{layer}', {thickness} thick"
    caption = (
        "Margin: breakdown strength over largest field with the gap as declared; with the gap closed by a ridge or by sweat the"
        f" films have the whole voltage of the plate. '{UNVERIFIED}' values are cited from memory. Relaxation: charge"
        " relaxation time, permittivity over conductivity; a voltage held for much longer reaches the finger through the"
        " layer. 'electrovib list NAME' lists the sources."
    )
    found = [Table.of(title, entries, columns, caption=caption)]
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


SHARE: Final = 0.9
"""Of the people, who have at least the force that is stated."""
PEOPLE, DRAWS, SEED = "fingers", 200, 0
"""Population, number of its fingers that are drawn, and their seed."""
FORCE: Final = "peak electrostatic_force"
OF_PEOPLE: Final = f"force for {100 * SHARE:g} % of the people"
"""What is not in a comparison of stacks in which people do not differ."""
MARGINS: Final = ("gap open", "gap closed", "amplifier")
_SIGNS: Final[tuple[dict[str, Any], ...]] = (
    {"marker": "o", "markersize": 10, "markerfacecolor": "none"},
    {"marker": "s", "markersize": 5},
    {"marker": "^"},
)
MOST: Final = 5
"""Coatings that are compared for people."""


@dataclass(frozen=True, kw_only=True)
class Coating:
    """One coating: `force` over the fingers in ascending order [N], and `check` of the scenario with it."""

    name: str
    layer: str
    force: Real
    check: CheckResult

    @property
    def for_most(self) -> tuple[float, float, float]:
        """Force that 90 % of the fingers have at least, between the ends of its 95 % interval [N]."""
        ranks = quantile_ranks(1 - SHARE, len(self.force))
        low, high = (self.force[min(max(rank, 1), len(self.force)) - 1] for rank in ranks)
        return float(low), float(np.quantile(self.force, 1 - SHARE)), float(high)

    @property
    def margins(self) -> tuple[float, float, float]:
        """Limit over value of the film with the gap open and closed, and of the amplifier; NaN where one is not known."""
        film = f"{FILM}, {self.layer}"
        known = {row.quantity: row.margin for row in self.check.rows if row.margin is not None}
        amplifier = [margin for name, margin in known.items() if name.startswith(ASKED)]
        open_gap = known.get(film, math.nan)
        return open_gap, known.get(film + GAP_CLOSED, open_gap), min(amplifier, default=math.nan)


def coatings_of(cases: dict[str, Scenario], layer: str) -> tuple[Coating, ...]:
    """Compute force and margins of each coating, by the scenario with it."""
    found = []
    for name, case in cases.items():
        space = read_space(case, PEOPLE)
        whole = without_its_limits(case, LARGEST)  # with them every finger would be marched by itself
        force = Prepared(whole, free=space.paths, quantity=[FORCE])(space.draw(SEED, 0, DRAWS))[FORCE]
        if not np.isfinite(force).all():
            raise InputError(
                f"{name}: the force is not known of {np.sum(~np.isfinite(force))} of {DRAWS} fingers"
            )
        found.append(Coating(name=name, layer=layer, force=np.sort(force), check=checked(case)))
    return tuple(sorted(found, key=lambda each: -each.for_most[1]))


def recommended(coatings: Sequence[Coating]) -> list[str]:
    """Recommend one coating with the reason, or say why none is."""
    safe = [each for each in coatings if each.check.state == PASS]
    best = (safe or coatings)[0]
    low, force, high = (format_quantity(each, "N", digits=3) for each in best.for_most)
    margins = ", ".join(
        f"{name} {_margin_words(each)}" for name, each in zip(MARGINS, best.margins, strict=True)
    )
    if safe:
        head = f"Take {best.name}: {'the only one' if len(safe) == 1 else 'the most force of those'} within all limits."
    elif all(each.check.state == FAIL for each in coatings):
        head = "Take none: each exceeds a limit."
    else:
        head = "Take none yet: no coating is shown to be safe."
    amplifier = best.check.scenario.circuit.amplifier
    more = " Limits are judged with the finger of the scenario."
    more += " The force is without the limits of the amplifier." if amplifier and amplifier.is_limited else ""
    more += "" if safe else f" It is {best.check.headline}."
    reason = (
        f"{best.name}, {'chosen' if safe else 'with the most force'}: 90 % of the people have at least {force} ({low} to {high},"
        f" 95 % interval for {DRAWS} drawn fingers). Limit over value: {margins}.{more}"
    )
    more_force = [
        f"{each.name} gives {format_quantity(each.for_most[1], 'N', digits=3)}, but is {each.check.headline}."
        for each in coatings[: coatings.index(best)]
    ]
    law = type(best.check.scenario.force).__name__
    return [head, reason, *more_force, law_width(law, TYPICAL_FACTORS.get(law)).sentence]


def _margin_words(margin: float) -> str:
    """Write a margin, or that it is not known."""
    return "not known" if math.isnan(margin) else f"{margin:.3g}"


def coating_figure(coatings: Sequence[Coating]) -> Drawing:
    """Show force and margins."""
    return Drawing(
        id="coatings",
        title=f"{OF_PEOPLE.capitalize()}, and margins",
        plot=functools.partial(_draw, coatings=coatings),
        size=(9.4, 1.5 + 0.55 * len(coatings)),
        caption=f"Left: peak attraction that 90 % of {DRAWS} drawn fingers have at least (dot), and 90 % of the fingers (bar)."
        " Right: limit over value; left of 1 it is exceeded, and what is not known has no sign.",
    )


def _draw(figure: Any, *, coatings: Sequence[Coating]) -> None:
    """Draw the force over the fingers, and the margins, of each coating in its colour."""
    from matplotlib.ticker import EngFormatter

    left, right = figure.subplots(1, 2)
    for place, each in enumerate(coatings):
        force, colour = each.for_most[1], f"C{place}"
        left.plot(np.quantile(each.force, [0.05, 0.95]), [place, place], color=colour, linewidth=5, alpha=0.3)
        left.plot(force, place, "o", color=colour)
        above = {"xytext": (0, 7), "textcoords": "offset points", "ha": "left"}
        left.annotate(format_quantity(force, "N", digits=3), (force, place), **above)
        for margin, sign in zip(each.margins, _SIGNS, strict=True):
            right.plot(margin, place, color=colour, linestyle="none", **sign)
    left.plot([], [], color="#555555", linewidth=5, alpha=0.3, label="90 % of the fingers")
    left.plot([], [], "o", color="#555555", label="90 % have at least")
    left.legend(loc="upper left", bbox_to_anchor=(0.0, -0.25), ncols=2)
    known = [
        not all(map(math.isnan, margins))
        for margins in zip(*(each.margins for each in coatings), strict=True)
    ]
    for name, sign in itertools.compress(zip(MARGINS, _SIGNS, strict=True), known):
        right.plot([], [], color="#555555", label=name, linestyle="none", **sign)
    right.axvline(1.0, color="#222222", linestyle="--", linewidth=1, label="limit")
    right.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    for ax, words in ((left, "peak electrostatic force"), (right, "limit over value")):
        ax.set_xlabel(words)
        ax.set_yticks(range(len(coatings)), [each.name for each in coatings])
        ax.set_ylim(len(coatings) - 0.5, -0.6)
        ax.grid(visible=False, axis="y")
    left.set_xlim(left=0.0)
    left.locator_params(axis="x", nbins=4)
    left.xaxis.set_major_formatter(EngFormatter("N"))
    right.set_xscale("log")
    right.xaxis.set_major_formatter("{x:g}")
