"""Results of a comparison of force laws in words: its answer, its tables, and why the laws differ."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from electrovib.core.answer import Answer, Document, Page, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.deprecation import former_attribute
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.discovery import find_members, paper_of, papers
from electrovib.core.units import format_quantity
from electrovib.physics.circuit import Grounded
from electrovib.physics.conduction import Conduction
from electrovib.physics.force import ForceLaw, needed_layer
from electrovib.scenario import PeriodicState, Scenario
from electrovib.solve.quantities.answer import validity
from electrovib.studies import widths


@dataclass(frozen=True, kw_only=True)
class Entry:
    """One law on the stack.

    - `evaluation_surface`: medium in which it evaluates the Maxwell stress; `status`: that of its source.
    - `static`: attraction at a constant peak voltage in the steady state, with all conduction left out [N];
      `ratio`: over that of the Maxwell stress in the gap.
    - `early`, `late`: attraction 50 us and 50 ms after a step to the peak voltage [N]; NaN for a law without
      a response in time.
    - `mean`: time average of the attraction under a sine of the peak voltage, over frequency [N].
    - `step`: step response over time [N], empty for a law without one.
    - `polarity`: mean attraction during the step over that of a step of the opposite sign; exactly 1 where
      the response of no layer depends on the polarity, NaN for a law without a response in time.
    - `why`: explanation of the ratio; `warnings`: limits that are exceeded.
    - `breakdown`: how the air breaks down at the static force; empty where it does not.
    """

    name: str
    evaluation_surface: str
    status: str
    static: float
    ratio: float
    early: float
    late: float
    mean: Real
    step: Real
    polarity: float
    why: str
    warnings: tuple[str, ...]
    breakdown: str


@dataclass(frozen=True, kw_only=True, repr=False)
class Comparison(Answer):
    """All laws on one scenario.

    - `voltage`: peak voltage at which the laws are compared [V].
    - `entries`: from the largest to the smallest static force.
    - `headline`: which law to believe on this stack, and why, in one sentence.
    - `left_out`: law to the reason for which it is not in the comparison.
    - `frequency`, `time`: frequencies [Hz] and times [s] of `mean` and `step` of the entries.
    - `tables`, `panels`, `pages`: tables, figures and explanations of a report.
    """

    scenario: Scenario
    voltage: float
    entries: tuple[Entry, ...]
    headline: str
    left_out: Mapping[str, str]
    frequency: Real
    time: Real
    tables: tuple[Table, ...]
    panels: tuple[Panel, ...]
    pages: tuple[Page, ...]
    answer = former_attribute("answer", "headline", lambda self: self.headline)

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the scenario with its own law and drive."""
        return validity(self.scenario)

    @property
    def widths(self) -> tuple[widths.Width, ...]:
        """By what the force of the law to believe is uncertain on a finger."""
        best = believed(self.entries)
        law = [] if best is None else [widths.law_width(best.name, widths.TYPICAL_FACTORS.get(best.name))]
        return (*law, widths.ONE_FINGER, widths.UNFELT)

    @property
    def document(self) -> Document:
        """The answer, figures over what was asked for first, then the one that belongs to the drive, and explanations."""
        standard = ["force_over_frequency", "force_over_time"]
        if not isinstance(self.scenario.time.initial_state, PeriodicState):
            standard.reverse()
        own = {paper_of(find_members(ForceLaw)[entry.name]) for entry in self.entries}
        cited = [
            module for name, module in papers().items() if name in own or getattr(module, "DEFECTS", None)
        ]
        return Document(
            title=f"Force laws compared: {self.scenario.titled() or 'a stack'}",
            sentences=[self.headline, *widths.sentences(self.widths)],
            diagnostics=self.diagnostics,
            figures=sorted(self.panels, key=lambda p: standard.index(p.id) if p.id in standard else -1),
            tables=self.tables,
            pages=self.pages,
            references=[module.CITATION for module in cited],
        )


STEADY = 0.01
"""Relative change up to which a force counts as constant."""
IN_GAP = ("rough gap", "gap")
"""Surfaces at which plate and finger separate, the more detailed one first."""


def believed(entries: Sequence[Entry]) -> Entry | None:
    """Return the law that evaluates the stress in the gap in the most detail; None if none does."""
    found = sorted(
        (entry for entry in entries if entry.evaluation_surface in IN_GAP),
        key=lambda entry: (IN_GAP.index(entry.evaluation_surface), entry.name != "MaxwellStressInGap"),
    )
    return found[0] if found else None


