"""What happens during a pulse, in sentences that are made from its numbers: one that holds is said, no other."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.view.units import pretty_quantity

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
"""Part of the time that is shown below which a stretch has no sentence."""
_SAME: Final = 0.05
"""Relative change up to which the force, or a voltage, stays as it is."""
_FEW: Final = 0.05
"""Part of the largest charge on the plate below which a charge between layers is not mentioned."""
_LITTLE, _NEARLY_ALL = 0.2, 0.9
"""Parts of the charge on the plate."""
_BEGUN, _DONE = 0.1, 0.95
"""Parts of a change of the force after which it has begun, and is over."""


@dataclass(frozen=True, kw_only=True)
class VoltageStretch:
    """Samples from `first` to `last` in which the voltage is of one kind."""

    kind: str
    first: int
    last: int


def stretches(time: Real, drive: Real) -> list[VoltageStretch]:
    """Divide the time into stretches in which the voltage is none, is held, or goes away from or back to 0."""
    largest, whole = float(np.abs(drive).max()), time[-1] - time[0]
    if largest == 0:
        return [VoltageStretch(kind=NONE, first=0, last=len(time) - 1)]
    size = np.abs(drive) / largest
    slope = np.diff(size) / np.diff(time) * whole
    kinds = np.where(slope > 0, 2, 3)
    kinds[np.abs(slope) < _STEADY] = 1
    kinds[np.maximum(size[1:], size[:-1]) < _ZERO] = 0
    labels = kinds + 10 * np.sign(drive[1:] + drive[:-1]) * (kinds > 0)
    edges = [0, *(np.flatnonzero(np.diff(labels)) + 1), len(labels)]
    return [
        VoltageStretch(kind=(NONE, HELD, UP, DOWN)[kinds[first]], first=int(first), last=int(last))
        for first, last in itertools.pairwise(edges)
        if time[last] - time[first] >= _SHORT * whole
    ]


def sentences(pulse: Pulse) -> list[tuple[int, str]]:
    """Return the first sample of each part of a pulse and what happens in it; the first of them begins at 0."""
    teller = _Teller(pulse)
    told = [each for stretch in stretches(pulse.time, pulse.drive) for each in teller.tell(stretch)]
    return [(0 if place == 0 else start, words) for place, (start, words) in enumerate(told)]


def answer(pulse: Pulse) -> str:
    """Answer why the force fades, or state that it does not, in one or two sentences."""
    teller = _Teller(pulse)
    held = [each for each in stretches(pulse.time, pulse.drive) if each.kind == HELD]
    if not held:
        return teller.answer_without_hold()
    longest = max(held, key=lambda each: pulse.time[each.last] - pulse.time[each.first])
    return teller.answer_of(longest)


class _Teller:
    """Says what the numbers of one pulse show."""

    def __init__(self, pulse: Pulse) -> None:
        self._pulse, self._charges = pulse, pulse.charges
        self._peak = float(np.abs(pulse.force).max())
        self._plate = float(np.abs(self._charges[0]).max())
        inner = np.abs(self._charges[1:-1]).max(axis=1)
        self._between = int(inner.argmax()) + 1 if inner.size and inner.max() >= _FEW * self._plate else None

    # what each kind of stretch tells

    def tell(self, stretch: VoltageStretch) -> Iterator[tuple[int, str]]:
        """Give the sentences of a stretch, each with its first sample."""
        first, last = stretch.first, stretch.last
        if stretch.kind == UP:
            yield first, self._away(first, last)
        elif stretch.kind == DOWN:
            yield first, self._back(first, last)
        else:
            yield from self._unmoved(stretch)

    def _away(self, first: int, last: int) -> str:
        words = (
            f"The voltage goes from {self._drive(first)} to {self._drive(last)}: charge flows onto the plate"
        )
        return f"{words}{self._charged(first, last)}"

    def _charged(self, first: int, last: int) -> str:
        """Say where the charge goes while the plate is charged, and what the force does."""
        tissue = -self._charges[-1] * np.sign(self._charges[0, last])
        is_taken = tissue[last] > tissue[first] and tissue[last] > 0
        words = (
            f"{', the opposite charge into the finger' if is_taken else ''}, and {self._course(first, last)}."
        )
        passed = self._passing(first, last)
        if not passed:
            return words
        if self._is_gathering(first, last):
            return f"{words} Part of it passes on {passed}: {self._share(last)} in the end."
        return f"{words} Charge passes {self._through(first, last)} and cancels that which was left {self._place}."

    def _back(self, first: int, last: int) -> str:
        words = f"The voltage goes back from {self._drive(first)} to {self._drive(last)}, and the plate gives its charge back"
        k, course = self._pulse.followed, self._course(first, last)
        is_felt = self._is_left(last) and self._pulse.force[last] > _FEW * self._peak
        if k is None or not is_felt or self._pulse.voltages[k, last] * self._pulse.drive[first] >= 0:
            return f"{words}; {course}."
        return (
            f"{words}, but the charge {self._place} cannot leave as fast. The voltage across the {self._pulse.layers[k]} turns"
            f" round, to {self._volts(k, last)}: {course}."
        )

    def _is_left(self, at: int) -> bool:
        """Return whether there is more charge between the layers than on the plate."""
        return self._between is not None and bool(
            abs(self._charges[self._between, at]) > max(abs(self._charges[0, at]), _FEW * self._plate)
        )

    def _unmoved(self, stretch: VoltageStretch) -> Iterator[tuple[int, str]]:
        """Divide a stretch of constant voltage by how far the force has gone from its first to its last value."""
        first, last, force = self._settled_from(stretch), stretch.last, self._pulse.force
        if first > stretch.first:
            yield (
                stretch.first,
                f"The voltage is {self._drive(first)}: charge flows onto the plate{self._charged(stretch.first, first)}",
            )
        if not self._is_force(first, last):
            yield first, f"{self._voltage(stretch)}, and there is hardly any force."
            return
        if self._is_same(force[first], force[last]):
            yield first, self._constant(stretch, first)
            return
        progress = (force[first : last + 1] - force[first]) / (force[last] - force[first])
        begun, done = (first + int(np.argmax(progress >= part)) for part in (_BEGUN, _DONE))
        is_over = self._takes(done, last) and bool(np.all(progress[done - first :] >= _DONE))
        at_first = self._reached(first) if stretch.kind == HELD else self._left(first)
        if at_first and self._takes(first, begun, 0.5 * _SHORT):
            yield first, at_first
            first = begun
        yield first, self._changing(stretch, first, done if is_over else last)
        if is_over:
            yield done, self._over(stretch, last)

    def _settled_from(self, stretch: VoltageStretch) -> int:
        """Return the sample at which the force has followed a step of the voltage, if it soon does."""
        if self._pulse.is_moving:
            return stretch.first
        force = self._pulse.force[stretch.first : stretch.last + 1]
        at = stretch.first + int(np.argmax(force >= _DONE * force.max()))
        return at if not self._takes(stretch.first, at, _STEADY) else stretch.first

    def _voltage(self, stretch: VoltageStretch) -> str:
        if stretch.kind == NONE:
            return "There is no voltage"
        return f"The voltage stays at {self._drive(stretch.last)}"

    def _constant(self, stretch: VoltageStretch, first: int) -> str:
        last, k = stretch.last, self._pulse.followed
        words = f"{self._voltage(stretch)}, and the force stays at {self._newtons(last)}"
        if k is not None and self._is_same(*np.abs(self._pulse.voltages[k, [first, last]])):
            words += f": the {self._pulse.layers[k]} keeps its voltage, {self._volts(k, last)}"
        passed = self._passing(first, last)
        return f"{words}. Charge passes {passed}, without an effect on the force." if passed else f"{words}."

    def _reached(self, at: int) -> str:
        """Say how the layers share a voltage that has just been reached."""
        words = f"The voltage has just reached {self._drive(at)}"
        if self._peak - self._pulse.force[at] < 0.02 * self._peak:
            words += f", and the force is at its largest, {self._newtons(at)}"
        most = np.abs(self._charges[1:-1, at]).max(initial=0.0)
        if most < _FEW * abs(self._charges[0, at]):
            layers = range(len(self._pulse.layers))
            shared = ", ".join(f"{self._pulse.layers[each]} {self._volts(each, at)}" for each in layers)
            return f"{words}. Hardly any charge has passed a layer, so they share the voltage as capacitors: {shared}."
        if self._is_opposite(at):
            return f"{words}. The charge {self._place} is already {self._share(at)}."
        if self._between is not None and abs(self._charges[self._between, at]) > _FEW * self._plate:
            return f"{words}. The charge {self._place} has the sign of that on the plate, and adds to it while it lasts."
        return f"{words}."

    def _left(self, at: int) -> str:
        """Say what attracts when the voltage has just gone."""
        if self._between is None or abs(self._charges[self._between, at]) < _FEW * self._plate:
            return ""
        return (
            f"The voltage has returned to 0, but the charge {self._place} is still there, and attracts with"
            f" {self._newtons(at)}."
        )

    def _changing(self, stretch: VoltageStretch, first: int, last: int) -> str:
        """Say what moves the force while the voltage does not change."""
        k, course = self._pulse.followed, self._course(first, last)
        passed = self._leaving(first, last) if stretch.kind == NONE else self._passing(first, last)
        if not passed or self._pulse.is_moving:
            return f"{self._voltage(stretch)}, and {course}{' while the gap changes' if self._pulse.is_moving else ''}."
        moved = f"but charge {'leaks off' if stretch.kind == NONE else 'passes'} {passed}"
        if k is None:
            return f"{self._voltage(stretch)}, {moved}, and {course}."
        across = f"the voltage across the {self._pulse.layers[k]} goes from {self._volts(k, first)} to {self._volts(k, last)}"
        return f"{self._voltage(stretch)}, {moved}: {across}, and {course}."

    def _over(self, stretch: VoltageStretch, last: int) -> str:
        force, k, between = self._pulse.force[last], self._pulse.followed, self._between
        part = f"{self._newtons(last)}, {_percent(force / self._peak)} of its largest value"
        if force < 0.01 * self._peak:
            part = "less than 1 % of its largest value"
        elif force > 0.995 * self._peak:
            part = f"{self._newtons(last)}, its largest value"
        words = f"{self._voltage(stretch)}, and the force is now {part}"
        if between is None or k is None:
            return f"{words}."
        if stretch.kind == NONE:
            is_left = abs(self._charges[between, last]) > _FEW * self._plate
            return (
                f"{words}: {'part' if is_left else 'hardly any'} of the charge {self._place} is still there."
            )
        if self._is_opposite(last) and k >= between and self._part(last) > _NEARLY_ALL:
            words += f": the field of the plate ends on the charge {self._place}, before the {self._pulse.layers[k]}"
        return f"{words}."

    # the answer

    def answer_of(self, held: VoltageStretch) -> str:
        """Answer for the longest time in which a voltage is held."""
        force, first, last = self._pulse.force, self._settled_from(held), held.last
        if not self._is_force(first, last):
            return f"There is hardly any force while the voltage stays at {self._drive(last)}."
        if self._is_same(force[first], force[last]):
            return f"The force does not fade. {self._constant(held, first)}"
        if force[last] > force[first]:
            return f"The force does not fade. {self._changing(held, first, last)}"
        words = self._changing(held, first, last)
        if force[last] > 0.5 * force[first]:
            return words
        half = first + int(np.argmax(force[first : last + 1] <= 0.5 * force[first]))
        near = slice(half, half - 2, -1)
        when = np.interp(0.5 * force[first], force[near], self._pulse.time[near]) - self._pulse.time[first]
        return f"{words} Half of it is gone after {pretty_quantity(float(when), 's', digits=3)}."

    def answer_without_hold(self) -> str:
        """Answer for a voltage that changes at all times."""
        at = int(np.argmax(np.abs(self._charges[0])))
        if self._between is None:
            return "The voltage never stays, and hardly any charge passes a layer before it turns: the force does not fade."
        most = f"when the plate holds most charge, the charge {self._place} is {self._share(at)}"
        force = f"and the force is {self._newtons(at)}"
        if not self._is_opposite(at):
            return f"The voltage never stays: {most}, {force}."
        if self._part(at) < _LITTLE:
            return f"The voltage turns before much charge can gather: {most}, {force}."
        most += " and weakens the field beyond it"
        return f"Between the turns of the voltage there is time for charge to gather: {most}, {force}."

    # pieces of sentences

    def _course(self, first: int, last: int) -> str:
        """Say how the force goes."""
        force = self._pulse.force[first : last + 1]
        if not self._is_force(first, last):
            return "there is hardly any force"
        start, end, high, low = force[0], force[-1], float(force.max()), float(force.min())
        if self._is_same(high, low):
            return f"the force stays at {self._newtons(last)}"
        if self._is_same(end, high) and start <= low + _SAME * high:
            return f"the force grows from {self._newtons(first)} to {self._newtons(last)}"
        if self._is_same(start, high) and end <= low + _SAME * high:
            return f"the force falls from {self._newtons(first)} to {self._newtons(last)}"
        if high > (1 + _SAME) * max(start, end):
            return f"the force rises up to {self._newtons(first + int(force.argmax()))} and then falls to {self._newtons(last)}"
        return f"the force falls to {self._newtons(first + int(force.argmin()))} and then rises to {self._newtons(last)}"

    @property
    def _place(self) -> str:
        assert self._between is not None
        names = self._pulse.layers
        return f"between {names[self._between - 1]} and {names[self._between]}"

    def _passing(self, first: int, last: int) -> str:
        """Say through which layers charge passes, and where it gathers; empty where little passes, or it cannot be told."""
        if self._between is None or abs(self._gained(first, last)) < _FEW * self._plate:
            return ""
        through = self._through(first, last)
        return through and f"{through} and gathers {self._place}"

    def _leaving(self, first: int, last: int) -> str:
        """Say through which layers the charge between layers leaves; empty where little of it does."""
        if self._between is None or -self._gained(first, last) * np.sign(
            self._charges[self._between, first]
        ) < (_FEW * abs(self._charges[self._between, first])):
            return ""
        return self._through(first, last)

    def _through(self, first: int, last: int) -> str:
        """Say through which layers most charge comes to an interface or leaves it; empty where it cannot be told."""
        assert self._between is not None
        ranges = (range(self._between, len(self._pulse.layers)), range(self._between - 1, -1, -1))
        sides = [self._conducting(each, first, last) for each in ranges]
        open_sides = [each for each in sides if each[0]]
        if not open_sides or (len(open_sides) > 1 and np.isnan([flow for _, flow in open_sides]).any()):
            return ""
        names, _ = max(open_sides, key=lambda each: each[1])
        return f"through the {' and the '.join(reversed(names))}"

    def _conducting(self, places: range, first: int, last: int) -> tuple[list[str], float]:
        """Return the layers through which charge can reach an interface from one side, the next first, and how much does."""
        names: list[str] = []
        for each in places:
            if self._pulse.conductivity[each] == 0:
                break
            names.append(self._pulse.layers[each])
        inside = slice(first, last + 1)
        flow = self._pulse.conductivity[places[0]] * np.trapezoid(
            self._pulse.fields[places[0], inside], self._pulse.time[inside]
        )
        return names, abs(float(flow))

    def _gained(self, first: int, last: int) -> float:
        """Return the charge that the interface with most charge gains [C/m2]."""
        return float(self._charges[self._between, last] - self._charges[self._between, first])

    def _is_gathering(self, first: int, last: int) -> bool:
        """Return whether the charge between layers grows, to one opposite to that on the plate."""
        before, after = self._charges[self._between, [first, last]]
        return self._is_opposite(last) and bool(abs(after) > abs(before))

    def _is_opposite(self, at: int) -> bool:
        """Return whether the charge between the layers has the other sign than that on the plate, which is not small."""
        plate = self._charges[0, at]
        return bool(
            self._between is not None
            and abs(plate) > _FEW * self._plate
            and plate * self._charges[self._between, at] < 0
        )

    def _part(self, at: int) -> float:
        return float(abs(self._charges[self._between, at] / self._charges[0, at]))

    def _share(self, at: int) -> str:
        return f"{_percent(self._part(at))} of that on the plate"

    def _is_same(self, one: float, other: float) -> bool:
        return bool(abs(one - other) <= _SAME * max(abs(one), abs(other)))

    def _is_force(self, first: int, last: int) -> bool:
        return bool(np.abs(self._pulse.force[first : last + 1]).max() > _ZERO * self._peak)

    def _takes(self, first: int, last: int, part: float = _SHORT) -> bool:
        time = self._pulse.time
        return bool(time[last] - time[first] >= part * (time[-1] - time[0]))

    def _drive(self, at: int) -> str:
        return _quantity(self._pulse.drive[at], np.abs(self._pulse.drive).max(), "V")

    def _volts(self, layer: int, at: int) -> str:
        row = self._pulse.voltages[layer]
        return _quantity(row[at], np.abs(row).max(), "V")

    def _newtons(self, at: int) -> str:
        return _quantity(self._pulse.force[at], self._peak, "N")


def _quantity(value: float, largest: float, unit: str) -> str:
    """Write a value with three digits; one that is nothing beside the largest as 0."""
    if abs(value) <= _ZERO * largest:
        return f"0 {unit}" if abs(value) <= 1e-9 * largest else f"nearly 0 {unit}"
    return pretty_quantity(float(value), unit, digits=3).replace("-", "\N{MINUS SIGN}")


def _percent(part: float) -> str:
    return f"{100 * part:.{0 if abs(part) >= 0.1 else 1}f} %".replace("-", "\N{MINUS SIGN}")
