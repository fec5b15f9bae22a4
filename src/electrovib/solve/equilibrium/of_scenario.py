"""The equilibria of a scenario's finger under a constant voltage, and the force in each."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.answer import Answer, Document, Table
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.contact.attraction import Attraction
from electrovib.physics.contact.surface import Surface
from electrovib.physics.limits import held_voltages, limit_diagnostics
from electrovib.physics.roughness import ContactSpots, GaussianGaps, local_pull
from electrovib.physics.safety import breakdown_share
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.judge import declared_diagnostics, layer_diagnostics
from electrovib.solve.electrics.attraction import LARGEST, crossed, without_bound
from electrovib.solve.equilibrium.states import BEYOND, Equilibrium, attraction_at, balance
from electrovib.solve.stack.blocking import BlockingStack, blocking_parts, blocking_stack

if TYPE_CHECKING:
    from collections.abc import Callable

    from electrovib.core.arrays import Real
    from electrovib.physics.contact import Contact


@dataclass(frozen=True, kw_only=True, repr=False)
class Balance(Answer):
    """All equilibria of a finger under a constant voltage, and the quantities from which they were computed.

    Parameters
    ----------
    states : tuple of Equilibrium
        Equilibria from the smallest gap to the largest.
    force : tuple of float
        Attraction in each state [N].
    areas : tuple of float
        Gross area in each state [m2]: that under load and attraction together, without what contact spots hold of it.
    voltage : float
        Voltage across stack and return path [V].
    pressure : float
        Load over the gross area under the load alone [Pa].
    area : float
        Gross area under the load alone [m2].
    electrical_thickness : float
        Thickness of the blocking parts over their permittivity, times that of the gap [m], at the area under the load.
    blocking : tuple of str
        Names of the layers that block, and ``return_path`` where it blocks.
    beyond : bool
        With spots: there is a further state in which the surface topography is flatter than a Gaussian distribution of
        gaps describes, with more than half of it in contact; that state is not included.
    gaps : GaussianGaps or None
        With spots: the local gaps in the stable state with the largest mean gap, which a rising voltage reaches.
    diagnostics : tuple of Diagnostic
        Of what the scenario declares, of the law of rough contact, of films and air in the state with the largest field, and of
        the declared limits.
    """

    states: tuple[Equilibrium, ...]
    force: tuple[float, ...]
    areas: tuple[float, ...]
    voltage: float
    pressure: float
    area: float
    electrical_thickness: float
    blocking: tuple[str, ...]
    beyond: bool
    gaps: GaussianGaps | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def stable(self) -> tuple[Equilibrium, ...]:
        """The states that are stable against a small displacement; with two of them there is a hysteresis."""
        return tuple(state for state in self.states if state.stable)

    @property
    def document(self) -> Document:
        """What is held, how many states there are, and a row for each."""
        voltage, thickness, pressure, area = (
            _shown(value, unit)
            for value, unit in (
                (self.voltage, "V"),
                (self.electrical_thickness, "m"),
                (self.pressure, "Pa"),
                (self.area, "m2"),
            )
        )
        more = []
        if len(self.stable) > 1:
            more.append(
                "two stable states: which of them is reached depends on the previous gap, so the force has a hysteresis"
            )
        if self.beyond:
            more.append(
                "a flatter state, with more than half of the area in contact, is not described by this surface topography"
            )
        if self.gaps is not None:
            more.append(
                "the stable state with the largest gap has, at this voltage, the local gaps of force = { model ="
                f' "Persson2018RoughGap", mean_gap = {self.gaps.mean:.5g}, rms_gap = {self.gaps.rms:.5g}, power ='
                f" {self.gaps.power:.5g} }}, which a run takes in place of the layer that is the gap"
            )
        rows = [
            (
                _shown(state.gap, "m"),
                _shown(force, "N"),
                _shown(area, "m2"),
                _kind(state),
                f"{state.residual:.1e} Pa",
            )
            for state, force, area in zip(self.states, self.force, self.areas, strict=True)
        ]
        return Document(
            title="Equilibria under a constant voltage",
            sentences=[
                f"{voltage} held across {', '.join(self.blocking)} and the gap: electrical thickness {thickness}, load {pressure}"
                f" on {area}",
                *more,
            ],
            numbers=[Table("", ("gap", "attraction", "area", "state", "residual"), tuple(rows))],
            diagnostics=self.diagnostics,
            remarks=reasons(self.diagnostics),
        )


def _shown(value: float, unit: str) -> str:
    return format_quantity(value, unit, digits=4)


def _kind(state: Equilibrium) -> str:
    """Say whether a state is stable, and whether the finger is pressed on the plate."""
    words = "stable" if state.stable else "a fold, where a branch ends" if state.fold else "unstable"
    return f"{words}, pressed on the plate" if state.touching else words


def equilibrium(
    scenario: Source,
    *,
    voltage: float | None = None,
    spots: ContactSpots | None = None,
) -> Balance:
    """Compute gap and attraction of a finger in equilibrium of surface topography, load and attraction.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`, with ``contact.surface`` and a gap that does not conduct. The thickness of the gap is
        computed; the declared one has no effect.
    voltage : float, optional
        Constant voltage [V]; by default the largest of the drive behind its amplifier. For a fast sine give its root mean square.
    spots : ContactSpots, optional
        Averages over the gaps of a rough surface with these contact spots; by default the gap is the same everywhere.

    Returns
    -------
    Balance
        All states, stable or not, and the force in each.

    Raises
    ------
    InputError
        If surface or gap is missing, the gap conducts, nothing blocks, or there is a second contact.

    Notes
    -----
    A constant voltage drops across the parts that do not conduct: layers with conductivity 0 and without a leak, the gap,
    and a floating body that nothing discharges. K = eps_gap (sum T/eps + eps0 A/C) over them, with the permittivity at
    the lowest frequency of the scenario's grid. The attraction is the Maxwell stress in the gap, eps0 E^2/2, whatever the
    scenario's force law. Load, attraction and gross area belong to the same equilibrium.

    Examples
    --------
    >>> spring = {"model": "LinearSpring", "stiffness": "1 GPa/m", "free_gap": "10 um"}
    >>> pressed = {"contact.surface": spring, "stack.gap.material.conductivity": 0.0}
    >>> found = ev.equilibrium(ev.load("vezzoli_2014/fig6_gap", changes=pressed), voltage=100.0)
    >>> [f"{1e6 * each.gap:.3f} um" for each in found.states]
    ['4.956 um']
    """
    known = read_scenario(scenario)
    surface, stack = _surface(known), blocking_stack(known)
    held = largest_voltage(known) if voltage is None else float(held_voltages(voltage)[0])
    pressure, area, filling = stack.pressure, stack.area, stack.filling
    attraction = attraction_at(held, stack.electrical_thickness, surface, spots)
    states, areas = states_of(known, voltage=held, spots=spots)
    low = attraction.smallest_gap
    beyond = low > 0 and float(surface.pressure(np.asarray(low))) < pressure + attraction.pressure(low)
    if not states:
        raise InputError(
            "contact.surface: the attraction flattens the surface topography further than a Gaussian distribution of gaps"
            " describes; lower the voltage, or omit 'spots' for one gap everywhere that ends at the plate"
        )
    return Balance(
        states=states,
        force=tuple(state.attraction * each for state, each in zip(states, areas, strict=True)),
        areas=areas,
        voltage=held,
        pressure=pressure,
        area=area,
        electrical_thickness=stack.electrical_thickness,
        blocking=stack.blocking,
        beyond=beyond,
        gaps=_reached_gaps(surface, states) if spots is not None else None,
        diagnostics=(
            *_of_surface(surface, states, spots),
            *_diagnostics(known, states, areas, held=held, filling=filling),
        ),
    )


def states_of(
    scenario: Scenario, *, voltage: float | None = None, spots: ContactSpots | None = None
) -> tuple[tuple[Equilibrium, ...], tuple[float, ...]]:
    """Return the states of `equilibrium` and their areas [m2], without judging them."""
    surface, stack = _surface(scenario), blocking_stack(scenario)
    held = largest_voltage(scenario) if voltage is None else voltage

    def attraction_on(area: float) -> Attraction:
        """Return the attraction with the electrical thickness of the return path for an area [m2]."""
        return attraction_at(
            held, stack.filling * sum(blocking_parts(scenario, area).values()), surface, spots
        )

    if scenario.contact.grows:
        return growing_states(scenario.contact, surface, attraction_on, load=scenario.load.normal_force)
    states = balance(surface, attraction_on(stack.area), pressure=stack.pressure)
    return states, (stack.area,) * len(states)


def _reached_gaps(surface: Surface, states: Sequence[Equilibrium]) -> GaussianGaps | None:
    stable = [state for state in states if state.stable]
    return surface.gaps(stable[-1].repulsion) if stable else None


def _of_surface(
    surface: Surface, states: Sequence[Equilibrium], spots: ContactSpots | None
) -> tuple[Diagnostic, ...]:
    """Return how large the error of a law of rough contact is, and that of one gap everywhere in its place."""
    borne = np.array([state.repulsion + state.stop for state in states])
    text = (
        "one gap everywhere attracts 0.002 to 0.99 times as much (median 0.4) as a rough contact with that mean gap that was"
        " solved; give spots, for instance PullingSpots, for the mean over its gaps"
    )
    one_gap = (Diagnostic("one gap", "warning", text),) if surface.is_rough and spots is None else ()
    return (*surface.diagnostics(surface.real_share(borne)), *one_gap)


def closed_diagnostics(
    scenario: Scenario, stack: BlockingStack, *, voltage: float, widest: float
) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of `equilibrium` for the worst case of a voltage [V] and local gaps up to the `widest` [m].

    Films, charge and energy are those of the whole area touching, air that of the gap nearest to breakdown.
    """
    gaps = np.linspace(0.0, widest, 257)
    pull = local_pull(voltage, electrical_thickness=stack.electrical_thickness, gap=gaps)
    states = [
        Equilibrium(
            gap=gap,
            stable=True,
            touching=gap == 0,
            repulsion=0.0,
            attraction=attraction,
        )
        for gap, attraction in zip(gaps.tolist(), np.asarray(pull).tolist(), strict=True)
    ]
    areas = [stack.area] * gaps.size
    return _diagnostics(scenario, states, areas, held=voltage, filling=stack.filling)


def _diagnostics(
    scenario: Scenario,
    states: Sequence[Equilibrium],
    areas: Sequence[float],
    *,
    held: float,
    filling: float,
) -> tuple[Diagnostic, ...]:
    """Return the diagnostics of what is declared, and those of films, air and limits, each for the worst of all states."""
    layers, gap = scenario.stack.layers, str(scenario.stack.gap_name)
    stray = scenario.circuit.supply.stray_capacitance
    of_gaps = np.array([[math.sqrt(2 * state.attraction / eps0), state.gap] for state in states])
    field = float(np.max(of_gaps[:, 0]))  # the stress is eps0 E^2/2
    nearest = of_gaps[np.argmax(breakdown_share(of_gaps[:, 0], of_gaps[:, 1]))].tolist()
    inside, left, charges, energies = dict.fromkeys(layers, 0.0), [], [], []
    for strength, area in zip(of_gaps[:, 0].tolist(), areas, strict=True):
        parts, flux = blocking_parts(scenario, area), filling * strength
        for name, layer in layers.items():
            inside[name] = max(inside[name], flux * parts.get(name, 0.0) / layer.thickness)
        left.append(abs(held) - flux * parts.get("return_path", 0.0))
        charges.append(eps0 * area * flux)
        energies.append((charges[-1] * left[-1] + stray * held**2) / 2)
    judged = layer_diagnostics(
        scenario,
        inside | {gap: field},
        interface=field,
        nearest=(nearest[0], nearest[1]),
        across=max(left),
        supplied=(min(0.0, held), max(0.0, held)),
    )
    reached = {name: abs(held) for name in ("voltage", "rms_voltage")}
    reached |= {"charge": max(charges), "stored_energy": max(energies)}
    return (*declared_diagnostics(scenario), *judged, *limit_diagnostics(reached, scenario.limits))


def _surface(scenario: Scenario) -> Surface:
    if scenario.contact.surface is None:
        more = "" if scenario.stack.gap_name else "; the stack has no gap either: add [stack.gap]"
        example = '{ model = "LinearSpring", stiffness = "1 GPa/m", free_gap = "10 um" }'
        why = "the gap follows from the repulsive pressure of the skin's surface topography, for instance"
        raise InputError(f"contact.surface is not given: {why} contact.surface = {example}{more}")
    return scenario.contact.surface


def largest_voltage(scenario: Scenario) -> float:
    """Return the largest voltage of the drive behind the amplifier, if there is one [V]."""
    if scenario.drive.quantity == "current":
        raise InputError("drive: it prescribes a current; give the voltage, for instance voltage=100.0")
    return abs(float(scenario.circuit.supply.aim(scenario.drive.largest())))


def growing_states(
    contact: Contact, surface: Surface, attraction_on: Callable[[float], Attraction], *, load: float
) -> tuple[tuple[Equilibrium, ...], tuple[float, ...]]:
    """Return the equilibria of a gap under a constant voltage, on the area under load and attraction together.

    The gap follows from the pressure W/area(W) of each total force W, and the attraction across it has to be
    W - load. States are sought in steps of a 64th of the force; two states closer than that are missed.
    """

    def gap(whole: float) -> float:
        return float(surface.gap(np.asarray(contact.mean_pressure(np.asarray(whole)))))

    if not math.isfinite(gap(load)):
        raise InputError(
            "contact.surface: without a load the gap of the surface topography is infinite; give load.normal_force above 0"
        )

    def drawn(whole: float, low: float) -> float:
        area = contact.gross_area(whole)
        attraction = attraction_on(area)
        return attraction.pressure(max(gap(whole), low)) * area

    low = attraction_on(contact.gross_area(load)).smallest_gap

    def lacking(whole: Real) -> Real:
        return np.array([each - load - drawn(each, low) for each in whole.tolist()])

    closed = drawn(load, low) / contact.gross_area(load)
    highest = load * (1 + BEYOND) + attraction_on(contact.gross_area(load)).pressure(low) * LARGEST
    found = [(whole, stable) for whole, stable in crossed(lacking, least=load * (1 - BEYOND), most=highest)]
    if not found:
        raise without_bound(contact, pull=closed)
    states = [
        _state_at(contact, surface, attraction_on, whole, stable, load) for whole, stable in reversed(found)
    ]
    kept = [(state, area) for state, area in states if state.gap >= low]
    return tuple(state for state, _ in kept), tuple(area for _, area in kept)


def _state_at(
    contact: Contact,
    surface: Surface,
    attraction_on: Callable[[float], Attraction],
    whole: float,
    stable: bool,
    load: float,
) -> tuple[Equilibrium, float]:
    area = contact.gross_area(whole)
    pressing = float(contact.mean_pressure(np.asarray(whole)))
    gap = float(surface.gap(np.asarray(pressing)))
    repulsion, attraction = float(surface.pressure(np.asarray(gap))), attraction_on(area)
    stop = max(0.0, pressing - repulsion) if gap == 0 else 0.0
    residual = repulsion + stop - load / area - attraction.pressure(gap)
    state = Equilibrium(
        gap=gap,
        stable=stable,
        touching=gap == 0 and stop > 0,
        repulsion=repulsion,
        attraction=attraction.total(gap),
        stop=stop,
        residual=residual,
    )
    return state, area