def headline(scenario: Scenario, entries: Sequence[Entry], *, voltage: float) -> str:
    """State which of the compared laws to believe on this stack, and why."""
    best = believed(entries)
    if best is None:
        return (
            "None of these laws evaluates the stress in the gap, where plate and finger separate: compare them with"
            " MaxwellStressInGap before you believe one."
        )
    others = [entry.ratio / best.ratio for entry in entries if entry is not best]
    differ = f"; the other laws give {_span(others)} of it" if others else ""
    return (
        f"Believe {best.name} here, {_force(best.static)} at {format_quantity(voltage, 'V')}{_limit(scenario, best)}: plate and"
        f" finger separate only in the gap, so the stress there is the force between them{differ}."
    )


def _span(ratios: Sequence[float]) -> str:
    low, high = (f"{value:.3g}" for value in (min(ratios), max(ratios)))
    return low if low == high else f"{low} to {high}"


def _limit(scenario: Scenario, best: Entry) -> str:
    """Qualify a static force that would not be measured."""
    if best.breakdown:
        return " (beyond breakdown of the air, so no force that would be measured)"
    if scenario.stack.gap_name is None:
        return " (an upper limit: the stack has no gap, and any gap lowers it)"
    return ""


def tables(entries: Sequence[Entry], left_out: Mapping[str, str], scenario: Scenario) -> tuple[Table, ...]:
    """Return the table of forces, that of further limits exceeded and by which laws, and that of laws not compared."""
    columns: dict[str, Callable[[Entry], str]] = {
        "law": lambda entry: entry.name,
        "stress evaluated in": lambda entry: entry.evaluation_surface,
        "source status": lambda entry: entry.status,
        "static force": lambda entry: (
            f"{_force(entry.static)}{' (beyond breakdown)' if entry.breakdown else ''}"
        ),
        "relative to the gap": lambda entry: f"{entry.ratio:.4g}",
        "50 us after a step": lambda entry: _force(entry.early),
        "50 ms after": lambda entry: _force(entry.late),
        "measured forces missed by": lambda entry: widths.missed_by(entry.name),
    }
    found = [Table.of("Every law on this stack", entries, columns)]
    stated = {each.text for each in validity(scenario)}  # stated for the scenario as a whole
    beyond = dict.fromkeys(text for entry in entries for text in _limits(entry) if text not in stated)
    if beyond:
        lines = tuple((_whose(text, entries), text) for text in beyond)
        found.append(Table("Beyond a limit", ("law", "what"), lines))
    if left_out:
        found.append(Table("Not in this comparison", ("law", "why"), tuple(left_out.items())))
    return tuple(found)


def _force(value: float) -> str:
    return "no response in time" if np.isnan(value) else format_quantity(value, "N", digits=4)


def _limits(entry: Entry) -> tuple[str, ...]:
    static = (f"static: {entry.breakdown}",) if entry.breakdown else ()
    return (*static, *entry.warnings)


def _whose(text: str, entries: Sequence[Entry]) -> str:
    names = [entry.name for entry in entries if text in _limits(entry)]
    return "every law" if len(names) == len(entries) > 1 else ", ".join(names)


def pages(scenario: Scenario, entries: Sequence[Entry]) -> tuple[Page, ...]:
    """Explain why the laws differ on this stack, and list where papers contradict themselves or each other."""
    said = [_in_size(entries), _in_time(entries), _leak(scenario), _polarity(scenario, entries)]
    found = [Page("Why they differ", (*said, *(f"{entry.name}: {entry.why}." for entry in entries)))]
    laws = find_members(ForceLaw)
    own = {paper_of(laws[entry.name]) for entry in entries}
    titles = {
        True: "Where the papers of these laws contradict themselves or others",
        False: "Where other papers contradict each other",
    }
    for is_own, title in titles.items():
        some = (module for name, module in papers().items() if (name in own) == is_own)
        defects = tuple(text for module in some for text in getattr(module, "DEFECTS", ()))
        found += [Page(title, defects)] if defects else []
    return tuple(found)


