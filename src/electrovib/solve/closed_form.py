"""Signals under a drive of straight pieces in closed form: sums of polynomials and decaying exponentials on each piece.

Linear layers under a drive of few straight pieces, with a law of second degree and linear friction and sensors behind it, are
evaluated in closed form; all others as by `Expanded.at`.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from functools import reduce
from itertools import combinations, pairwise
from operator import add
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import without
from electrovib.physics.drive.parts import Linear
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.over_frequency import capacitance, sine_of
from electrovib.solve.electrics.solution import amplitudes, linear_quantities
from electrovib.solve.expanded import Expanded
from electrovib.solve.mechanics.filters import cascade, of_stages
from electrovib.solve.mechanics.lateral import friction_filter, memory_changes, resting
from electrovib.solve.mechanics.rig import finger_filters
from electrovib.solve.stack.keys import amplitudes_among

if TYPE_CHECKING:
    from collections.abc import Callable, Collection, Mapping, Sequence

    from electrovib.core.arrays import Complex, Numbers, Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.filters import Filter
    from electrovib.solve.one_by_one import ParametricScenario
    from electrovib.solve.stack.section import ModalSection
    from electrovib.solve.stack.transfer import Transfer


SLOWEST: Final = 1e-4
"""Product of a rate and the whole time below which the closed form would be a small difference of large numbers."""
_APART: Final = 1e-4
"""Relative distance between a pole of a filter and an exponential of its input below which there is no such form."""
_DECAYED: Final = 80.0
"""Time constants after which an exponential counts as 0: 2e-35 of it remains."""


@dataclass(frozen=True, eq=False)
class Pieces:
    """Output times (n,) [s], each in the straight piece of a drive that contains it, at a break in the later one.

    `groups` are the pieces that contain output times: number of the piece, which output times, and these times since its
    begin [s].
    """

    part: Linear
    times: Real
    groups: tuple[tuple[int, slice, Real], ...]

    @classmethod
    def of(cls, drive: Drive, times: Real) -> Pieces:
        """Assign output times to the pieces of a drive, which has one part."""
        (part,) = drive.parts()
        assert isinstance(part, Linear)
        part = part.until(float(times[-1]))
        index, elapsed = part.locate(times)
        edges = np.searchsorted(index, np.arange(len(part.times) + 1)).tolist()
        places = [(piece, slice(*ends)) for piece, ends in enumerate(pairwise(edges)) if ends[0] < ends[1]]
        return cls(part, times, tuple((piece, some, elapsed[some]) for piece, some in places))


@dataclass(frozen=True, eq=False)
class Decays:
    """Exponentials exp(-rate s) of the time s since the begin of a piece, the first of rate 0.

    `rates` (1 + modes,) [1/s]; `inside` are the exponentials at the output times of each group, (1 + modes, n).
    """

    pieces: Pieces
    rates: Real
    inside: tuple[Real, ...]

    @classmethod
    def of(cls, pieces: Pieces, rates: Real) -> Decays:
        """Evaluate the exponentials of rates (modes,) above 0 [1/s] at the output times."""
        inside = tuple(_decays(rates, since) for _, _, since in pieces.groups)
        return cls(pieces, np.append(0.0, rates), inside)


def _decays(rates: Real, since: Real) -> Real:
    """Return 1 and exp(-rate s) at increasing times, shape (1 + modes, n), 0 where it is below rounding."""
    found = np.zeros((1 + len(rates), len(since)))
    found[0] = 1.0
    for row, rate, last in zip(found[1:], rates, np.searchsorted(since, _DECAYED / rates), strict=True):
        np.exp(-rate * since[:last], out=row[:last])
    return found


@dataclass(frozen=True, eq=False)
class ExponentialSum:
    """Signal that is the sum of c_mjk s^m exp(-(r_j + r_k) s) on each piece.

    `terms` (powers, pieces, 1 or 1 + modes, 1 + modes) are the coefficients c, in the unit of the signal over s^m; a signal
    that is linear in the drive has the first row alone, whose rate is 0.
    """

    decays: Decays
    terms: Numbers

    def values(self) -> Real:
        """Return the signal at the output times, shape (n,), in its unit."""
        pieces, rows = self.decays.pieces, self.terms.shape[-2]
        found = np.zeros(len(pieces.times))
        for (piece, where, since), decay in zip(pieces.groups, self.decays.inside, strict=True):
            row = found[where]
            for terms in self.terms[::-1, piece]:
                row *= since
                if terms.any():
                    row += (
                        np.einsum("jn,jn->n", terms @ decay, decay[:rows]) if rows > 1 else terms[0] @ decay
                    )
        return found

    def at_ends(self) -> Numbers:
        """Return the signal just before the end of each piece but the last, shape (pieces - 1,), in its unit."""
        since = self.decays.pieces.part.lengths
        decay = np.exp(np.outer(since, -self.decays.rates))
        powers = since ** np.arange(len(self.terms))[:, None]
        sides = decay[:, : self.terms.shape[-2]], decay
        found: Numbers = np.einsum("mp,mpjk,pj,pk->p", powers, self.terms[:, :-1], *sides)
        return found

    def __mul__(self, factor: float) -> ExponentialSum:
        """Return the signal multiplied by a factor."""
        return ExponentialSum(self.decays, self.terms * factor)

    def __add__(self, other: ExponentialSum) -> ExponentialSum:
        """Return the sum of two signals of the same exponentials."""
        return ExponentialSum(self.decays, self.terms + other.terms)

    def shifted(self, level: float) -> ExponentialSum:
        """Return the signal with a constant added."""
        terms = self.terms.copy()
        terms[0, :, 0, 0] += level
        return ExponentialSum(self.decays, terms)


def product(one: ExponentialSum, other: ExponentialSum) -> ExponentialSum:
    """Multiply two signals that are linear in the drive."""
    a, b = one.terms[:, :, 0, :, None], other.terms[:, :, 0, None, :]
    return ExponentialSum(one.decays, np.stack([a[0] * b[0], a[0] * b[1] + a[1] * b[0], a[1] * b[1]]))


def active_rates(transfers: list[Transfer], *, end: float) -> Real | None:
    """Return the rates (modes,) of the modes that a drive excites; None where the quantities have no closed form."""
    rates = transfers[0].rates
    for each in transfers:
        if (each.rates is not rates and not np.array_equal(each.rates, rates)) or np.any(each.free):
            return None
    active = rates[_active(transfers)]
    return active if np.all(active * end > SLOWEST) else None


def _active(transfers: list[Transfer]) -> Real:
    gains = np.array([each.gains for each in transfers])
    return np.asarray(np.any(gains != 0, axis=0) & (transfers[0].rates > 0))


def linear_sums(transfers: list[Transfer], decays: Decays) -> list[ExponentialSum]:
    """Compute quantities that are linear in the drive, from rest.

    In a piece with drive v + v' s every mode is x = v + v' s - v'/r + (x_0 - v + v'/r) exp(-r s).
    """
    part, rates, active = decays.pieces.part, decays.rates[1:], _active(transfers)
    slopes = part.slopes()
    bends = np.diff(slopes, prepend=0.0)[:, None] / rates - part.jumps[:, None]
    falls = np.exp(np.outer(np.append(0.0, part.lengths), -rates))
    deviations = [np.zeros(len(rates))]  # of x - v + v'/r, few pieces by a plain loop
    for fall, bend in zip(falls, bends, strict=True):
        deviations.append(deviations[-1] * fall + bend)
    found = []
    for each in transfers:
        gains, level = each.gains[active], each.at_rest()
        terms = np.zeros((2, len(slopes), 1, 1 + len(rates)))
        terms[0, :, 0, 0] = level * part.after + (each.slope - np.sum(gains / rates)) * slopes
        terms[1, :, 0, 0] = level * slopes
        terms[0, :, 0, 1:] = gains * deviations[1:]
        found.append(ExponentialSum(decays, terms))
    return found


def has_closed_form(filter_: Filter, rates: Real) -> bool:
    """Tell whether no pole of a filter is close to a sum of two of the rates of its input, the first of which is 0."""
    near = np.abs(filter_.poles[:, None] + (rates[:, None] + rates).ravel())
    return bool(np.all(near > _APART * np.abs(filter_.poles)[:, None]))


def filtered_sum(filter_: Filter, given: ExponentialSum, level: float) -> Real:
    """Compute the output (n,) of a filter that has settled to a level before the first piece.

    z' = p (z - u) for each pole p. For u = s^m exp(-r s) it has the particular solution Q(s) exp(-r s) with
    Q' - (p + r) Q = -p s^m; the homogeneous solution Z exp(p s) continues z from piece to piece.
    """
    total, free = given.terms * filter_.direct, []
    for pole, gain in zip(filter_.poles.tolist(), filter_.gains.tolist(), strict=True):
        particular = _particular(pole, given)
        weight = gain if pole.imag == 0 else 2 * gain
        free.append((pole, weight * _homogeneous(pole, particular, level)))
        total = total + (particular.terms * weight).real
    output = ExponentialSum(given.decays, total).values()
    for piece, where, since in given.decays.pieces.groups:
        for pole, amplitude in free:
            output[where] += _oscillation(pole, complex(amplitude[piece]), since)
    return output


def _oscillation(pole: complex, amplitude: complex, since: Real) -> Real:
    """Return the real part of amplitude exp(pole s)."""
    decay = np.exp(pole.real * since)
    if pole.imag == 0:
        return np.asarray(amplitude.real * decay)
    angle = pole.imag * since
    return np.asarray(decay * (amplitude.real * np.cos(angle) - amplitude.imag * np.sin(angle)))


def _particular(pole: complex, given: ExponentialSum) -> ExponentialSum:
    """Return the particular solution of z' = p (z - u) that has the exponentials of u."""
    rates, found = given.decays.rates, given.terms * pole
    apart = pole + rates[: found.shape[-2], None] + rates
    found[-1] /= apart
    for power in reversed(range(len(found) - 1)):
        found[power] = (found[power] + (power + 1) * found[power + 1]) / apart
    return ExponentialSum(given.decays, found)


