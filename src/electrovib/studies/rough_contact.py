"""Where a rough finger touches a plate at a constant voltage, and its attraction: contact and field solved together."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar, Final

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import REFERENCE, Answer, Curve, Document, Drawing, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.core.model import read_model
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text
from electrovib.physics import contact
from electrovib.physics.half_space import ElasticBody
from electrovib.physics.limits import held_voltages
from electrovib.physics.roughness import ContactSpots, local_pull, share_of_field
from electrovib.physics.safety import FILM
from electrovib.physics.topography import Topography
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.equilibrium.of_scenario import closed_diagnostics, largest_voltage
from electrovib.solve.rough_contact import (
    Loaded,
    Rest,
    doubts,
    follow_voltages,
    refuse_beyond_budget,
    words_of_spots,
)
from electrovib.solve.stack.blocking import BlockingStack, uniform_stack

COLUMNS: Final = {
    "voltage": ("V", "voltage"),
    "contact_share": ("1", "in contact"),
    "mean_gap": ("m", "mean gap"),
    "attraction": ("Pa", "attraction"),
    "plates": ("Pa", "plates at the mean gap"),
    "force": ("N", "force"),
    "capacitance": ("F", "capacitance"),
}
"""Numbers at each voltage: unit and words."""
SHARES: Final = (0.5, 0.1, 0.01)
"""Shares of the area on which the field in a film reaches a value that is stated."""


@dataclass(frozen=True)
class Film:
    """A film that blocks: its field per volt where the contact is closed [1/m], and the strength it is judged by [V/m]."""

    name: str
    closed: float
    strength: float


@dataclass(frozen=True, kw_only=True, repr=False)
class RestingContact(Answer):
    """A rough contact at rest at each of some voltages, with its maps.

    Parameters
    ----------
    stack : BlockingStack
        Load, area, and the layers across which the voltage is held.
    voltage : ndarray, shape (n,)
        Voltages [V] in the order in which the contact went through them.
    rests : tuple of n Rest
        The contact at each: maps of ``gap`` [m], ``pressure`` and ``attraction`` [Pa] over one period.
    coarser, smoother : ndarray, shape (2, n)
        Contact share [1] and attraction [Pa] on every second point of the grid, and of the roughness without waves of its
        shortest octave.
    roughness : SelfAffine or MeasuredHeights
        Roughness of both faces together.
    films : tuple of Film
        Films whose strength is known.
    field_share : float
        Field where faces touch, over that of insulating spots [1].
    diagnostics : tuple of Diagnostic
        Of what the scenario declares, and of films, air and limits where the faces touch.
    """

    FILES: ClassVar = {"rough_contact.csv": Form.TABLE}
    stack: BlockingStack
    voltage: Real
    rests: tuple[Rest, ...]
    coarser: Real
    smoother: Real
    roughness: Topography
    films: tuple[Film, ...]
    field_share: float
    diagnostics: tuple[Diagnostic, ...]

    @property
    def contact_share(self) -> Real:
        """Share of the area that touches at each voltage [1]."""
        return np.array([rest.contact_share for rest in self.rests])

    @property
    def mean_gap(self) -> Real:
        """Mean gap at each voltage [m], 0 where the faces touch."""
        return np.array([rest.mean_gap for rest in self.rests])

    @property
    def attraction(self) -> Real:
        """Mean attraction per area at each voltage [Pa]."""
        return np.array([rest.mean_attraction for rest in self.rests])

    @property
    def plates(self) -> Real:
        """Attraction of plates with the mean gap everywhere, at each voltage [Pa]."""
        return local_pull(
            self.voltage, electrical_thickness=self.stack.electrical_thickness, gap=self.mean_gap
        )

    @property
    def force(self) -> Real:
        """Attraction times the area at each voltage [N]."""
        return self.attraction * self.stack.area

    @property
    def capacitance(self) -> Real:
        """Capacitance of the layers that block and the gap at each voltage [F]."""
        return np.array([self.stack.capacitance(rest.gap) for rest in self.rests])

    @property
    def fell(self) -> Real:
        """Whether the contact fell into another rest before each voltage: shut, or open again."""
        return np.array([rest.fell for rest in self.rests])

    def field(self, film: Film, at: int) -> Real:
        """Return the map of the field in a film [V/m] at one of the voltages; where the contact is closed it is the largest."""
        thickness = self.stack.electrical_thickness
        map_: Real = abs(self.voltage[at]) * film.closed * thickness / (thickness + self.rests[at].gap)
        return map_

    @property
    def area_beyond(self) -> dict[str, Real]:
        """Share of the area whose field is above the strength of each film, at each voltage [1]."""
        every = range(self.voltage.size)
        return {
            film.name: np.array([np.mean(self.field(film, at) > film.strength) for at in every])
            for film in self.films
        }

    @property
    def document(self) -> Document:
        """What happens at the largest voltage, a row for each voltage, and the maps."""
        rows = np.column_stack([getattr(self, name) for name in COLUMNS]).tolist()
        units = [unit for unit, _ in COLUMNS.values()]
        texts = [tuple(_shown(value, unit) for value, unit in zip(row, units, strict=True)) for row in rows]
        return Document(
            title="A rough contact under a constant voltage",
            sentences=[
                self._at_most(),
                *words_of_spots(self.field_share),
                self._converged(),
                *self._broken(),
                *self._doubts(),
            ],
            numbers=[
                Table("", tuple(words for _, words in COLUMNS.values()), tuple(texts)),
                *(self._fields(film) for film in self.films),
            ],
            diagnostics=self.diagnostics,
            figures=[*self._over_voltage(), self._map(), *self._distribution()],
            remarks=[
                "the roughness is that of both faces together on one elastic body, without friction or adhesion; the field at a"
                " place is that of parallel plates, which holds where gap and layers are thin beside the waves",
                "films, charge and energy are judged as if the whole area touched under the largest voltage, air across the open"
                " gap that is nearest to breakdown; of a sine that is given by its root mean square, `check` judges the peak",
                *reasons(self.diagnostics),
            ],
        )

    def content(self, name: str) -> str:
        """Write the numbers at each voltage as CSV, in SI, beside those of coarser grid and smoother roughness."""
        del name
        further = {
            f"{number} of a {kind}": values
            for kind, both in (("coarser grid", self.coarser), ("smoother roughness", self.smoother))
            for number, values in zip(("contact_share", "attraction"), both, strict=True)
        }
        further |= {f"area above strength, {film}": share for film, share in self.area_beyond.items()}
        columns = {name: getattr(self, name) for name in COLUMNS} | further | {"fell": self.fell.astype(int)}
        return csv_text(
            tuple(columns), np.column_stack(list(columns.values())).tolist(), remarks=[self._converged()]
        )

    @property
    def at_largest_voltage(self) -> int:
        """Place of the voltage that is largest in size."""
        return int(np.argmax(np.abs(self.voltage)))

    def _at_most(self) -> str:
        at = self.at_largest_voltage
        beside = "as of plates"
        if self.plates[at]:
            beside = f"{self.attraction[at] / self.plates[at]:.3g} times that of plates"
        return (
            f"at {_shown(self.voltage[at], 'V')} under a load of {_shown(self.stack.pressure, 'Pa')}"
            f" {100 * self.contact_share[at]:.3g} % of the area touch, the mean gap is {_shown(self.mean_gap[at], 'm')}, and the"
            f" attraction is {_shown(self.attraction[at], 'Pa')}, {beside} at the mean gap"
        )

    def _broken(self) -> list[str]:
        """Say of each film on how much of the area it is above its strength, and what it reaches where the contact is closed."""
        at, areas = self.at_largest_voltage, self.area_beyond
        volt = self.voltage[at]
        return [
            f"at {_shown(volt, 'V')} the field in '{film.name}' is above its strength of {_shown(film.strength, 'V/m')} on"
            f" {100 * areas[film.name][at]:.3g} % of the area, and {_shown(abs(volt) * film.closed, 'V/m')} where faces touch;"
            " whatever that share, the limit that `check` judges is that of a closed gap on conducting skin"
            for film in self.films
        ]

    def _fields(self, film: Film) -> Table:
        """Return a row for each voltage: what the field reaches on shares of the area, and the area above the strength."""
        rows = []
        for at, volt in enumerate(self.voltage.tolist()):
            field = self.field(film, at)
            reached = [*np.quantile(field, 1 - np.array(SHARES)).tolist(), float(field.max())]
            area = float(self.area_beyond[film.name][at])
            rows.append((_shown(volt, "V"), *(_shown(each, "V/m") for each in reached), _shown(area, "1")))
        shares = (f"on {100 * share:g} % of the area" for share in SHARES)
        strength = f"area above {_shown(film.strength, 'V/m')}"
        return Table(f"Field in '{film.name}'", ("voltage", *shares, "largest", strength), tuple(rows))

    def _doubts(self) -> list[str]:
        """Say where slopes are not small, and where the grid is too coarse for the attraction."""
        slope, steepness = (
            self.roughness.rms_slope(self.roughness.periods),
            max(rest.steepness for rest in self.rests),
        )
        return doubts(rms_slope=slope, steepness=steepness)

    def _converged(self) -> str:
        at, parts = self.at_largest_voltage, []
        smoothest = f"without roughness shorter than {_shown(2 * self.roughness.shortest, 'm')}"
        for words, both in (("on every second point of the grid", self.coarser), (smoothest, self.smoother)):
            share, attraction = both[:, at]
            parts.append(f"{words} {100 * share:.3g} % touch")
            if self.attraction[at]:
                parts[-1] += f" and {attraction / self.attraction[at]:.3g} times the attraction"
        return "; ".join(parts)

    def _over_voltage(self) -> list[Panel]:
        if self.voltage.size < 2:
            return []
        load = np.full(self.voltage.shape, self.stack.pressure)
        return [
            Panel(
                id="attraction", title="Attraction and load", x=("voltage", "V"), y=("pressure", "Pa"),
                caption="Rough contact and field solved together, beside plates with the mean gap of the same contact.",
                curves=(
                    Curve(label="rough contact", x=self.voltage, y=self.attraction, kind="bold"),
                    Curve(label="plates at the mean gap", x=self.voltage, y=self.plates, kind="dashed"),
                    Curve(label="load", x=self.voltage, y=load, look=REFERENCE),
                ),
            )
        ]  # fmt: skip

    def _distribution(self) -> list[Panel]:
        """Return the share of the area on which the field of each film is larger, at the largest voltage."""
        at, curves = self.at_largest_voltage, list[Curve]()
        for look, film in enumerate(self.films if self.voltage[at] else ()):
            field = np.sort(self.field(film, at), axis=None)
            kept = np.unique(np.linspace(0, field.size - 1, 513).astype(int))
            share = 1 - kept / field.size
            broken = np.array([film.strength]), self.area_beyond[film.name][[at]]
            curves += [
                Curve(label=film.name, x=field[kept], y=share, look=look),
                Curve(label=f"strength of {film.name}", x=broken[0], y=broken[1], kind="points", look=look),
            ]
        panel = Panel(
            id="field", title=f"Field in the film at {_shown(self.voltage[at], 'V')}", x=("field", "V/m"),
            y=("share of the area with a larger field", "1"), curves=tuple(curves),
            caption="Where the faces touch, the film has its part of the whole voltage: the step at the right.",
        )  # fmt: skip
        return [panel] if curves else []

    def _map(self) -> Drawing:
        at = self.at_largest_voltage
        return Drawing(
            id="gap",
            title=f"Gap at {_shown(self.voltage[at], 'V')}",
            plot="contact_map",
            of=self,
            caption="One period of the contact, which repeats beyond the edges. Places that touch are orange.",
        )


def rough_contact(
    scenario: Source,
    *,
    roughness: Topography | None = None,
    body: ElasticBody | None = None,
    voltage: ArrayLike | None = None,
    points: int | None = None,
    seed: int | None = None,
    spots: ContactSpots | None = None,
    frequency: float = 0.0,
) -> RestingContact:
    """Press a rough elastic body on the layers of a scenario, and solve contact and attraction together.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `electrovib.load`: load, contact area, and a stack with a gap that does not conduct, whose declared thickness
        has no effect.
    roughness : SelfAffine or MeasuredHeights, optional
        Roughness of both faces together. One period of its longest wave is computed, or a measured map and its mirror images.
        What is absent of roughness, body, points, seed and spots is that of contact.surface = RoughContact.
    body : Elastic or Coated, optional
        What is bent: the skin, with or without a film of another stiffness.
    voltage : array_like, shape (n,), optional
        Constant voltages [V] that the contact goes through in this order, up and down again where hysteresis is asked for, at
        most 64; by default the largest voltage of the drive. For a fast sine give the root mean square.
    points : int, optional
        Points along a side of the grid, at least 8 for the shortest wave and at most 2048; by default the least power of 2.
    seed : int, optional
        Of the random phases of the roughness; by default 0.
    spots : ContactSpots, optional
        Field where faces touch, as in ``force.spots``: `PullingSpots`, the default, `LeakingSpots` or `IdleSpots`.
    frequency : float, optional
        Of a sine whose root mean square the voltages are [Hz], which only leaking spots depend on; 0 for a constant voltage.

    Returns
    -------
    RestingContact
        Contact share, mean gap, attraction, force and capacitance at each voltage, the maps, and how much they change on a
        coarser grid and with a smoother roughness.

    Raises
    ------
    InputError
        If the gap is missing or conducts, nothing blocks, the body floats, the area grows with the force, or the grid is too
        coarse, or beyond the budget of time and memory.
    ElectrovibError
        If the contact does not come to rest, which the message explains.

    Notes
    -----
    Least sum of the elastic energy of the half-space, the work of the load, and the energy -eps0 V^2/(2 (g + K)) of the
    local gap g >= 0, with K the electrical thickness of the layers that block. Checked against Hertz, Westergaard's wave, pull-in
    of flat faces and a dense minimisation (`tests/reference/test_rough_contact.py`). Adhesion other than the attraction, plastic
    flow and capillary bridges are not included. The contact share depends on the shortest wave of the roughness, so it is
    stated beside a smoother one.

    References
    ----------
    Stanley and Kato 1997, contact of rough surfaces by Fourier transforms: cited from memory, unverified.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=1.25e-4)
    >>> found = ev.rough_contact("bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e7), voltage=[0, 20])
    >>> bool(found.attraction[1] > found.plates[1])
    True
    """
    known = read_scenario(scenario)
    stack = uniform_stack(known)
    if not stack.pressure > 0:
        raise InputError(
            "load.normal_force = 0: a rough contact rests under a load; give for instance '0.5 N'"
        )
    voltages = held_voltages(largest_voltage(known) if voltage is None else voltage)
    declared = _declared(known, roughness=roughness, body=body, points=points, seed=seed)
    roughness = declared.roughness
    share = share_of_field(spots or declared.spots, frequency)
    shape, periods = roughness.shape(declared.points), roughness.periods

    def solve(heights: Real) -> tuple[Rest, ...]:
        bent, thickness = declared.body.compliance, stack.electrical_thickness
        loaded = Loaded(heights=heights, periods=periods, compliance=bent, pressure=stack.pressure)
        found = follow_voltages(loaded, voltages.tolist(), electrical_thickness=thickness)
        return tuple(rest.with_field_share(share) for rest in found)

    # a half of them on coarser grids
    refuse_beyond_budget(math.isqrt(math.prod(shape)), 2 * voltages.size, kept=voltages.size)
    smooth = roughness.without_shortest_octave()
    heights, even = (each.heights(shape, periods, seed=declared.seed) for each in (roughness, smooth))
    rests = solve(heights)
    widest, largest = max(float(rest.gap.max()) for rest in rests), float(np.abs(voltages).max())
    diagnostics = closed_diagnostics(known, stack, voltage=largest, widest=widest)
    return RestingContact(
        stack=stack,
        voltage=voltages,
        rests=rests,
        coarser=_numbers(solve(heights[::2, ::2])),
        smoother=_numbers(solve(even[::2, ::2])),
        roughness=roughness,
        films=_films(diagnostics, stack, largest),
        field_share=share,
        diagnostics=(*_pull_ins(voltages, rests), *diagnostics),
    )


def _declared(scenario: Scenario, **given: Any) -> contact.RoughContact:
    """Return the contact that a scenario declares with what is given in its place, or that which is given as a whole."""
    surface, own = scenario.contact.surface, {name: each for name, each in given.items() if each is not None}
    tables = dict(surface) if isinstance(surface, contact.RoughContact) else {}
    if missing := [name for name in ("roughness", "body") if name not in tables | own]:
        raise InputError(
            f"{' and '.join(missing)}: not given, and contact.surface is no RoughContact, from which to take it; give for"
            " instance roughness=SelfAffine(...) and body=Elastic(modulus=1e6)"
        )
    return read_model(contact.RoughContact, tables | own)


def _pull_ins(voltages: Real, rests: Sequence[Rest]) -> Iterator[Diagnostic]:
    """Yield a warning for each two voltages between which the contact passes states that are not stable."""
    for before, after, rest in zip((0.0, *voltages), voltages, rests, strict=False):
        if rest.fell:
            text = (
                f"between {_shown(before, 'V')} and {_shown(after, 'V')} the contact passes states that are not stable: it may"
                " fall into another one and keep it while the voltage falls again; take smaller steps there, up and down"
            )
            yield Diagnostic("pull-in", "warning", text, after, before, "V")


def _films(diagnostics: Sequence[Diagnostic], stack: BlockingStack, voltage: float) -> tuple[Film, ...]:
    """Return the films among the blocking layers, from diagnostics of the whole area touching under a voltage [V]."""
    judged = {each.name: each for each in diagnostics}
    found = [(name, judged.get(f"{FILM}, {name}")) for name in stack.blocking]
    return tuple(
        Film(name, each.value / voltage, each.limit)
        for name, each in found
        if each is not None and each.value is not None and each.limit is not None and voltage
    )


def _numbers(rests: tuple[Rest, ...]) -> Real:
    return np.array([[rest.contact_share, rest.mean_attraction] for rest in rests]).T


def _shown(value: float, unit: str) -> str:
    return f"{100 * value:.3g} %" if unit == "1" else format_quantity(value, unit, digits=4)
