"""Electrics, friction and sensors of a scenario in closed form: which scenarios have one, and its signals."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.physics.drive.pieces import Linear
from electrovib.solve.choice import chosen
from electrovib.solve.closed_form.sums import (
    Decays,
    Pieces,
    active_rates,
    filtered_sum,
    has_closed_form,
    linear_sums,
    product,
)
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.solution import amplitudes, linear_quantities
from electrovib.solve.mechanics.filters import cascade, of_stages
from electrovib.solve.mechanics.lateral import friction_filter, memory_changes, resting
from electrovib.solve.mechanics.rig import finger_filters
from electrovib.solve.stack.keys import amplitudes_among

if TYPE_CHECKING:
    from collections.abc import Callable, Collection

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.closed_form.sums import ExponentialSum
    from electrovib.solve.mechanics.filters import Filter
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


def offers(scenario: Scenario, names: Collection[str]) -> bool:
    """Tell whether signals of a scenario have a closed form, as far as its models and its drive decide."""
    if not OFFERED.issuperset(names) or scenario.circuit.amplifier is not None:
        return False
    parts = scenario.drive.parts()
    if len(parts) != 1 or not isinstance(parts[0], Linear) or scenario.time.settled:
        return False
    if not chosen(scenario).method.each_alone:
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

    Parameters
    ----------
    scenario : Scenario
        Experiment for which `offers` is true; other scenarios with the same electrics may be passed to `signals`.
    sums : dict of Key to ExponentialSum
        Amplitudes of the force law, and the quantities asked for.
    """

    scenario: Scenario
    sums: dict[Any, ExponentialSum]
    _force: ExponentialSum | None = field(default=None, init=False)
    _rows: dict[str, Real] = field(default_factory=dict, init=False)

    @classmethod
    def of(
        cls,
        scenario: Scenario,
        section: ModalSection,
        times: Real,
        names: Collection[str],
        *,
        before: ClosedElectrics | None = None,
    ) -> ClosedElectrics | None:
        """Compute the quantities that some signals need, or return None where they have no closed form.

        `times` (n,) [s].
        """
        part, end = scenario.drive.parts()[0], float(times[-1])
        if not isinstance(part, Linear) or part.count_breaks(end) > MOST_PIECES:
            return None
        wanted = _wanted(scenario, section, names)
        if wanted is None:
            return None
        rates = active_rates(list(wanted.values()), end=end)
        if rates is None or len(rates) > MOST_MODES:
            return None
        same = before is not None and before.scenario.drive is scenario.drive
        pieces = before.pieces if same and before is not None else Pieces.of(part, times)
        found = linear_sums([*wanted.values()], Decays.of(pieces, rates))
        return cls(scenario, dict(zip(wanted, found, strict=True)))

    @property
    def pieces(self) -> Pieces:
        """Pieces of the drive, with the output times."""
        return next(iter(self.sums.values())).decays.pieces

    def signals(
        self,
        scenario: Scenario,
        times: Real,
        names: Collection[str],
        *,
        find: Callable[[Scenario, str], Filter] = filter_of,
    ) -> dict[str, Real] | None:
        """Evaluate signals, or return None where a filter has no closed form for these electrics.

        `times` (n,) [s].
        """
        found: dict[str, Real] = {}
        if scenario is not self.scenario and memory_changes(scenario) and FILTERED.intersection(names):
            return None
        for name in names:
            if name not in FILTERED:
                found[name] = self._row(name, times)
                continue
            row = self._filtered(scenario, find(scenario, name), times)
            if row is None:
                return None
            found[name] = row
        return found

    def _row(self, name: str, times: Real) -> Real:
        """Return an electrical signal, which is kept."""
        if name in self._rows:
            return self._rows[name]
        if name == FORCE:
            fields = {name: each.values() for name, each in amplitudes_among(self.sums).items()}
            row = attraction(self.scenario, total_pull(self.scenario, fields), times)
        else:
            row = self.sums[name].values()
        self._rows[name] = row
        return row

    def _filtered(self, scenario: Scenario, filter_: Filter, times: Real) -> Real | None:
        """Return a signal behind the steady friction, which is a linear function of the attraction."""
        law = scenario.friction.without_memory()
        normal = np.full(2, scenario.load.normal_force)
        start, unit = law.lateral_force(normal, np.array([0.0, 1.0]), np.full(2, np.nan)).tolist()
        if not len(filter_.poles):
            return np.asarray(filter_.direct * (self._row(FORCE, times) * (unit - start) + start))
        force = self._attraction()
        if not has_closed_form(filter_, force.decays.rates):
            return None
        return filtered_sum(filter_, (force * (unit - start)).shifted(start), start)

    def _attraction(self) -> ExponentialSum:
        """Return the attraction on a constant area [N], a quadratic form of the amplitudes."""
        if self._force is None:
            self._force = self._quadratic()
        return self._force

    def _quadratic(self) -> ExponentialSum:
        scenario = self.scenario
        sums, area = amplitudes_among(self.sums), scenario.contact.gross_area()

        def pull(*ones: str) -> float:
            return float(total_pull(scenario, {name: np.array(float(name in ones)) for name in sums}))

        total: ExponentialSum | None = None
        terms = [(name, name, pull(name)) for name in sums]
        terms += [(a, b, pull(a, b) - pull(a) - pull(b)) for a, b in combinations(sums, 2)]
        for one, other, weight in terms:
            if weight:
                more = product(sums[one], sums[other]) * (weight * area)
                total = more if total is None else total + more
        assert total is not None
        return total


def _wanted(scenario: Scenario, section: ModalSection, names: Collection[str]) -> dict[Any, Transfer] | None:
    """Return the linear quantities that some signals need; None where one of them does not exist."""
    found: dict[Any, Transfer] = {}
    if not LINEAR.issuperset(names):
        found = amplitudes(scenario, section)
    if plain := LINEAR.intersection(names):
        known = linear_quantities(scenario, section)
        if not plain <= known.keys():
            return None
        found = found | {name: known[name] for name in plain}
    return found
