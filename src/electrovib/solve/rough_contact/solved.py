"""A declared rough contact, solved once at rising voltages and kept: attraction and real contact for a run, a study and a fit.

The voltages are a ladder of load and layers alone, climbed as far as it is asked for, so that a number does not depend on what
else was asked before.
"""

from __future__ import annotations

import math
from threading import Lock
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.units import format_quantity
from electrovib.physics.contact import RoughContact
from electrovib.physics.force import TabulatedAttraction
from electrovib.solve.meter import Meter
from electrovib.solve.rough_contact.cell import MaxwellStress
from electrovib.solve.rough_contact.rest import Loaded, Rest, doubts, refuse_beyond_budget
from electrovib.solve.stack.blocking import uniform_stack

if TYPE_CHECKING:
    from collections.abc import Iterable

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario

FAINT: Final = 0.03
"""Attraction where faces touch, over the load, at the first voltage of the ladder."""
STEP: Final = 1.1
"""Ratio of voltages of the ladder: attractions between them are within 5e-3."""
ABRUPT, JUMP = 1e-3, 1e-2
"""Change of the voltage, relative, within which the attraction over its square grows by this share where a contact falls."""
EXPECTED: Final = 50
"""Contacts of a ladder that are counted before it is climbed."""
ROUNDING: Final = 1e-9
FEWER: Final = "lower the voltage, or give fewer points"
PARTS: Final = 4096
KEPT: Final = 16
"""Ladders that are kept in a process."""


_LADDERS: Final = list["SolvedContact"]()
_LOCK: Final = Lock()


class SolvedRest(NamedTuple):
    """Voltage [V], mean attraction [Pa], share in contact [1], steepness, and gaps [m] of equal parts of the area, of a rest."""

    voltage: float
    attraction: float
    contact_share: float
    steepness: float
    gaps: Real


