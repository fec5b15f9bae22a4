"""Response over time of linear layers, exact for piecewise linear drives and sines at any output times.

They are driven by a voltage or a current, from rest or in the periodic state, behind an amplifier without limits or without
one. Gain and pole of an amplifier are a filter before the stack.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.physics.drive.parts import Chirped, Linear, Part, Smooth, Tones, cosine_and_sine, even_step
from electrovib.solve.electrics.fading import by_output, fading, over_modes
from electrovib.solve.electrics.formulas import chirp_response, smooth_states
from electrovib.solve.electrics.solution import (
    CURRENT_DRIVE,
    PERIODIC,
    STRETCH,
    TRANSIENT,
    Along,
    Solution,
    name_interface,
)
from electrovib.solve.electrics.straight import SharedModes
from electrovib.solve.recursion.blocks import PRODUCT
from electrovib.solve.recursion.uneven import FORGOTTEN
from electrovib.solve.stack.expand import Surroundings
from electrovib.solve.stack.harmonics import count_harmonics, refuse_unrepeated, settled_integral
from electrovib.solve.stack.modes import blocked, stacked
from electrovib.solve.stack.transfer import (
    INTEGRATING,
    Transfer,
    integral_weight,
    row_of,
    without_integrators,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping, Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.amplifier import Amplifier
    from electrovib.physics.circuit import SeriesElement
    from electrovib.physics.drive.base import Drive
    from electrovib.scenario import Scenario
    from electrovib.solve.electrics.fading import Rows
    from electrovib.solve.electrics.solution import Method, Question
    from electrovib.solve.electrics.straight import InStretches
    from electrovib.solve.stack.keys import Key

SAME_RATE: Final = 1e-8
"""Relative distance below which two rates count as equal, and are moved apart by twice as much."""
K = TypeVar("K")
ALONE: Final = 8000
"""Number of times from which cases are computed one after the other, so that a record of one stays in the cache."""
_MANY: Final = 10_000
"""Number of times from which it saves work to find outputs that are multiples of others."""
_SAME: Final = 4 * float(np.finfo(float).eps)


def transient(
    transfers: Mapping[K, Transfer], drive: Drive, time: Real, *, settled: bool = False
) -> dict[K, Real]:
    """Compute the response of linear quantities to a drive, each (n,) or (cases, n).

    `time` (n,) [s].

    x' = rate (v - x) for each mode; y = direct v + slope v' + sum gain x + sum free exp(-rate t). Where the
    response at zero frequency is known separately, y = static v + slope v' + sum gain (x - v) + ...: a small current
    is then not the difference of two large ones. From rest an integrator is exact as one more slow mode; in the
    periodic state its charge is counted from its own mean, because the drive does not determine a constant charge.
    """
    if not settled:
        return Response(transfers, drive.parts()).at(time)
    refuse_unrepeated(drive)
    integral = settled_integral(drive, time) if is_integrating(transfers) else None
    return settled_response(transfers, drive.parts(), time, integral)


def is_integrating(transfers: Mapping[Any, Transfer]) -> bool:
    """Return whether a linear quantity integrates the drive."""
    return any(np.any(integral_weight(each)) for each in transfers.values())


def settled_response(
    transfers: Mapping[K, Transfer], parts: Sequence[Part], time: Real, integral: Real | None
) -> dict[K, Real]:
    """Compute the response of linear quantities in the periodic state.

    `integral` (n,) is that of the drive over time, without its mean, where a quantity integrates it [V s].
    """
    if integral is None:
        return Response(transfers, parts, settled=True).at(time)
    relaxing = {name: without_integrators(transfer) for name, transfer in transfers.items()}
    rest = Response(relaxing, parts, settled=True).at(time)
    return {name: row + integral_weight(transfers[name]) * integral for name, row in rest.items()}


class Response:
    """Response of linear quantities to a sum of parts, without integrators in the periodic state.

    The states of all modes at the breaks of straight pieces are computed once, for evaluation at any times.
    """

    def __init__(
        self, transfers: Mapping[Any, Transfer], parts: Sequence[Part], *, settled: bool = False
    ) -> None:
        self.parts, self.settled = parts, settled
        self.slopes = {name: each.slope for name, each in transfers.items() if np.any(each.slope)}
        self.groups: list[tuple[list[Any], Real, Real, SharedModes]] = []
        together: dict[Any, list[Any]] = {}  # quantities with the same modes, which are computed once
        for name, transfer in transfers.items():
            together.setdefault((transfer.rates.shape, transfer.rates.tobytes()), []).append(name)
        for names in together.values():
            group = [transfers[name] for name in names]
            rates = group[0].rates
            lag = np.array([each.static is not None for each in group])
            levels = [each.direct if each.static is None else each.static for each in group]
            direct = stacked([row_of(level) for level in levels])[..., 0]
            gains, free = stacked([each.gains for each in group]), stacked([each.free for each in group])
            active = np.any(gains != 0, axis=tuple(range(gains.ndim - 1))) & ~blocked(rates)
            left = (
                np.where(rates[..., None, :] == 0, free, 0.0) if settled else free
            )  # settled: trapped charge
            self.groups.append(
                (names, rates, left, SharedModes(rates[..., active], gains[..., active], direct, lag))
            )

    def at(self, time: Real) -> dict[Any, Real]:
        """Compute the response at increasing times (n,) [s]."""
        return self.along(time)(slice(0, len(time)))

    def along(self, time: Real) -> Callable[[slice], dict[Any, Real]]:
        """Return the response at increasing times (n,) [s] as a function of stretches of them, one after the other.

        The arrays of a stretch hold no more than its times, so that all that is made of them is made in the cache.
        """
        driven = [
            self._driven_once(modes, time)
            if len(time) >= _MANY and not modes.cases
            else self._driven(modes, time)
            for *_, modes in self.groups
        ]
        now = np.zeros(len(time) if self.slopes else 0)
        if self.slopes:
            now = sum((part.slope(time) for part in self.parts), now)

        def through(stretch: slice) -> dict[Any, Real]:
            result: dict[Any, Real] = {}
            for (names, rates, left, _), rows_of in zip(self.groups, driven, strict=True):
                rows = rows_of(stretch)
                if np.any(left):
                    more = fading(left, rates, time[stretch], late=float(time[-1]))
                    rows = [row + each for row, each in zip(rows, more, strict=True)]
                result |= zip(names, rows, strict=True)
            for name, slope in self.slopes.items():
                result[name] = result[name] + slope * now[stretch]
            return result

        return through

    def _driven_once(self, modes: SharedModes, time: Real) -> InStretches:
        """Return the response to all parts; an output that is a multiple of another, D = eps0 eps E, is not computed."""
        rows = np.column_stack([modes.direct, modes.gains])
        top = rows[np.arange(len(rows)), np.argmax(np.abs(rows), axis=1)]
        top = np.where(top, top, 1.0)
        unit = rows / top[:, None]
        same = np.all(np.abs(unit[:, None] - unit) <= _SAME * np.abs(unit), axis=2)
        first = np.argmax(same & (modes.lag[:, None] == modes.lag), axis=1)
        own = np.unique(first)
        alone = replace(modes, gains=modes.gains[own], direct=modes.direct[own], lag=modes.lag[own])
        driven, factors = self._driven(alone, time), (top / top[first]).tolist()

        def through(stretch: slice) -> list[Real]:
            found = dict(zip(own.tolist(), driven(stretch), strict=True))
            pairs = zip(first.tolist(), factors, strict=True)
            return [found[among] if factor == 1 else found[among] * factor for among, factor in pairs]

        return through

    def _driven(self, modes: SharedModes, time: Real) -> InStretches:
        """Return the response to all parts [V] in stretches of the times."""
        driven = [_of_part(modes, part, time, settled=self.settled) for part in self.parts]

        def through(stretch: slice) -> Rows:
            found = [each(stretch) for each in driven]
            if len(found) == 1:
                return found[0]
            nothing = np.zeros(len(time[stretch]))
            return [sum((rows[place] for rows in found), nothing) for place in range(len(modes.lag))]

        return through


def how_it_begins(drive: Drive, *, settled: bool) -> str:
    """Return in words from which state a response begins, and for which drives it is exact."""
    count = count_harmonics(drive) if settled else None
    how = f"exact (harmonics of the drive: {count})" if count else "exact for straight pieces and sines"
    return f"from {'the periodic state' if settled else 'rest'}, {how}"


def _of_part(modes: SharedModes, part: Part, time: Real, *, settled: bool) -> InStretches:
    """Return the response to one part [V] in stretches of the times."""
    if not modes.rates.shape[-1] or (settled and part.is_step):  # a constant to which the modes have settled
        value = part.value(time)
        return lambda stretch: by_output(modes.follows[..., None] * value[stretch])
    is_formula = not isinstance(part, Linear | Tones)
    if modes.cases and (is_formula or len(time) >= ALONE):
        return modes.in_groups(1, lambda one: _of_part(one, part, time, settled=settled))
    match part:
        case Tones():
            return lambda stretch: _tones(part, modes, time[stretch], settled=settled)
        case Linear():
            return modes.along(part, time, None if settled else np.zeros(modes.rates.shape))
    whole = _formula(modes, part, time)
    return lambda stretch: whole[:, stretch]


def _formula(modes: SharedModes, part: Smooth, time: Real) -> Real:
    """Return the response to a formula [V]."""
    rates, gains, direct = modes.rates, modes.gains, modes.direct
    now, chirp = part.value(time), part if isinstance(part, Chirped) else None
    found = np.outer(direct, now)
    states = smooth_states(part, rates, time) if chirp is None else now
    for lag in {*modes.lag.tolist()}:
        some = modes.lag == lag
        if chirp is None:
            found[some] += gains[some] @ (states - now if lag else states)
        else:
            found[some] += chirp_response(chirp, rates, gains[some], time, lag=lag)
    return found


def _tones(part: Tones, modes: SharedModes, time: Real, *, settled: bool) -> Rows:
    """Return the steady state of each tone, minus its modes' value at the switching times, which decays from there."""
    angular = 2j * np.pi * part.frequencies
    response = np.asarray(
        modes.rates[..., None] / (modes.rates[..., None] + angular), complex
    )  # of mode to tone
    lagging = -angular / (modes.rates[..., None] + angular)
    modal = np.where(modes.lag[:, None], over_modes(modes.gains, lagging), over_modes(modes.gains, response))
    steady = (modes.direct[..., None] + modal) * part.amplitudes
    start = part.start if settled and np.isinf(part.start) else max(part.start, 0.0)
    on = slice(*np.searchsorted(time, [start, part.stop]))
    begin, end = (
        modes.gains * (response @ (part.amplitudes * np.exp(angular * switched))).real[..., None, :]
        if np.isfinite(switched)
        else np.zeros_like(modes.gains)
        for switched in (start, part.stop)
    )
    if not modes.cases and on == slice(0, len(time)) and (step := even_step(time)) is not None:
        since = start if np.isfinite(start) else 0.0
        return _in_products(part.frequencies, steady, -begin, modes.rates, time, step=step, since=since)
    found = [np.zeros((*modes.cases, len(time))) for _ in modes.lag]
    waves = [wave for frequency in part.frequencies.tolist() for wave in cosine_and_sine(frequency, time[on])]
    shares = np.stack([steady.real, -steady.imag], axis=-1).reshape(*steady.shape[:-1], -1)
    length = max(1, PRODUCT // max(1, shares.shape[-2] * shares.shape[-1]))
    for first in range(on.start, on.stop, length):
        some = slice(first, min(first + length, on.stop))
        seen = [wave[some.start - on.start : some.stop - on.start] for wave in waves]
        for row, each in zip(found, by_output(over_modes(shares, np.stack(seen))), strict=True):
            row[..., some] = each
    for switched, then in ((start, -begin), (part.stop, end)):
        if np.isfinite(switched):
            first = int(np.searchsorted(time, switched))
            fades = fading(then, modes.rates, time[first:] - switched, late=float(time[-1]))
            for row, left in zip(found, fades, strict=True):
                row[..., first:] += left
    return found


def _in_products(
    frequencies: Real, steady: Complex, then: Real, rates: Real, time: Real, *, step: float, since: float
) -> list[Real]:
    """Return tones and what fades since a time, at even times: products of those at a few times and within a step of them."""
    width = math.isqrt(len(time))
    begins, inside = time[::width], step * np.arange(width)
    left = rates * (begins[0] - since) < FORGOTTEN
    then, rates = then[:, left], rates[left]
    early = 2 * np.pi * np.outer(frequencies, begins)
    late = np.exp(2j * np.pi * np.outer(frequencies, inside))
    columns = np.concatenate([np.cos(early), -np.sin(early), np.exp(-np.outer(rates, begins - since))]).T
    fades, found = np.exp(-np.outer(rates, inside)), []
    for tones, faded in zip(steady, then, strict=True):
        turned = tones[:, None] * late
        both = np.concatenate([turned.real, turned.imag, faded[:, None] * fades])
        height, row = max(1, PRODUCT // both.size), np.empty((len(begins), width))
        for first in range(0, len(begins), height):
            np.matmul(columns[first : first + height], both, out=row[first : first + height])
        found.append(row.ravel()[: len(time)])
    return found


def answer_linear(question: Question) -> Solution:
    """Compute the response of linear layers to a voltage, behind an amplifier without limits if there is one, or to a current."""
    scenario, transfers = question.scenario, question.wanted(question.section)
    amplifier = scenario.circuit.amplifier
    return linear_response(
        transfers, scenario.drive, question.times, amplifier=amplifier, settled=question.settled
    )


def linear_response(
    transfers: Mapping[Any, Transfer],
    drive: Drive,
    time: Real,
    *,
    amplifier: Amplifier | None = None,
    settled: bool = False,
) -> Solution:
    """Compute the response of quantities that are linear in a current, or in the voltage of the plate; `time` (n,) [s]."""
    if amplifier is not None:
        transfers = amplified(transfers, amplifier)
    method, reason = _how_linear(drive, amplifier=amplifier, settled=settled)
    return Solution(found=transient(transfers, drive, time, settled=settled), method=method, reason=reason)


def _how_linear(drive: Drive, *, amplifier: Amplifier | None, settled: bool) -> tuple[Method, str]:
    """Return the method of linear layers, and the reason for it."""
    method, how = (
        PERIODIC if settled else TRANSIENT,
        "linear layers, fixed gap and a voltage drive: real modes",
    )
    if amplifier is not None:
        how = "linear layers behind an amplifier without limits: its gain and pole are a filter before the stack,"
    elif drive.quantity == "current":
        method, what = CURRENT_DRIVE, "modes of each layer, blocking layers integrate the current"
        how = f"linear layers, fixed gap and a current drive: {what},"
    return method, f"{how} {how_it_begins(drive, settled=settled)}"


def along_linear(question: Question) -> Along | None:
    """Return the response of linear layers to a voltage in stretches; None if it has integrators in the periodic state."""
    scenario, transfers, settled = question.scenario, question.wanted(question.section), question.settled
    drive, amplifier, times = scenario.drive, scenario.circuit.amplifier, question.times
    if settled:
        refuse_unrepeated(drive)
    if amplifier is not None:
        transfers = amplified(transfers, amplifier)
    if settled and is_integrating(transfers):
        return None
    method, reason = _how_linear(drive, amplifier=amplifier, settled=settled)
    response, voltage = Response(transfers, drive.parts(), settled=settled), drive.voltage(times)
    rows_of = response.along(times)

    def through(stretch: slice) -> Solution:
        found = rows_of(stretch) | {"drive_voltage": voltage[stretch]}
        name_interface(scenario, found)
        return Solution(found=found, method=method, reason=reason)

    def at(moments: Real) -> dict[Key, Real]:
        found = response.at(moments) | {"drive_voltage": drive.voltage(moments)}
        name_interface(scenario, found)
        return found

    return Along(through, at, STRETCH, {"drive_voltage": voltage})


def of_drive(question: Question, found: dict[Key, Real]) -> dict[Key, Real]:
    """Return the voltage of the drive, and under a prescribed current the current as well."""
    scenario, times = question.scenario, question.times
    drive = scenario.drive
    if drive.quantity == "voltage":
        return {"drive_voltage": drive.voltage(times)}
    around = Surroundings.of(scenario)
    charges = sum(layer.initial_charge for layer in scenario.stack.layers.values())
    voltage = drive_voltage(
        found["stack_voltage"],
        drive,
        times,
        element=around.element,
        second=around.second,
        settled=question.settled,
        charge=around.element.charge + around.area * charges,
    )
    return {"drive_current": drive.voltage(times), "drive_voltage": voltage}


def refuse_gaps_of_a_law(scenario: Scenario, leak: str | None = None) -> None:
    """Refuse a law with gaps of its own where the voltage over linear layers is not prescribed."""
    law, current = type(scenario.force), scenario.drive.quantity == "current"
    if getattr(law, "replaces", ()) and (current or leak):
        why = f"their response to the leak of '{leak}' is not modelled"
        if current:
            why = "under a prescribed current they would change the voltage"
        raise InputError(
            f"force = {law.__name__}: its gaps are no layers of the stack, and {why}. Give the stack a layer 'gap' and"
            " use force.model = MaxwellStressInGap"
        )


def refuse_current(scenario: Scenario) -> None:
    """Refuse parts of a scenario that cannot be combined with a prescribed current."""
    refuse_gaps_of_a_law(scenario)
    refuse_behind_amplifier(scenario)


def drive_voltage(
    stack_voltage: Real,
    drive: Drive,
    time: Real,
    *,
    element: SeriesElement,
    second: float,
    settled: bool,
    charge: float = 0.0,
) -> Real:
    """Compute the voltage that the amplifier has to supply for its current.

    `stack_voltage` (n,) [V], `time` (n,) [s]; returns `voltage` (n,) [V].
    """
    rates, gains, free = np.zeros(0), np.zeros(0), np.zeros(0)
    if element.elastance > 0:
        rates = np.array([element.rate or INTEGRATING, element.rate])
        gains = np.array([element.elastance / rates[0], 0.0])
        free = np.array([0.0, element.elastance * charge])
    around = {"voltage": Transfer(rates=rates, gains=gains, direct=element.resistance, slope=0.0, free=free)}
    return stack_voltage * (1 + second) + transient(around, drive, time, settled=settled)["voltage"]


def caveat() -> Diagnostic:
    """Return the diagnostic that the contact area and stray currents of a prescribed current are not known."""
    text = (
        "the whole current of the drive is assumed to cross this contact area, so the force is proportional to 1/area; a"
        " current through stray capacitance or beside the gap does not attract, and its share is not known here"
    )
    return Diagnostic("current drive", "unknown", text)


def refuse_behind_amplifier(scenario: Scenario) -> None:
    """Refuse a drive or an initial state that cannot be combined with the amplifier before linear layers."""
    amplifier, drive = scenario.circuit.amplifier, scenario.drive
    if amplifier is None:
        return
    if drive.quantity == "current":
        raise InputError(
            f"circuit.amplifier: {type(drive).__name__} prescribes the current itself; omit the amplifier"
        )
    if scenario.time.settled and amplifier.is_limited:
        raise InputError(
            "time.initial_state = PeriodicState: behind an amplifier with limits the periodic state is not known"
            " beforehand. Start AtRest and evaluate a late period, or omit its limits"
        )


def amplified(transfers: Mapping[Any, Transfer], amplifier: Amplifier) -> dict[Any, Transfer]:
    """Return quantities per volt of the drive from those per volt of the plate, with those of the plate itself."""
    plate = Transfer(rates=np.zeros(0), gains=np.zeros(0), direct=1.0)
    own = {"plate_voltage": plate, "amplifier_current": transfers["current"] + _stray(amplifier)}
    return {name: _behind(transfer, amplifier) for name, transfer in (dict(transfers) | own).items()}


def _stray(amplifier: Amplifier) -> Transfer:
    """Return the current into the stray capacitance per volt of the plate [A/V]."""
    return Transfer(rates=np.zeros(0), gains=np.zeros(0), slope=amplifier.stray_capacitance, static=0.0)


def moved_corner(amplifier: Amplifier, rates: Real) -> float | None:
    """Return the angular corner frequency of an amplifier [rad/s], moved away from rates [1/s] that almost equal it."""
    if amplifier.bandwidth is None:
        return None
    corner = 2 * np.pi * amplifier.bandwidth
    return corner * (1 + 2 * SAME_RATE) if np.any(np.abs(rates - corner) < SAME_RATE * corner) else corner


def _behind(transfer: Transfer, amplifier: Amplifier) -> Transfer:
    """Multiply a linear quantity of the plate's voltage by gain and pole of an amplifier, by partial fractions."""
    gain, corner = amplifier.gain, moved_corner(amplifier, transfer.rates)
    if corner is None:
        return replace(transfer * gain, free=transfer.free)
    apart = corner - transfer.rates
    direct = transfer.direct if transfer.static is None else transfer.static - float(np.sum(transfer.gains))
    own = direct - transfer.slope * corner - float(np.sum(transfer.gains * transfer.rates / apart))
    return Transfer(
        rates=np.append(transfer.rates, corner),
        gains=gain * np.append(transfer.gains * corner / apart, own),
        direct=gain * transfer.slope * corner,
        free=np.append(transfer.free, 0.0),
        static=None if transfer.static is None else gain * transfer.static,
    )
