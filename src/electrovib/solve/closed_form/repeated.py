"""Signals of a scenario for many values of a few parameters at the same output times, as a fit needs them.

Linear layers under a drive of few straight pieces, with a law of second degree and linear friction and sensors behind it, are
evaluated in closed form; all others as by `Expanded.at`.
"""

from __future__ import annotations

from collections import OrderedDict
from dataclasses import dataclass, field
from functools import reduce
from itertools import combinations
from operator import add
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.signals import without
from electrovib.physics.drive.parts import Linear
from electrovib.solve.choice import chosen
from electrovib.solve.closed_form.sums import (
    Decays,
    ExponentialSum,
    Pieces,
    active_rates,
    filtered_sum,
    has_closed_form,
    linear_sums,
    product,
)
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

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.mechanics.filters import Filter
    from electrovib.solve.one_by_one import ParametricScenario
    from electrovib.solve.stack.section import ModalSection
    from electrovib.solve.stack.transfer import Transfer

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
