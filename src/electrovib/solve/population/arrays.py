"""Signals of many fingers in arrays over fingers: columns -> modes or phasors -> responses -> force -> friction."""

from __future__ import annotations

from threading import Lock
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.core.paths import quantity_at, value_at
from electrovib.core.tables import derived_at
from electrovib.physics.stack import INTERFACE
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.over_frequency import OVER_FREQUENCY, loudest_tone, over_frequency
from electrovib.solve.electrics.solution import Solution, linear_quantities
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.mechanics.mechanical import FrictionChain
from electrovib.solve.population.columns import (
    check_values,
    debye_of,
    shared_reductions,
    with_columns,
)
from electrovib.solve.population.response import (
    SharedDrive,
    excitation,
    joined,
    respond,
    shared_drive,
    some_of,
)
from electrovib.solve.stack.expand import modes_of, phasors
from electrovib.solve.stack.harmonics import refuse_unrepeated
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.one_by_one import ParametricScenario
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer

LAYERED: Final[dict[str, type[FieldOf | DisplacementOf]]] = {"field": FieldOf, "displacement": DisplacementOf}
OF_FIELDS: Final = frozenset({*LAYERED, "interface_field", "stack_voltage", "current"})
"""Signals of the stack that are linear in the drive."""
OVER_TIME: Final = OF_FIELDS | {
    "drive_voltage",
    "electrostatic_force",
    "effective_voltage",
    "normal_force",
    "sliding_speed",
    "lateral_force",
}
"""Signals over time that are computed in arrays."""
STACKS: Final = 1024
"""Fingers whose modes are in memory together."""
RESPONSES: Final = 1 << 16
"""Numbers of the responses in memory together, about."""
FEWEST: Final = 64
"""Smallest number of fingers whose responses are computed together."""
AGREE: Final = 1e-11
"""Largest difference over the peak of a signal; a formula that is no formula of one finger differs by more."""
OF_CURRENT: Final = 1e-9
"""The same of a current: rounding of the time decides what remains of the fastest mode after a corner, some 1e-10."""
SCALED: Final = 1e-6
"""The same where a permittivity is scaled: the least squares of the scaled one end elsewhere within their own error, 1e-5."""
_NUDGE: Final = 0.05
_FAINT: Final = 1e-9
"""Share of the largest value that is compared for a parameter whose value is 0."""
_COLUMNS: Final = ("stack.", "circuit.", "contact.area", "drive.", "force.", "friction.", "load.normal_force")
"""Beginnings of the paths that may be columns."""