class SolvedContact:
    """The rests of a contact at rising voltages, under a mean `pressure` [Pa], on layers of an electrical thickness [m].

    `rows` are those that were solved so far, and `fall` the voltage [V] beyond which the contact, or a first part of it, fell
    into another rest; None where it did not.
    """

    def __init__(self, surface: RoughContact, *, pressure: float, electrical_thickness: float) -> None:
        shape, periods = surface.roughness.shape(surface.points), surface.roughness.periods
        refuse_beyond_budget(math.isqrt(math.prod(shape)), EXPECTED)
        self.surface, self.pressure, self.electrical_thickness = surface, pressure, electrical_thickness
        self._loaded = Loaded(
            heights=surface.roughness.heights(shape, periods, seed=surface.seed),
            periods=periods,
            compliance=surface.body.compliance,
            pressure=pressure,
        )
        self._share = float(abs(surface.spots.field_share(np.asarray(0.0))))
        self._lock = Lock()
        self._law: TabulatedAttraction | None = None
        self.rows = list[SolvedRest]()
        self.fall: float | None = None
        self._keep(0.0, self._loaded.rest())

    def law(self, voltage: float) -> TabulatedAttraction:
        """Return the attraction over the voltage, as a table that reaches a voltage [V]."""
        with self._lock:
            if len(self.rows) < 2:
                self._climb()
            self._reach("voltage", voltage, end=voltage)
            if self._law is None:
                voltages, attractions, *_ = zip(*self.rows, strict=True)
                self._law = TabulatedAttraction(voltage_samples=voltages, attraction_samples=attractions)
            return self._law

    def attraction(self, V: Real) -> Real:
        """Return the attraction per area [Pa] at voltages [V] across gap and layers that block."""
        largest = np.max(np.abs(V), initial=0.0, where=np.isfinite(V))
        return self.law(float(largest)).pressure(V=V)

    def contact_share(self, pressure: Real) -> Real:
        """Return the share in contact [1] under pressures of load and attraction together [Pa]."""
        largest = float(np.max(pressure, initial=0.0, where=np.isfinite(pressure))) - self.pressure
        with self._lock:
            self._reach("attraction", largest * (1 - ROUNDING), end=largest)
            attraction, share = (self._column(name) for name in ("attraction", "contact_share"))
        return np.asarray(np.interp(pressure, self.pressure + attraction, share))

    def gaps(self, voltage: float) -> Real:
        """Return gaps [m] of equal parts of the area in rising order, at the first voltage of the ladder from this one [V] on."""
        self.law(voltage)
        return next(row.gaps for row in self.rows if row.voltage >= voltage)

    def _column(self, name: str) -> Real:
        return np.array([getattr(row, name) for row in self.rows])

    def diagnostics(self, attraction: float) -> tuple[Diagnostic, ...]:
        """Return how a contact was solved that reached an attraction [Pa], and a warning where it fell before."""
        voltages, attractions, steepness = map(self._column, ("voltage", "attraction", "steepness"))
        reached = float(np.interp(attraction, attractions, voltages))
        pressure, roughness = format_quantity(self.pressure, "Pa", digits=3), self.surface.roughness
        text = (
            f"attraction and real contact are those of contact.surface, solved under a load of {pressure} at rising constant"
            " voltages; the contact follows the voltage at once, and electrovib.rough_contact states what a coarser grid and a"
            " smoother roughness would give"
        )
        said = doubts(
            rms_slope=roughness.rms_slope(roughness.periods),
            steepness=float(np.interp(attraction, attractions, steepness)),
        )
        found = [
            Diagnostic("rough contact", "unknown", text),
            *(Diagnostic("rough contact", "warning", f"contact.surface: {each}") for each in said),
        ]
        if self.fall is not None and self.fall * (1 + ROUNDING) < reached:
            found.append(_pull_in(self.fall, reached))
        return tuple(found)

    def _reach(self, name: str, least: float, *, end: float) -> None:
        """Climb until a number of the last rest, its voltage or its attraction, is not below a least one."""
        meter = Meter("the rough contact", end=end, of="rising voltages", remedy=FEWER)
        while getattr(self.rows[-1], name) < least:
            self._climb()
            meter.count(getattr(self.rows[-1], name))

    def _climb(self) -> None:
        """Solve the next voltage of the ladder, in smaller steps where the contact would fall for the first time."""
        begin, first = self.rows[-1].voltage, self._first
        end = first * STEP ** (math.floor(math.log(begin / first, STEP) + ROUNDING) + 1) if begin else first
        try:
            rest = self._loaded.rest(self._pull(end), start=self._gap)
            while self._jumps(end, rest) and end - begin > ABRUPT * end:
                end = (begin + end) / 2
                rest = self._loaded.rest(self._pull(end), start=self._gap)
        except ElectrovibError as error:
            raise InputError(
                f"contact.surface: it is known up to {format_quantity(begin, 'V', digits=4)}, and at"
                f" {format_quantity(end, 'V', digits=4)} {error}"
            ) from error
        if self._jumps(end, rest):
            self.fall = begin
        self._keep(end, rest)

    def _jumps(self, voltage: float, rest: Rest) -> bool:
        """Return whether the contact falls for the first time, or may do so, up to a voltage [V]."""
        begin, attraction, *_ = self.rows[-1]
        if not (begin and rest.fell) or self.fall is not None:
            return False
        found = rest.with_field_share(self._share).mean_attraction
        return found / attraction * (begin / voltage) ** 2 > 1 + JUMP

    def _keep(self, voltage: float, rest: Rest) -> None:
        seen = rest.with_field_share(self._share)
        if voltage and not seen.mean_attraction > self.rows[-1].attraction:
            last = format_quantity(self.rows[-1].voltage, "V", digits=4)
            raise InputError(
                f"contact.surface: beyond {last} the attraction does not rise with the voltage, because more of the area touches,"
                " which does not attract; give spots that pull, or lower the voltage"
            )
        self._gap = rest.gap
        self.rows.append(
            SolvedRest(voltage, seen.mean_attraction, seen.contact_share, rest.steepness, _parts(rest.gap))
        )
        self._law = None

    def _pull(self, voltage: float) -> MaxwellStress:
        return MaxwellStress(voltage=voltage, electrical_thickness=self.electrical_thickness)

    @property
    def _first(self) -> float:
        return self.electrical_thickness * math.sqrt(2 * FAINT * self.pressure / eps0)


