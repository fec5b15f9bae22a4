"""Signals of fingers in arrays over fingers: what arrays cover, modes of all, responses to their drive, force, friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.tables import derived_at
from electrovib.physics.stack import INTERFACE
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.over_frequency import OVER_FREQUENCY, loudest_tone, of_one_sine
from electrovib.solve.electrics.solution import linear_quantities
from electrovib.solve.electrics.straight import periodic_state
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.mechanics.mechanical import under_force
from electrovib.solve.population.drive import PiecewiseDrive, first_order_hold_many
from electrovib.solve.rough_contact.solved import contact_of_each
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf, amplitudes_among
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError, Transfer, integral_weight, without_integrators

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.drive.parts import Linear
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

K = TypeVar("K")
LAYERED: Final[dict[str, type[FieldOf | DisplacementOf]]] = {"field": FieldOf, "displacement": DisplacementOf}
OF_FIELDS: Final = frozenset({*LAYERED, "interface_field", "stack_voltage", "current"})
"""Signals of the stack that are linear in the drive."""
OF_LAW: Final = frozenset({"electrostatic_force", "lateral_force", "effective_voltage"})
"""Signals that depend on the force law."""
OVER_TIME: Final = OF_FIELDS | OF_LAW | {"drive_voltage", "normal_force", "sliding_speed"}
"""Signals over time that are computed in arrays."""
_COLUMNS: Final = ("stack.", "circuit.", "contact.area", "drive.", "force.", "friction.", "load.normal_force")
"""Beginnings of the paths that may be columns."""


def refuse_beyond_arrays(scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...]) -> None:
    """Refuse scenarios, signals and parameters that arrays do not cover."""
    if foreign := [name for name in names if name not in OVER_TIME | OVER_FREQUENCY]:
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
    if "lateral_force" in names and scenario.friction.has_memory:
        raise NotInArraysError(f"{type(scenario.friction).__name__} has a memory")
    if "lateral_force" in names and scenario.finger is not None and resting(scenario.motion):
        raise NotInArraysError("the skin holds a friction while the finger rests")


def _refuse_columns(scenario: Scenario, free: tuple[str, ...]) -> None:
    """Refuse parameters whose values cannot be a column."""
    if scenario.moisture is not None:
        raise NotInArraysError("moisture sets other parameters of each finger")
    if path := contact_of_each(scenario, free):
        raise NotInArraysError(f"{path} changes the rough contact, which is solved for each finger")
    for path in free:
        if derived_at(scenario, path) is not None and not path.startswith("drive."):
            raise NotInArraysError(f"{path} is derived from other parameters")
        if not path.startswith(_COLUMNS):
            raise NotInArraysError(
                f"{path} is no number of the layers, the circuit, the drive, the law, the area, the load or the friction"
            )


def has_modes(scenario: Scenario, names: tuple[str, ...]) -> bool:
    """Return whether signals follow from the modes of the stack."""
    return bool((OF_FIELDS | OF_LAW if scenario.force.causal else OF_FIELDS) & {*names})


def asked_of(member: Scenario, section: ModalSection, names: tuple[str, ...]) -> dict[Key, Transfer]:
    """Return the linear quantities of fingers that signals need."""
    known = linear_quantities(member, section)
    wanted = {
        key
        for name in names
        if name in OF_FIELDS or name == "effective_voltage"
        for key in _keys(member, name)
    }
    if not member.force.causal:
        wanted.discard("effective_voltage")
    elif {"electrostatic_force", "lateral_force"} & {*names}:
        wanted |= {key for key in known if isinstance(key, AmplitudeOf)}
    if missing := [str(key) for key in wanted if key not in known]:
        raise NotInArraysError(f"the scenario has no {missing[0]}")
    return {key: each for key, each in known.items() if key in wanted}


def _keys(member: Scenario, name: str) -> list[Key]:
    """Return the keys of the linear quantities of a signal."""
    if name in LAYERED:
        return [LAYERED[name](layer) for layer in member.stack.layers]
    return [FieldOf(member.stack.gap_name or INTERFACE) if name == "interface_field" else name]


def responses(
    asked: Mapping[Key, Transfer], driven: list[tuple[slice, list[tuple[Any, PiecewiseDrive]]]]
) -> dict[Key, Real]:
    """Return the linear quantities of fingers over time; `driven` as in `over_time`."""
    each = [respond(some_of(asked, some), terms) for some, terms in driven]
    return {key: _below([row[key] for row in each]) for key in asked}


def over_time(
    member: Scenario,
    known: Mapping[Key, Real],
    driven: list[tuple[slice, list[tuple[Any, PiecewiseDrive]]]],
    names: tuple[str, ...],
) -> dict[str, Any]:
    """Return signals over time of fingers from their linear quantities.

    `driven` are factors and drives, whose sum is the drive of a range of them.
    """
    time = driven[0][1][0][1].timing.outputs
    rows: dict[Any, Any] = dict(known)
    if not member.force.causal:
        rows |= _of_one_sine(member, driven[0][1])
    found: dict[str, Any] = {}
    amplitudes = amplitudes_among(rows)
    force: Any = attraction(member, total_pull(member, amplitudes), time) if amplitudes else None
    for name in names:
        if name == "electrostatic_force":
            found[name] = force
        elif name == "lateral_force":
            found[name] = _friction(member, time, force)
        elif name == "drive_voltage":
            own = [total_of(factor * drive.values() for factor, drive in terms) for _, terms in driven]
            found[name] = _below([np.atleast_2d(row) for row in own])
        elif name == "normal_force":
            found[name] = member.load.forces(time)
        elif name == "sliding_speed":
            found[name] = member.motion.speeds(time)
        else:
            layers = np.broadcast_arrays(*(rows[key] for key in _keys(member, name)))
            found[name] = np.stack(layers, axis=-2) if name in LAYERED else layers[0]
    return found


def _friction(member: Scenario, time: Real, force: Real) -> Real:
    """Return a friction without memory."""
    chain = under_force(member, time, force)
    return chain.known(chain.steady(time, force))


def _below(rows: list[Real]) -> Real:
    """Return rows of ranges of fingers below each other."""
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def _of_one_sine(member: Scenario, terms: list[tuple[Any, PiecewiseDrive]]) -> dict[Key, Any]:
    """Return the amplitudes of a law that is defined by magnitudes at the frequency of one sine."""
    frequency, _ = loudest_tone(member)
    timing = terms[0][1].timing
    tone: Any = total_of(
        factor * drive.tones[timing.frequencies == frequency].sum() for factor, drive in terms
    )
    return of_one_sine(member, frequency, tone * np.exp(2j * np.pi * frequency[0] * timing.outputs))


def respond(transfers: Mapping[K, Transfer], terms: Sequence[tuple[Any, PiecewiseDrive]]) -> dict[K, Real]:
    """Compute the response of linear quantities to a sum of drives with factors.

    `terms` are factors, 1 or a column (fingers, 1), and drives with common timing; returns rows (fingers, n), or
    (1, n) for what does not differ.
    """
    factors, drives = zip(*terms, strict=True)
    return of_factors(per_unit(transfers, drives), factors)


def per_unit(
    transfers: Mapping[K, Transfer], drives: Sequence[PiecewiseDrive]
) -> dict[K, tuple[Real | None, list[Real]]]:
    """Return the response of linear quantities to charge alone, None without it, and to each of some drives."""
    known: dict[Any, Real] = {}
    return {
        key: (
            _left(each, drives[0]) if np.any(each.free) else None,
            [_driven(each, drive, known) for drive in drives],
        )
        for key, each in transfers.items()
    }


def of_factors(
    unit: Mapping[K, tuple[Real | None, list[Real]]], factors: Sequence[Any], stacks: Any = slice(None)
) -> dict[K, Real]:
    """Return the responses of fingers (fingers, n) to the sum of drives times factors, 1 or columns, with the stack of each."""

    def of_fingers(rows: Real) -> Real:
        return rows[stacks] if len(rows) > 1 else rows

    def summed(left: Real | None, rows: list[Real]) -> Real:
        each = [of_fingers(row) for row in rows]
        parts = [row if np.ndim(one) == 0 else one * row for one, row in zip(factors, each, strict=True)]
        return np.asarray(total_of(parts if left is None else [*parts, of_fingers(left)]))

    return {key: summed(*given) for key, given in unit.items()}


def some_of(transfers: Mapping[K, Transfer], part: slice) -> dict[K, Transfer]:
    """Return the transfer functions of some fingers; what several have in common stays common."""
    known: dict[int, Any] = {}

    def some(number: Any) -> Any:
        return number if np.ndim(number) < 2 else known.setdefault(id(number), number[part])

    return {
        key: replace(each, **{name: some(number) for name, number in vars(each).items()})
        for key, each in transfers.items()
    }


def _rows(*arrays: Real) -> list[Real]:
    """Return arrays (modes,) and (fingers, modes) as arrays of one shape (fingers, modes)."""
    shape = np.broadcast_shapes(*(np.atleast_2d(each).shape for each in arrays))
    return [np.broadcast_to(each, shape) for each in arrays]


def _driven(transfer: Transfer, drive: PiecewiseDrive, known: dict[Any, Real]) -> Real:
    """Return the response to a drive, without that to charge, shape (fingers or 1, n)."""
    timing, lags = drive.timing, transfer.static is not None
    if timing.settled and np.any(weight := integral_weight(transfer)):
        if drive.mean:
            raise NotInArraysError("the integral of a drive with a mean has no period")
        relaxing = _driven(without_integrators(transfer), drive, known)
        return np.asarray(relaxing + weight * drive.integral)
    instant = np.atleast_2d(transfer.direct if transfer.static is None else transfer.static)
    rates, gains = _rows(transfer.rates, transfer.gains, instant * np.ones(transfer.rates.shape[-1]))[:2]
    active = np.any(gains != 0, axis=0)
    rates, gains = rates[:, active], gains[:, active]
    state = np.zeros(rates.shape)
    for place, part in enumerate(drive.repeated()):  # computed once for modes in common
        key = id(transfer.rates), id(drive), place
        if key not in known:
            known[key] = _periodic(part, np.atleast_2d(transfer.rates))
        state = state + gains * known[key][:, active]
    if lags:  # gain (x - v) in the place of gain x
        state = state - gains * drive.voltage[0]
    if not timing.settled:
        state = state - gains * _tones_at_start(drive, rates)
    found = np.zeros((len(rates), len(timing.outputs)))
    if timing.is_straight or np.any(state):
        direct = np.broadcast_to(instant, (len(rates), 1))[:, 0]
        found = _stepped(drive, rates, gains if lags else gains * rates, direct, state, lags=lags)
        found = found + transfer.slope * drive.slopes if np.any(transfer.slope) else found
    if drive.level:
        found = found + np.atleast_1d(transfer.at(0.0)).real[:, None] * drive.level
    if len(timing.frequencies):
        found = found + in_tones(transfer, timing.frequencies, drive.tones, timing.waves)
    return found


def in_tones(transfer: Transfer, frequencies: Real, tones: Complex, waves: Real) -> Real:
    """Return the response to sines that have always been on, shape (fingers or 1, n).

    `frequencies` (tones,) or (tones, fingers) [Hz]; `tones` (tones,) or (fingers, tones) [V]; `waves` (2 tones, n) or
    (fingers, 2 tones, n), cosines and minus sines at the outputs.
    """
    gain = np.stack([np.atleast_1d(transfer.at(each)) for each in frequencies], axis=1)
    own = gain * tones
    shares = np.concatenate([own.real, own.imag], axis=1)
    return np.asarray(shares @ waves if waves.ndim == 2 else (shares[:, None] @ waves)[:, 0])


def _tones_at_start(drive: PiecewiseDrive, rates: Real) -> Real:
    """Return the states of modes at time 0 in the steady state of all sines."""
    tones = zip(drive.timing.frequencies.tolist(), drive.tones.tolist(), strict=True)
    steady = ((rates * tone / (rates + 2j * np.pi * frequency)).real for frequency, tone in tones)
    return np.asarray(sum(steady, start=np.zeros(rates.shape)))


def _periodic(part: Linear, rates: Real) -> Real:
    """Return the states of modes (fingers, modes) at the beginning of a period; the drive does not excite trapped charge."""
    return periodic_state(part, np.where(rates > 0, rates, 1.0).ravel()).reshape(rates.shape)


def _left(transfer: Transfer, drive: PiecewiseDrive) -> Real:
    """Return the response to charge at time 0; in the periodic state only trapped charge remains."""
    rates, free = _rows(transfer.rates, transfer.free)
    left = np.where(rates == 0, free, 0.0) if drive.timing.settled else free
    nothing = PiecewiseDrive(drive.timing, np.zeros(len(drive.row)))
    return _stepped(nothing, rates, np.zeros(rates.shape), np.zeros(len(rates)), left, lags=False)


def _stepped(
    drive: PiecewiseDrive, rates: Real, residues: Real, direct: Real, state: Real, *, lags: bool
) -> Real:
    """Return the response of modes to the straight pieces of a drive at its outputs."""
    timing, rises = drive.timing, drive.rises if lags else None
    return first_order_hold_many(
        rates, residues, direct, state, drive.voltage, timing.steps, rises=rises, places=timing.places
    )