def _homogeneous(pole: complex, particular: ExponentialSum, level: float) -> Complex:
    """Return the amplitude of exp(p s) in each piece, shape (pieces,)."""
    begins, ends = particular.terms[0].sum(axis=(1, 2)), particular.at_ends()
    decay = np.exp(pole * particular.decays.pieces.part.lengths)
    found = np.empty(len(begins), complex)
    state = complex(level)
    for piece, begin in enumerate(begins.tolist()):
        found[piece] = state - begin
        if piece < len(ends):
            state = found[piece] * decay[piece] + ends[piece]
    return found


MOST_PIECES: Final = 64
"""Largest number of pieces of the drive for which the closed form is used."""
MOST_MODES: Final = 16
"""Largest number of modes for which the closed form of the square of a field is used."""
FORCE: Final = "electrostatic_force"
LINEAR: Final = frozenset({"current", "stack_voltage", "effective_voltage"})
SKIN: Final = frozenset({"skin_displacement", "skin_speed"})
READING: Final = "lateral_force_measured"
FILTERED: Final = SKIN | {"lateral_force", READING}
OFFERED: Final = LINEAR | FILTERED | {FORCE}
"""Signals that may have a closed form."""
_MECHANICAL: Final = frozenset({"friction", "finger", "rig"})
"""Parts of a scenario on which no electrical quantity depends."""
_KEPT: Final = 3
"""Number of electrical responses that are kept: a search returns to the point at which it computed derivatives."""