def _in_size(entries: Sequence[Entry]) -> str:
    largest, smallest = entries[0], entries[-1]
    factor = format_quantity(largest.static / smallest.static, "1", digits=4)
    differ = f"; here the laws differ by a factor of {factor}, from {largest.name} to {smallest.name}"
    return (
        "All static laws follow from one electric displacement, divided by the permittivity of the medium in which each"
        " evaluates the Maxwell stress. Finger and plate can separate only in the gap, so the stress in the gap is the"
        f" physical one{differ if len(entries) > 1 else ''}."
    )


def _in_time(entries: Sequence[Entry]) -> str:
    moving = [entry for entry in entries if len(entry.step) and entry.early > 0]
    moved = [entry for entry in moving if abs(entry.late / entry.early - 1) > STEADY]
    if not moving:
        return "None of these laws has a response in time."
    if not moved:
        return "In time the laws do not differ here: each keeps its force while the voltage is held, to 1 %."
    moving.sort(key=lambda entry: entry.late / entry.early)
    extremes = moving if len(moving) == 1 else (moving[-1], moving[0])
    changes = listed(f"{e.name} goes from {_force(e.early)} to {_force(e.late)}" for e in extremes)
    words = "The laws differ in time as well as in size" if len(moving) > 1 else "The force changes in time"
    return f"{words}: between 50 us and 50 ms after a step {changes}."


def _leak(scenario: Scenario) -> str:
    names = conducting(scenario)
    if not names:
        return "Nothing conducts here, so there is no leak."
    if scenario.stack.gap_name in names:
        return f"Conducting: {listed(names)}. The gap leaks, so charge crosses from the finger onto the insulator."
    gap = "The gap does not leak" if scenario.stack.gap_name else "There is no gap that could leak"
    return f"Conducting: {listed(names)}. {gap}, so no charge crosses from the finger onto the insulator."


def _polarity(scenario: Scenario, entries: Sequence[Entry]) -> str:
    if not knows_polarity(scenario):
        return (
            "No law can show an effect of polarity on these layers: their response is an odd function of the voltage, so +V"
            " and -V give the same attraction. Kaczmarek 2006 found positive pulses weaker, which requires a layer that"
            " rectifies, for instance leak = PolarityConduction."
        )
    ratios = (f"{entry.name} {entry.polarity:.3g}" for entry in entries if len(entry.step))
    return f"The response of a layer depends on the polarity. Mean attraction over 50 ms, +V over -V: {', '.join(ratios)}."


AGREES = 0.01
"""Relative difference up to which an explanation accounts for a ratio."""


def static_permittivity(scenario: Scenario, name: str) -> float:
    """Return the real relative permittivity of a layer at 1 Hz, without conduction."""
    return float(scenario.stack.layers[name].material.bound_permittivity(1.0).real)


def explain(scenario: Scenario, *, ratio: float) -> str:
    """Explain by surface, permittivity and gap a static force that is `ratio` times the Maxwell stress in the gap."""
    expected, words = _reason(scenario)
    if expected is None:
        said = f"{words}: {ratio:.4g} of the Maxwell stress in the gap here"
    elif abs(ratio / expected - 1) > AGREES:
        return (
            f"{words} would give {expected:.4g} of the Maxwell stress in the gap, but the law gives {ratio:.4g}: it has"
            " further terms"
        )
    elif expected == 1:
        return words
    else:
        said = f"{words}: {expected:.4g} of the Maxwell stress in the gap"
    return said + _equal_gap(scenario, ratio)


def _electrical(scenario: Scenario) -> tuple[float, float]:
    """Return the electrical thickness of the whole stack and of the stack without the gap [m]."""
    layers = scenario.stack.layers
    each = {name: layer.thickness / static_permittivity(scenario, name) for name, layer in layers.items()}
    gap = scenario.stack.gap_name
    return sum(each.values()), sum(value for name, value in each.items() if name != gap)


def _equal_gap(scenario: Scenario, ratio: float) -> str:
    """Return the gap of equal Maxwell stress in words, where the gap does not change the voltage."""
    whole, solid = _electrical(scenario)
    name = scenario.stack.gap_name
    filling = static_permittivity(scenario, name) if name else 1.0
    gap = filling * whole / ratio**0.5 - solid
    if not isinstance(scenario.circuit.return_path, Grounded) or gap <= 0:
        return ""
    return (
        f", as much as the Maxwell stress in the gap at a gap of {format_quantity(float(f'{gap:.2g}'), 'm')}"
    )


