"""What happens during a pulse, in sentences that are made from its numbers: one that holds is said, no other."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np

from electrovib.view.style import pretty_quantity

if TYPE_CHECKING:
    from electrovib.apps.explorer.fading import Pulse
    from electrovib.core.arrays import Real

NONE, HELD, UP, DOWN = "no voltage", "held", "up", "down"
"""Kinds of a stretch of time, by the magnitude of the voltage."""
_ZERO: Final = 1e-3
"""Part of the largest voltage, or force, up to which it counts as none."""
_STEADY: Final = 0.05
"""Part of its largest value by which a voltage that is held would change during all that is shown."""
_SHORT: Final = 0.02
"""Part of the time that is shown below which a stretch has no sentence, unless the voltage changes much in it."""
_MUCH: Final = 0.3
"""Part of its largest value that a voltage changes in a short rise or fall that is told."""
_SAME: Final = 0.05
"""Relative change up to which the force, or a voltage, stays as it is."""
_FEW: Final = 0.05
"""Part of the largest charge on the plate below which a charge between layers is not mentioned; of itself, its change."""
_LITTLE, _NEARLY_ALL = 0.2, 0.9
"""Parts of the charge on the plate which, between layers, are little or nearly as much."""
_BEGUN, _DONE = 0.1, 0.95
"""Parts of a change of the force after which it has begun, and is over."""


class VoltageStretch(NamedTuple):
    """Samples from `first` to `last` in which the voltage is of one kind."""

    kind: str
    first: int
    last: int


def stretches(time: Real, drive: Real) -> list[VoltageStretch]:
    """Divide the time into stretches in which the voltage is none, is held, or goes away from or back to 0."""
    whole, size = time[-1] - time[0], np.abs(drive) / (np.abs(drive).max() or 1.0)
    slope = np.diff(size) / np.diff(time) * whole
    kinds = np.where(slope > 0, 2, 3)
    kinds[np.abs(slope) < _STEADY] = 1
    kinds[np.maximum(size[1:], size[:-1]) < _ZERO] = 0
    labels = kinds + 10 * np.sign(drive[1:] + drive[:-1]) * (kinds > 0)
    edges = [0, *(np.flatnonzero(np.diff(labels)) + 1).tolist(), len(labels)]
    return [
        VoltageStretch((NONE, HELD, UP, DOWN)[kinds[first]], first, last)
        for first, last in itertools.pairwise(edges)
        if time[last] - time[first] >= _SHORT * whole or abs(size[last] - size[first]) > _MUCH
    ]


def sentences(pulse: Pulse) -> list[tuple[int, str]]:
    """Return the first sample of each part of a pulse, of which the first is 0, and what happens in it."""
    teller = _Teller(pulse)
    spoken = [each for stretch in stretches(pulse.time, pulse.drive) for each in teller.tell(stretch)]
    return [(start if place else 0, words) for place, (start, words) in enumerate(spoken)]


def answer(pulse: Pulse) -> str:
    """Answer why the force fades, or state that it does not, in one or two sentences."""
    teller = _Teller(pulse)
    held = [each for each in stretches(pulse.time, pulse.drive) if each.kind == HELD]
    if not held:
        return teller.answer_without_hold()
    return teller.answer_of(max(held, key=lambda each: pulse.time[each.last] - pulse.time[each.first]))


class _Teller:
    """Says what the numbers of one pulse show."""

    def __init__(self, pulse: Pulse) -> None:
        self._pulse, self._force, charges = pulse, pulse.force, pulse.charges
        self._plate, self._tissue, inner = charges[0], charges[-1], charges[1:-1]
        self._peak, self._most = float(np.abs(pulse.force).max()), float(np.abs(self._plate).max())
        self._inner = np.abs(inner).max(axis=0, initial=0.0)
        at = int(np.abs(inner).max(axis=1).argmax()) if len(inner) else 0
        self._between = inner[at] if len(inner) else np.zeros_like(self._plate)  # where most charge gathers
        self._above = at + 1
        self._place = f"between {pulse.layers[at]} and {pulse.layers[at + 1]}" if len(inner) else ""
        self._follower = "" if pulse.followed is None else pulse.layers[pulse.followed]
        self._across = pulse.voltages[pulse.followed or 0]

    def tell(self, stretch: VoltageStretch) -> Iterator[tuple[int, str]]:
        """Give the sentences of a stretch, each with its first sample."""
        kind, first, last = stretch
        if kind == UP:
            moves = f"The voltage goes from {self._drive(first)} to {self._drive(last)}"
            yield first, f"{moves}: charge flows onto the plate{self._charged(first, last)}"
        elif kind == DOWN:
            yield first, self._back(first, last)
        else:
            yield from self._unmoved(stretch)

    def _charged(self, first: int, last: int) -> str:
        """Say where the charge goes while the plate is charged, and what the force does."""
        tissue = -self._tissue[[first, last]] * np.sign(self._plate[last])
        opposite = ", the opposite charge into the finger" if tissue[1] > max(tissue[0], 0.0) else ""
        words, passing = f"{opposite}, and {self._course(first, last)}.", self._passing(first, last)
        share = f": {self._share(last)} in the end" if self._is_opposite(last) else ""
        return f"{words} Charge {passing}{share}." if passing else words

    def _back(self, first: int, last: int) -> str:
        """Say what happens while the voltage goes back to 0: charge between the layers can stay behind, and attract."""
        words = f"The voltage goes back from {self._drive(first)} to {self._drive(last)}, and the plate gives its charge back"
        is_behind = abs(self._between[last]) > max(abs(self._plate[last]), _FEW * self._most)
        is_turned = self._follower and self._across[last] * self._pulse.drive[first] < 0
        if not (is_behind and is_turned and self._force[last] > _FEW * self._peak):
            return f"{words}; {self._course(first, last)}."
        turned = f"The voltage across the {self._follower} turns round, to {self._volts(last)}"
        return f"{words}, but the charge {self._place} cannot leave as fast. {turned}: {self._course(first, last)}."

    def _unmoved(self, stretch: VoltageStretch) -> Iterator[tuple[int, str]]:
        """Divide a stretch of constant voltage by how far the force has gone from its first to its last value."""
        first, last, force = self._settled_from(stretch), stretch.last, self._force
        if first > stretch.first:
            begin = f"The voltage is {self._drive(first)}: charge flows onto the plate"
            yield stretch.first, begin + self._charged(stretch.first, first)
        if self._is_same(first, last):
            yield first, self._constant(first, last)
            return
        if abs(force[last] - force[first]) <= _ZERO * self._peak:
            yield first, self._changing(first, last)
            return
        progress = (force[first : last + 1] - force[first]) / (force[last] - force[first])
        begun, done = (first + int(np.argmax(progress >= part)) for part in (_BEGUN, _DONE))
        is_over = self._takes(done, last, _SHORT) and bool(np.all(progress[done - first :] >= _DONE))
        if self._takes(first, begun, _SHORT / 2):
            yield first, self._reached(first) if stretch.kind == HELD else self._left(first)
            first = begun
        yield first, self._changing(first, done if is_over else last)
        if is_over:
            yield done, self._over(last)

    def _settled_from(self, stretch: VoltageStretch) -> int:
        """Return the sample at which the force has followed a step of the voltage, if it soon does."""
        force = self._force[stretch.first : stretch.last + 1]
        at = stretch.first + int(np.argmax(force >= _DONE * force.max()))
        is_late = self._takes(stretch.first, at, _STEADY) or self._pulse.is_moving
        return stretch.first if is_late else at

    def _voltage(self, at: int) -> str:
        return f"The voltage stays at {self._drive(at)}" if self._pulse.drive[at] else "There is no voltage"

    def _constant(self, first: int, last: int) -> str:
        """Say that the force does not change, and which voltage keeps it."""
        if not self._is_force(first, last):
            return f"{self._voltage(last)}, and there is hardly any force."
        words = f"{self._voltage(last)}, and the force stays at {self._newtons(last)}"
        if self._follower and not self._pulse.is_moving:
            words += f": the {self._follower} keeps its voltage, {self._volts(last)}"
        passing = self._passing(first, last)
        return f"{words}. Charge {passing}, without an effect on the force." if passing else f"{words}."

    def _reached(self, at: int) -> str:
        """Say how the layers share a voltage that has just been reached."""
        words = f"The voltage has just reached {self._drive(at)}"
        if self._peak - self._force[at] < 0.02 * self._peak:
            words += f", and the force is at its largest, {self._newtons(at)}"
        if self._inner[at] < _FEW * abs(self._plate[at]):
            across = zip(self._pulse.layers, self._pulse.voltages, strict=True)
            shared = ", ".join(f"{name} {_quantity(row, at, 'V')}" for name, row in across)
            return f"{words}. Hardly any charge has passed a layer, so they share the voltage as capacitors: {shared}."
        if self._is_opposite(at):
            return f"{words}. The charge {self._place} is already {self._share(at)}."
        if self._between[at] * self._plate[at] <= 0:
            return f"{words}."
        return f"{words}. The charge {self._place} has the sign of that on the plate, and adds to it while it lasts."

    def _left(self, at: int) -> str:
        """Say what attracts when the voltage has just gone."""
        words, attracts = "The voltage has returned to 0", f"attracts with {self._newtons(at)}"
        if abs(self._between[at]) < _FEW * self._most:
            return f"{words}, and the force is {self._newtons(at)}."
        return f"{words}, but the charge {self._place} is still there, and {attracts}."

    def _changing(self, first: int, last: int) -> str:
        """Say what moves the force while the voltage does not change."""
        course, passing = self._course(first, last), self._passing(first, last)
        if self._pulse.is_moving:
            return f"{self._voltage(last)}, and {course} while the gap changes."
        if not passing:
            return f"{self._voltage(last)}, and {course}."
        ends = f"goes from {self._volts(first)} to {self._volts(last)}"
        across = f": the voltage across the {self._follower} {ends}" if self._follower else ""
        return f"{self._voltage(last)}, but charge {passing}{across}, and {course}."

    def _over(self, last: int) -> str:
        """Say what the force has become, and why it stays so."""
        part = self._force[last] / self._peak
        size = "less than 1 % of" if part < 0.01 else f"{self._newtons(last)}, {_percent(part)} of"
        words = f"{self._voltage(last)}, and the force is now {size} its largest value"
        is_behind = self._pulse.followed is not None and self._pulse.followed >= self._above
        if self._is_opposite(last) and is_behind and self._part(last) > _NEARLY_ALL:
            words += f": the field of the plate ends on the charge {self._place}, before the {self._follower}"
        return f"{words}."

    def answer_of(self, held: VoltageStretch) -> str:
        """Answer for the longest time in which a voltage is held."""
        force, first, last = self._force, self._settled_from(held), held.last
        if self._is_same(first, last):
            return f"The force does not fade. {self._constant(first, last)}"
        words = self._changing(first, last)
        if force[last] > force[first]:
            return f"The force does not fade. {words}"
        if force[last] > 0.5 * force[first]:
            return words
        half = first + int(np.argmax(force[first : last + 1] <= 0.5 * force[first]))
        near = slice(half, half - 2 if half > 1 else None, -1)
        when = np.interp(0.5 * force[first], force[near], self._pulse.time[near]) - self._pulse.time[first]
        return f"{words} Half of it is gone after {pretty_quantity(float(when), 's', digits=3)}."

    def answer_without_hold(self) -> str:
        """Answer for a voltage that changes at all times."""
        if np.abs(self._between).max() < _FEW * self._most:
            return "The voltage never stays, and hardly any charge passes a layer before it turns: the force does not fade."
        at = int(np.argmax(np.abs(self._plate)))
        most = f"when the plate holds most charge, the charge {self._place} is {self._share(at)}"
        begin = "The voltage never stays"
        if self._part(at) < _LITTLE and self._force[at] >= (1 - _SAME) * self._peak:
            begin = "The force does not fade before the voltage turns"
        if self._part(at) > _LITTLE:
            begin = "Between the turns of the voltage there is time for charge to gather"
        return f"{begin}: {most}, and the force is {self._newtons(at)}."

    # pieces of sentences

    def _course(self, first: int, last: int) -> str:
        """Say how the force goes."""
        force = self._force[first : last + 1]
        if not self._is_force(first, last):
            return "there is hardly any force"
        highest, lowest = first + int(force.argmax()), first + int(force.argmin())
        high, low, slack = float(force.max()), float(force.min()), _SAME * float(np.abs(force).max())
        if high - low <= slack:
            return f"the force stays at {self._newtons(last)}"
        if force[-1] >= high - slack and force[0] <= low + slack:
            return f"the force grows from {self._newtons(first)} to {self._newtons(last)}"
        if force[0] >= high - slack and force[-1] <= low + slack:
            return f"the force falls from {self._newtons(first)} to {self._newtons(last)}"
        if high > max(force[0], force[-1]) + slack:
            return f"the force rises up to {self._newtons(highest)} and then falls to {self._newtons(last)}"
        return f"the force falls to {self._newtons(lowest)} and then rises to {self._newtons(last)}"

    def _passing(self, first: int, last: int) -> str:
        """Say through which layers charge passes, and what it does there; empty where little passes, or it cannot be told."""
        before, after = abs(self._between[first]), abs(self._between[last])
        gained, through = abs(self._between[last] - self._between[first]), self._through(first, last)
        if not through or gained < _FEW * max(before, after, _LITTLE * self._most):
            return ""
        is_turned = self._between[first] * self._between[last] < 0
        if is_turned and min(before, after) > _BEGUN * max(before, after):
            replaced = f"replaces that which was left {self._place} by charge of the other sign"
            return f"passes {through} and {replaced}"
        if after >= before:
            return f"passes {through} and gathers {self._place}"
        if not self._pulse.drive[last]:
            return f"leaks off {through}"
        return f"passes {through} and cancels part of that which was left {self._place}"

    def _through(self, first: int, last: int) -> str:
        """Name the layers through which charge comes to an interface or leaves it; empty where it cannot be told."""
        if not self._place:
            return ""
        pulse, passed = self._pulse, np.diff(self._pulse.time[first : last + 1])
        found = []
        for side in (range(self._above, len(pulse.layers)), range(self._above - 1, -1, -1)):
            names = [pulse.layers[k] for k in itertools.takewhile(lambda k: pulse.conductivity[k] != 0, side)]
            flow = pulse.conductivity[side[0]] * abs(float(pulse.fields[side[0], first:last] @ passed))
            if names:
                found.append((flow, names))
        if not found or (len(found) > 1 and any(math.isnan(flow) for flow, _ in found)):
            return ""
        return f"through the {' and the '.join(reversed(max(found)[1]))}"

    def _is_opposite(self, at: int) -> bool:
        """Return whether charge between the layers has the other sign than that on the plate, and neither is small."""
        few = _FEW * self._most
        is_there = min(abs(self._plate[at]), abs(self._between[at])) > few
        return bool(is_there and self._plate[at] * self._between[at] < 0)

    def _part(self, at: int) -> float:
        return float(abs(self._between[at] / self._plate[at]))

    def _share(self, at: int) -> str:
        return f"{_percent(self._part(at))} of that on the plate"

    def _is_same(self, first: int, last: int) -> bool:
        """Return whether the force stays as it is, or there is none."""
        force = self._force[first : last + 1]
        return not self._is_force(first, last) or bool(np.ptp(force) <= _SAME * np.abs(force).max())

    def _is_force(self, first: int, last: int) -> bool:
        return bool(np.abs(self._force[first : last + 1]).max() > _ZERO * self._peak)

    def _takes(self, first: int, last: int, part: float) -> bool:
        time = self._pulse.time
        return bool(time[last] - time[first] >= part * (time[-1] - time[0]))

    def _drive(self, at: int) -> str:
        return _quantity(self._pulse.drive, at, "V")

    def _volts(self, at: int) -> str:
        return _quantity(self._across, at, "V") if self._follower else ""

    def _newtons(self, at: int) -> str:
        return _quantity(self._force, at, "N")


def _quantity(values: Real, at: int, unit: str) -> str:
    """Write one of some values with three digits; one that is nothing beside the largest as 0."""
    value, largest = float(values[at]), float(np.abs(values).max())
    if abs(value) <= _ZERO * largest:
        return f"0 {unit}" if abs(value) <= 1e-9 * largest else f"nearly 0 {unit}"
    return pretty_quantity(value, unit, digits=3).replace("-", "\N{MINUS SIGN}")


def _percent(part: float) -> str:
    return f"{100 * part:.{0 if part >= 0.1 else 1}f} %".replace("-", "\N{MINUS SIGN}")