class Repeated:
    """Signals over time at fixed output times, as a function of the free parameters of a scenario.

    `names` are signals over time, `time` (n,) [s] increasing output times, `band` those over whose band materials are
    reduced, by default the output times; `last` is a scenario that was evaluated before, and may share parts.

    The closed form differs from `Expanded.at` by less than 1e-9 of the largest value in electrical signals, and by the stated
    error of the mechanics, at most 1e-6, in those behind a sensor or a skin. Electrical responses of the last few points are
    kept, so that another friction, finger or rig needs none of them again.
    """

    def __init__(
        self,
        prepared: ParametricScenario,
        names: Sequence[str],
        time: Real,
        *,
        band: Real | None = None,
        last: Expanded | None = None,
    ) -> None:
        self._prepared, self.time, self.last = prepared, time, last
        self._asked, self._band = (tuple(names), band), time if band is None else band
        self._names = tuple(name for name in names if name != "capacitance")
        self._has_capacitance = len(self._names) < len(names)
        if self._has_capacitance and sine_of(prepared.base) is None:
            raise InputError(without("capacitance", ()))
        self._electrical = tuple(path for path in prepared.free if path.split(".")[0] not in _MECHANICAL)
        self._kept: OrderedDict[tuple[float, ...], tuple[Expanded, ClosedElectrics | None]] = OrderedDict()
        self._pieces: tuple[Drive, Pieces] | None = None
        self._filters: dict[str, tuple[tuple[Any, ...], Filter]] = {}

    def is_for(self, names: Sequence[str], time: Real, band: Real | None) -> bool:
        """Tell whether these signals at these times are computed."""
        same = self._asked[0] == tuple(names) and self._asked[1] is band
        return same and np.array_equal(self.time, time)

    def signals(self, values: Mapping[str, float]) -> dict[str, Real]:
        """Compute the signals."""
        scenario = self._prepared.scenario(values)
        own = capacitance(scenario, self.time) if self._has_capacitance else {}
        read = {name: row for name, (_, row) in own.items()}
        return read if not self._names else self._solved(scenario, values) | read

    def _solved(self, scenario: Scenario, values: Mapping[str, float]) -> dict[str, Real]:
        """Compute the signals that follow from the response to the drive."""
        expanded, closed = self._electrics(scenario, values)
        found = None if closed is None else closed.signals(scenario, self._names, find=self._filter_of)
        if found is not None:
            return found
        if expanded.scenario is not scenario:
            expanded = Expanded(scenario, self._band, before=expanded)
        record = expanded.at(self.time, wanted=self._names)
        missing = [name for name in self._names if name not in record.signals]
        if missing:
            raise InputError(without(missing[0], record.signals))
        return {name: np.asarray(record.signals[name][1]) for name in self._names}

    def _filter_of(self, scenario: Scenario, name: str) -> Filter:
        """Return the filter of a signal, the last one where nothing that it depends on has changed."""
        parts = (scenario.friction, scenario.finger, scenario.rig, scenario.motion)
        kept = self._filters.get(name)
        if kept is None or any(one is not other for one, other in zip(kept[0], parts, strict=True)):
            kept = self._filters[name] = (parts, filter_of(scenario, name))
        return kept[1]

    def _electrics(
        self, scenario: Scenario, values: Mapping[str, float]
    ) -> tuple[Expanded, ClosedElectrics | None]:
        """Return modes and, where it exists, the closed form of a point; those kept where they depend on the same values."""
        point = self._prepared.begin | dict(values)
        key = tuple(point[path] for path in self._electrical)
        if key in self._kept:
            self._kept.move_to_end(key)
            return self._kept[key]
        self.last = expanded = Expanded(scenario, self._band, before=self.last)
        closed = None
        few = scenario.drive.count_corners(float(self.time[-1])) <= MOST_PIECES
        if few and offers(scenario, self._names):
            if self._pieces is None or self._pieces[0] is not scenario.drive:
                self._pieces = scenario.drive, Pieces.of(scenario.drive, self.time)
            closed = ClosedElectrics.of(scenario, expanded.section, self._pieces[1], self._names)
        self._kept[key] = expanded, closed
        if len(self._kept) > _KEPT:
            self._kept.popitem(last=False)
        return expanded, closed