def _reason(scenario: Scenario) -> tuple[float | None, str]:
    surface, layers, gap = scenario.force.evaluation_surface, scenario.stack.layers, scenario.stack.gap_name
    permittivity = {name: static_permittivity(scenario, name) for name in layers}
    electrical, solid = _electrical(scenario)
    in_gap = permittivity[gap] if gap else 1.0
    if surface == "gap":
        if gap is None:
            return 1.0, "the field of a vanishing gap"
        less = f"{(solid / (permittivity[gap] * electrical)) ** 2:.3g} of the force of a vanishing one"
        return 1.0, f"the field in a gap of {format_quantity(layers[gap].thickness, 'm')}, {less}"
    if surface == "effective medium":
        length = scenario.stack.thickness - (0.0 if gap is None else layers[gap].thickness)
        # V^2/(K L) against V^2/(eps_gap K + g)^2, the voltage being the same
        expected = (in_gap * electrical) ** 2 / (solid * length)
        beside = "" if gap is None else ", and it takes no account of the gap"
        return (
            expected,
            f"energy over geometric thickness, effective permittivity {length / solid:.4g}{beside}",
        )
    read = layers_read(scenario)
    if len(read) == 1:
        value = permittivity[read[0]]
        return in_gap**2 / value, f"the same displacement in the {read[0]}, permittivity {value:.4g}"
    return None, f"the Maxwell stress is evaluated in the {surface}"


def layers_read(scenario: Scenario) -> tuple[str, ...]:
    """Return the layers that the force law reads: those nearest to the interface of the roles that it needs."""
    found = (needed_layer(scenario.stack.roles, wanted) for wanted in scenario.force.needs)
    return tuple(name for name in found if name is not None)


def conducting(scenario: Scenario) -> tuple[str, ...]:
    """Return the layers that conduct, from plate to finger."""
    layers = scenario.stack.layers.items()
    return tuple(name for name, layer in layers if layer.material.conductivity or layer.leak is not None)


def listed(names: Iterable[str]) -> str:
    """Join names as a list: ``a``, ``a and b``, ``a, b and c``."""
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


def knows_polarity(scenario: Scenario) -> bool:
    """Return whether the response of a layer depends on the polarity: it rectifies, or is charged at time 0."""
    layers = scenario.stack.layers.values()
    return any(layer.initial_charge or (layer.leak and not _odd(layer.leak)) for layer in layers)


def _odd(leak: Conduction) -> bool:
    fields = np.geomspace(1.0, 1e9, 19)
    return np.allclose(leak.current_density(fields), -leak.current_density(-fields), rtol=1e-12, atol=0.0)


def in_time(scenario: Scenario, *, early: float, late: float, charging: bool = False) -> str:
    """Explain how the force changes from just after a step to 50 ms later: which layer causes it, or the amplifier `charging`."""
    if early <= 0:
        return "starts at 0 N"
    names, change = conducting(scenario), late / early
    if abs(change - 1) < 1e-2:
        though = f", although {_conduct(names)}" if names else ": nothing conducts"
        return f"keeps its force while the voltage is held{though}"
    size = f"rises by a factor {change:.3g}" if change > 1 else f"falls to {change:.2g} of its initial value"
    if charging:
        return f"{size} between 50 us and 50 ms after the step, while the amplifier still charges the plate"
    return f"{size} while the voltage is held: {_because(_place(scenario), names, rises=change > 1)}"


def _place(scenario: Scenario) -> str:
    """Return the layer in which the law evaluates the Maxwell stress, or the name of its evaluation surface."""
    read = layers_read(scenario)
    if len(read) == 1:
        return read[0]
    gap = scenario.stack.gap_name
    return gap if gap and scenario.force.evaluation_surface == "gap" else scenario.force.evaluation_surface


def _because(surface: str, names: tuple[str, ...], *, rises: bool) -> str:
    others = [name for name in names if name != surface]
    if not names:
        return "layers still polarise, or the return path still charges"
    if rises and others:
        return f"{_conduct(others)}, so the field moves from there to the surface that this law evaluates"
    if not rises and surface in names:
        return f"{_conduct([surface])}, so the field moves from there to the other layers"
    if not rises and surface == "effective medium":
        return f"{_conduct(names)}, and this law counts charge that has crossed as lost"
    return _conduct(names)


def _conduct(names: Iterable[str]) -> str:
    chosen = [f"the {name}" for name in names]
    return f"{listed(chosen)} {'conduct' if len(chosen) > 1 else 'conducts'}"