def _parts(gap: Real) -> Real:
    """Return the gaps of at most `PARTS` equal parts of the area, in rising order."""
    ordered = np.sort(gap, axis=None)
    return np.asarray(ordered[np.linspace(0, ordered.size - 1, min(PARTS, ordered.size)).astype(int)])


def _pull_in(fall: float, reached: float) -> Diagnostic:
    """Return the warning that a voltage reached [V] is beyond that [V] at which a contact falls into another rest."""
    text = (
        f"beyond {format_quantity(fall, 'V', digits=4)} the contact, or a part of it, falls shut, and the voltage reaches"
        f" {format_quantity(reached, 'V', digits=4)}: attraction and real contact beyond it are those of a voltage that"
        " rises; the contact stays shut while the voltage falls again, which is not followed"
    )
    return Diagnostic("pull-in", "warning", text, reached, fall, "V")


def solved_contact(scenario: Scenario) -> SolvedContact | None:
    """Return the contact of a scenario that declares one to be solved, as far as it was solved before; None of any other."""
    surface, law = scenario.contact.surface, scenario.force
    if not (isinstance(surface, RoughContact) and isinstance(law, TabulatedAttraction) and law.is_solved):
        return None
    stack = uniform_stack(scenario)
    pressure, thickness = stack.pressure, stack.electrical_thickness
    with _LOCK:
        for place, known in enumerate(_LADDERS):
            same = (known.pressure, known.electrical_thickness) == (pressure, thickness)
            if same and (known.surface is surface or known.surface == surface):
                _LADDERS.append(_LADDERS.pop(place))
                return known
        found = SolvedContact(surface, pressure=pressure, electrical_thickness=thickness)
        _LADDERS.append(found)
        del _LADDERS[:-KEPT]
    return found


def contact_of_each(scenario: Scenario, free: Iterable[str]) -> str:
    """Return the first of some paths whose values each have a contact of their own to solve; empty if none has."""
    if not isinstance(scenario.contact.surface, RoughContact):
        return ""
    layers = [f"stack.{name}." for name in uniform_stack(scenario).blocking]
    changing = ("contact.", "load.", f"stack.{scenario.stack.gap_name}.material.", *layers)
    return next((path for path in free if path.startswith(changing)), "")


def refuse_unsolved_contact(scenario: Scenario) -> None:
    """Refuse what a contact that is solved under one load and the same voltage everywhere does not describe."""
    if not isinstance(scenario.contact.surface, RoughContact):
        return
    law, what = scenario.force, "contact.surface = RoughContact is solved"
    if not (isinstance(law, TabulatedAttraction) and law.is_solved):
        raise InputError(
            f'force = {type(law).__name__}: {what} together with its attraction; give force = {{ model = "TabulatedAttraction"'
            " }, which takes it from there, or contact.surface = FittedSurface, which gives the real contact alone"
        )
    if not scenario.load.time_profile.is_constant:
        raise InputError(f"load.time_profile: {what} under a constant load; omit the time profile")
    if scenario.motion.distance is not None or scenario.contact.closing is not None:
        path = "contact.closing" if scenario.motion.distance is None else "motion.distance"
        raise InputError(f"{path}: {what} for its gaps, and no gap moves beside them; omit it")
    if leaks := [name for name, layer in scenario.stack.layers.items() if layer.leak is not None]:
        raise InputError(
            f"stack.{leaks[0]}.leak: {what} with layers that block or conduct; omit the leak, or give a material.conductivity"
        )
    stack = uniform_stack(scenario)
    if not stack.pressure > 0:
        raise InputError(
            "load.normal_force = 0: a rough contact rests under a load; give for instance '0.5 N'"
        )