def offers(scenario: Scenario, names: Collection[str]) -> bool:
    """Tell whether signals of a scenario have a closed form, as far as its models and its drive decide."""
    if not OFFERED.issuperset(names) or scenario.circuit.amplifier is not None or scenario.time.settled:
        return False
    parts = scenario.drive.parts()
    if len(parts) != 1 or not isinstance(parts[0], Linear) or not chosen(scenario).method.each_alone:
        return False
    mechanical = FILTERED.intersection(names)
    if (scenario.finger is None and mechanical & SKIN) or (scenario.rig is None and READING in mechanical):
        return False
    return not mechanical or _is_linear_behind_force(scenario)


def _is_linear_behind_force(scenario: Scenario) -> bool:
    """Tell whether friction, finger and sensors are linear filters of the attraction under a constant load."""
    friction, motion = scenario.friction, scenario.motion
    return (
        not friction.deflects
        and motion.distance is None
        and friction.without_memory().is_linear
        and scenario.force.of_second_degree
        and not scenario.contact.grows
        and scenario.load.time_profile.is_constant
        and not memory_changes(scenario)
        and not resting(motion)
        and (scenario.rig is None or scenario.rig.digitiser is None)
        and getattr(scenario.finger, "growth", None) is None
    )


def filter_of(scenario: Scenario, name: str) -> Filter:
    """Return the filter from the steady friction to a signal behind it."""
    memory = friction_filter(scenario)
    if name == "lateral_force":
        return memory
    if name == READING:
        assert scenario.rig is not None
        own = of_stages(scenario.rig.lateral_stages())
    else:
        assert scenario.finger is not None
        own = finger_filters(scenario.finger)[name]
    return cascade(memory, own) if len(memory.poles) else own