class Arrays:
    """Fingers of a scenario of the linear chain, in arrays.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    prepared : ParametricScenario
        The scenario as a function of the parameters that differ between fingers; two are compared with those one by one.
    names : tuple of str
        Signals, all over time or all over frequency.
    time : ndarray, shape (n,), or None
        Output times [s]; None for signals over frequency.
    band : ndarray, shape (m,), or None
        Times over whose band materials are reduced [s]; by default the output times.

    Raises
    ------
    NotInArraysError
        If arrays do not cover the scenario or what differs, with the reason.
    """

    def __init__(
        self,
        scenario: Scenario,
        prepared: ParametricScenario,
        names: tuple[str, ...],
        time: Real | None,
        band: Real | None,
    ) -> None:
        free = prepared.free
        _refuse(scenario, free, names)
        self.scenario, self.free, self.names, self.prepared = scenario, free, names, prepared
        self._lock = Lock()  # one scenario at a time is prepared for fingers that are solved one by one
        self.time, self._band = time, band
        self.frequency = scenario.frequency.frequencies()
        self._quantities = {path: quantity_at(scenario, path) for path in free}
        of_drive = tuple(path for path in free if path.startswith("drive."))
        times = scenario.time.times(scenario.drive) if self.time is None else self.time
        self._largest: Any = scenario.drive.largest() if self.time is None else 0.0
        self.drive: SharedDrive | None = None
        if self.time is not None or of_drive:
            self.drive = self._shared(of_drive, times)
        if self.time is None and of_drive:
            self._largest = self._largest_per_parameter()
        of_law = {"electrostatic_force", "lateral_force", "effective_voltage"}
        self._has_modes = bool((OF_FIELDS | of_law if scenario.force.causal else OF_FIELDS) & {*names})
        over = self.time if band is None else band
        self._reduced = {} if over is None or not self._has_modes else shared_reductions(scenario, free, over)
        if self._reduced and self.drive is None:
            raise NotInArraysError(
                "the band over which materials are reduced follows from the drive of each finger"
            )
        self._compare()

    def _shared(self, of_drive: tuple[str, ...], times: Real) -> SharedDrive | None:
        """Return the drive of all fingers as a sum; None where each has times or frequencies of its own."""
        try:
            return shared_drive(self.scenario, of_drive, times, settled=self.scenario.time.settled)
        except NotInArraysError:
            if self.time is None or not self.scenario.force.causal:
                raise
            excitation(self.scenario.drive, times, settled=self.scenario.time.settled)
            return None

    def signals(self, draws: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals of fingers."""
        found: dict[str, Any] = {}
        count = len(next(iter(draws.values())))
        for fingers, rows in self.parts(draws):
            for name, each in rows.items():
                if name not in found:
                    found[name] = np.empty((count, *each.shape[1:]), each.dtype)
                found[name][fingers] = each
        return {name: found[name] for name in self.names}

    def _alone(self, draws: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals of fingers, each computed by itself."""
        return self.prepared.of_many(draws, names=self.names, time=self.time, band=self._band)

    def parts(self, draws: Mapping[str, Real]) -> Iterator[tuple[Any, dict[str, Any]]]:
        """Yield the indices and the signals of some fingers after the other."""
        check_values(self.scenario, self._quantities, draws)
        for fingers in _of_one_form(draws):
            for begin in range(0, len(fingers), STACKS):
                left = fingers[begin : begin + STACKS]
                some = {path: values[left] for path, values in draws.items()}
                try:
                    for rows, size in self._parts(some, len(left)):
                        yield _range(left[:size]), rows
                        left = left[size:]
                except NotInArraysError:  # fingers with fewer modes among others
                    with self._lock:
                        rows = self._alone({path: values[left] for path, values in draws.items()})
                    yield _range(left), rows

    def _parts(self, draws: Mapping[str, Real], rows: int) -> Iterator[tuple[dict[str, Any], int]]:
        """Yield the signals of some fingers after the other, and how many these are."""
        columns = {path: np.ascontiguousarray(each, dtype=float)[:, None] for path, each in draws.items()}
        inner = {path: column for path, column in columns.items() if not path.startswith("drive.")}
        member = with_columns(self.scenario, inner)
        asked = self._asked(member) if self._has_modes else {}
        numbers = len(self.frequency) if self.time is None else len(self.time)
        at_once = max(FEWEST, RESPONSES // numbers)
        for first in range(0, rows, at_once):
            part = slice(first, min(first + at_once, rows))
            some = with_columns(self.scenario, {path: each[part] for path, each in inner.items()})
            mine = {path: each[part] for path, each in columns.items()}
            driven = self._driven({path: values[part] for path, values in draws.items()}, mine)
            with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
                found = (
                    self._over_frequency(some, mine)
                    if self.time is None
                    else self._over_time(some, some_of(asked, part), driven)
                )
            size = part.stop - first
            for name, each in found.items():
                found[name] = np.broadcast_to(each, (size, *each.shape[each.ndim - self._axes(name) :]))
            yield found, size

    def _axes(self, name: str) -> int:
        """Return the number of axes of a signal of one finger."""
        return 2 if name in LAYERED or name in {"field_gain", "permittivity"} else 1

    def _asked(self, member: Scenario) -> dict[Key, Transfer]:
        """Return the linear quantities that the signals need."""
        debye = debye_of(member, self._reduced, self.free)
        known = linear_quantities(member, modes_of(member, debye))
        wanted = set[Any]()
        if {"electrostatic_force", "lateral_force"} & {*self.names}:
            wanted |= {key for key in known if isinstance(key, AmplitudeOf)}
        for name in self.names:
            if name in OF_FIELDS or (name == "effective_voltage" and member.force.causal):
                wanted |= {*_keys(member, name)}
        missing = [str(key) for key in wanted if key not in known]
        if missing:
            raise NotInArraysError(f"the scenario has no {missing[0]}")
        return {key: known[key] for key in known if key in wanted}

    def _driven(
        self, draws: Mapping[str, Real], columns: Mapping[str, Real]
    ) -> list[tuple[slice, list[Any]]]:
        """Return ranges of fingers, and the factors and drives that add up to the drive of each range."""
        if self.time is None:
            return []
        if self.drive is not None:
            return [(slice(None), self.drive.terms(columns))]
        settled, found = self.scenario.time.settled, []
        mine = {path: values.tolist() for path, values in draws.items() if path.startswith("drive.")}
        for finger, values in enumerate(zip(*mine.values(), strict=True)):
            with self._lock:
                drive = self.prepared.scenario(dict(zip(mine, values, strict=True))).drive
            if settled:
                refuse_unrepeated(drive)
            own = excitation(drive, self.time, settled=settled)
            found.append((slice(finger, finger + 1), [(1.0, own)]))
        return found

    def _over_time(
        self, member: Scenario, asked: Mapping[Key, Transfer], driven: list[tuple[slice, list[Any]]]
    ) -> dict[str, Any]:
        """Return the signals over time of some fingers."""
        time = self.time
        assert time is not None
        each = [respond(some_of(asked, some), terms) for some, terms in driven]
        rows: dict[Any, Any] = {key: joined(row[key] for row in each) for key in asked}
        if not member.force.causal:
            rows |= self._of_one_sine(member, driven[0][1])
        found: dict[str, Any] = {}
        amplitudes = {key.name: row for key, row in rows.items() if isinstance(key, AmplitudeOf)}
        force = attraction(member, total_pull(member, amplitudes), time) if amplitudes else None
        for name in self.names:
            if name == "electrostatic_force":
                found[name] = force
            elif name == "lateral_force":
                found[name] = self._friction(member, force)
            elif name == "drive_voltage":
                found[name] = joined(
                    np.atleast_2d(total_of(factor * drive.values() for factor, drive in terms))
                    for _, terms in driven
                )
            elif name == "normal_force":
                found[name] = member.load.forces(time)
            elif name == "sliding_speed":
                found[name] = member.motion.speeds(time)
            else:
                of_layers = [rows[key] for key in _keys(member, name)]
                is_layered = name in LAYERED
                found[name] = (
                    np.stack(np.broadcast_arrays(*of_layers), axis=-2) if is_layered else of_layers[0]
                )
        return found

    def _of_one_sine(self, member: Scenario, terms: list[Any]) -> dict[Key, Any]:
        """Return the amplitudes of a law that is defined by magnitudes at the frequency of one sine."""
        frequency, _ = loudest_tone(self.scenario)
        moments = terms[0][1].moments
        tone: Any = total_of(
            factor * drive.tones[moments.frequencies == frequency].sum() for factor, drive in terms
        )
        wave = tone * np.exp(2j * np.pi * frequency[0] * moments.outputs)
        exact = phasors(member, frequency)
        found: dict[Key, Any] = {
            AmplitudeOf(name): np.real(value * wave) for name, value in member.force.amplitudes(exact).items()
        }
        effective = member.force.effective_voltage(exact)
        return found if effective is None else found | {"effective_voltage": np.real(effective * wave)}

    def _friction(self, member: Scenario, force: Any) -> Real:
        """Return a friction without memory."""
        solution = Solution(found={}, method=chosen(self.scenario).method, reason="", force=force)
        assert self.time is not None
        chain = FrictionChain(member, self.time, solution, lambda _: solution)
        return chain.known(chain.steady(self.time, force))

    def _over_frequency(self, member: Scenario, columns: Mapping[str, Real]) -> dict[str, Any]:
        """Return the signals over frequency of some fingers."""
        largest: Any = self._largest
        if not isinstance(largest, float):
            largest = np.abs(columns[largest[0]]) * largest[1]
        found = over_frequency(
            member, phasors(member, self.frequency), amplitude=largest, wanted=frozenset(self.names)
        )
        missing = [name for name in self.names if name not in found]
        if missing:
            raise NotInArraysError(f"the scenario has no {missing[0]}")
        return {name: found[name][1] for name in self.names}

    def _largest_per_parameter(self) -> tuple[str, float]:
        """Return the path to which the largest value of the drive [V] is proportional, and the factor."""
        assert self.drive is not None
        if self.drive.fixed is not None or len(self.drive.shares) != 1:
            raise NotInArraysError("the largest voltage is not proportional to one parameter of the drive")
        (path,) = self.drive.shares
        value = abs(float(value_at(self.scenario, path)))
        if not value:
            raise NotInArraysError("the largest voltage of the scenario is 0")
        return path, self.scenario.drive.largest() / value

    def _compare(self) -> None:
        """Refuse arrays whose fingers differ from the same fingers one by one."""
        draws = self._two()
        try:
            expected = self._alone(draws)
        except ElectrovibError as error:
            raise NotInArraysError(
                f"not all values next to those of the scenario are allowed: {error}"
            ) from None
        try:
            ((found, _),) = self._parts(draws, 2)
        except (TypeError, ValueError, AttributeError, AssertionError) as error:
            raise NotInArraysError(
                f"a formula of the scenario does not run on arrays ({type(error).__name__})"
            ) from None
        is_scaled = any(each.is_scaled for each in self._reduced.values())
        for name, rows in expected.items():
            limit = SCALED if is_scaled else OF_CURRENT if name == "current" else AGREE
            for mine, its in zip(found[name], rows, strict=True):
                if not _agree(mine, its, limit):
                    raise NotInArraysError(f"{name} in arrays differs from that of one finger")

    def _two(self) -> dict[str, Real]:
        """Return the values of the scenario, and values next to them within the ranges."""
        found = {}
        for path, value in self.prepared.begin.items():
            if not isinstance(value, float):
                raise NotInArraysError(f"{path} has no value in the scenario")
            quantity = self._quantities[path]
            step = _NUDGE * abs(value) or _FAINT * max(abs(quantity.low), abs(quantity.high))
            begin = value or step  # a number of 0 may give fewer modes than others
            found[path] = np.array([begin, begin - step if begin + step > quantity.high else begin + step])
        return found


def _keys(member: Scenario, name: str) -> list[Key]:
    """Return the keys of the linear quantities of a signal."""
    if name in LAYERED:
        return [LAYERED[name](layer) for layer in member.stack.layers]
    return [FieldOf(member.stack.gap_name or INTERFACE) if name == "interface_field" else name]


def _of_one_form(draws: Mapping[str, Real]) -> list[Any]:
    """Return groups of fingers whose values of 0 are those of the same parameters: these may have fewer modes."""
    zero = np.array([values == 0 for values in draws.values()])
    if not zero.any():
        return [np.arange(zero.shape[1])]
    _, group = np.unique(zero, axis=1, return_inverse=True)
    group = group.reshape(-1)
    return [np.flatnonzero(group == each) for each in range(int(group.max()) + 1)]


def _range(fingers: Any) -> Any:
    """Return indices as a range where they are one: it is written faster than a list."""
    first, stop = int(fingers[0]), int(fingers[-1]) + 1
    return slice(first, stop) if stop - first == len(fingers) else fingers


def _agree(mine: Any, its: Any, limit: float) -> bool:
    """Return whether the signals of one finger agree, NaN included."""
    unknown = np.isnan(its)
    if mine.shape != its.shape or not np.array_equal(unknown, np.isnan(mine)):
        return False
    peak = float(np.max(np.abs(its[~unknown]), initial=0.0))
    return bool(np.all(np.abs(mine[~unknown] - its[~unknown]) <= limit * peak))


def _refuse(scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...]) -> None:
    """Refuse scenarios, signals and parameters that arrays do not cover."""
    foreign = [name for name in names if name not in OVER_TIME | OVER_FREQUENCY]
    if foreign:
        raise NotInArraysError(f"the signal {foreign[0]} is computed for one finger at a time")
    method = chosen(scenario).method
    if not method.by_modes:
        raise NotInArraysError(f"the electrical solver is '{method.name}'")
    if "drive_voltage" in names and scenario.drive.quantity == "current":
        raise NotInArraysError("the drive is a current, whose voltage is computed for one finger at a time")
    if scenario.circuit.amplifier is not None:
        raise NotInArraysError("there is an amplifier before the plate")
    _refuse_columns(scenario, free)
    if "sliding_speed" in names and scenario.motion.speed is None:
        raise InputError("signals: this scenario has no 'sliding_speed'. Declare motion.speed")
    if "lateral_force" in names:
        _refuse_memory(scenario)


def _refuse_columns(scenario: Scenario, free: tuple[str, ...]) -> None:
    """Refuse parameters whose values cannot be a column."""
    if scenario.moisture is not None:
        raise NotInArraysError("moisture sets other parameters of each finger")
    for path in free:
        if derived_at(scenario, path) is not None and not path.startswith("drive."):
            raise NotInArraysError(f"{path} is derived from other parameters")
        if not path.startswith(_COLUMNS):
            raise NotInArraysError(
                f"{path} is no number of the layers, the circuit, the drive, the law, the area, the load or the friction"
            )


def _refuse_memory(scenario: Scenario) -> None:
    """Refuse frictions that depend on the past."""
    if scenario.friction.has_memory:
        raise NotInArraysError(f"{type(scenario.friction).__name__} has a memory")
    if resting(scenario.motion) and scenario.finger is not None:
        raise NotInArraysError("the skin holds a friction while the finger rests")