@dataclass(eq=False)
class ClosedElectrics:
    """The electrical quantities of one scenario in closed form, from which its signals are evaluated.

    `sums` are amplitudes of the force law, and the quantities asked for.
    """

    scenario: Scenario
    sums: dict[Any, ExponentialSum]
    _force: ExponentialSum | None = field(default=None, init=False)
    _rows: dict[str, Real] = field(default_factory=dict, init=False)

    @classmethod
    def of(
        cls, scenario: Scenario, section: ModalSection, pieces: Pieces, names: Collection[str]
    ) -> ClosedElectrics | None:
        """Compute the quantities that some signals need, or return None where they have no closed form."""
        wanted: dict[Any, Transfer] = {} if LINEAR.issuperset(names) else amplitudes(scenario, section)
        if plain := LINEAR.intersection(names):
            known = linear_quantities(scenario, section)
            if not plain <= known.keys():
                return None
            wanted |= {name: known[name] for name in plain}
        rates = active_rates(list(wanted.values()), end=float(pieces.times[-1]))
        if rates is None or len(rates) > MOST_MODES:
            return None
        found = linear_sums([*wanted.values()], Decays.of(pieces, rates))
        return cls(scenario, dict(zip(wanted, found, strict=True)))

    def signals(
        self,
        scenario: Scenario,
        names: Collection[str],
        *,
        find: Callable[[Scenario, str], Filter] = filter_of,
    ) -> dict[str, Real] | None:
        """Evaluate signals of a scenario with the same electrics; None where a filter has no closed form for them."""
        if scenario is not self.scenario and memory_changes(scenario) and FILTERED.intersection(names):
            return None
        found: dict[str, Real] = {}
        for name in names:
            row = (
                self._filtered(scenario, find(scenario, name)) if name in FILTERED else self._electrical(name)
            )
            if row is None:
                return None
            found[name] = row
        return found

    def _electrical(self, name: str) -> Real:
        """Return an electrical signal, which is kept."""
        if name not in self._rows:
            if name == FORCE:
                fields = {key: each.values() for key, each in amplitudes_among(self.sums).items()}
                row = attraction(self.scenario, total_pull(self.scenario, fields), self._pieces.times)
            else:
                row = self.sums[name].values()
            self._rows[name] = row
        return self._rows[name]

    @property
    def _pieces(self) -> Pieces:
        return next(iter(self.sums.values())).decays.pieces

    def _filtered(self, scenario: Scenario, filter_: Filter) -> Real | None:
        """Return a signal behind the steady friction, which is a linear function of the attraction."""
        law = scenario.friction.without_memory()
        normal = np.full(2, scenario.load.normal_force)
        start, unit = law.lateral_force(normal, np.array([0.0, 1.0]), np.full(2, np.nan)).tolist()
        if not len(filter_.poles):
            return np.asarray(filter_.direct * (self._electrical(FORCE) * (unit - start) + start))
        if self._force is None:
            self._force = self._quadratic()
        if not has_closed_form(filter_, self._force.decays.rates):
            return None
        return filtered_sum(filter_, (self._force * (unit - start)).shifted(start), start)

    def _quadratic(self) -> ExponentialSum:
        """Return the attraction on a constant area [N], a quadratic form of the amplitudes."""
        scenario = self.scenario
        sums, area = amplitudes_among(self.sums), scenario.contact.gross_area()

        def pull(*ones: str) -> float:
            return float(total_pull(scenario, {name: np.array(float(name in ones)) for name in sums}))

        terms = [(name, name, pull(name)) for name in sums]
        terms += [(a, b, pull(a, b) - pull(a) - pull(b)) for a, b in combinations(sums, 2)]
        found = [product(sums[a], sums[b]) * (weight * area) for a, b, weight in terms if weight]
        return reduce(add, found)
