"""Signals of fingers in arrays over fingers: what arrays cover, modes of all, responses to their drive, force, friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeAlias, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.tables import derived_at
from electrovib.physics.drive.parts import Tones
from electrovib.physics.stack import INTERFACE
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.over_frequency import OVER_FREQUENCY, loudest_tone, of_one_sine
from electrovib.solve.electrics.solution import linear_quantities
from electrovib.solve.electrics.transient import Response, is_integrating, settled_response
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.mechanics.mechanical import under_force
from electrovib.solve.rough_contact.solved import contact_of_each
from electrovib.solve.stack.harmonics import integral_of, mean_of
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf, amplitudes_among
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError, Transfer

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.physics.drive.parts import Part
    from electrovib.scenario import Scenario
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.section import ModalSection

K = TypeVar("K")
DrivenBy: TypeAlias = "Sequence[tuple[Any, Sequence[Part]]]"
"""Factors, 1 or a column (fingers, 1), and drives, whose sum is the drive of some fingers."""
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


def over_time(
    member: Scenario,
    known: Mapping[Key, Real],
    driven: Sequence[tuple[slice, DrivenBy]],
    time: Real,
    names: tuple[str, ...],
) -> dict[str, Any]:
    """Return signals over time of fingers from their linear quantities.

    `driven` are factors and drives, whose sum is the drive of a range of them; `time` (n,) [s].
    """
    rows: dict[Any, Any] = dict(known)
    if not member.force.causal:
        rows |= _of_one_sine(member, driven[0][1], time)
    found: dict[str, Any] = {}
    amplitudes = amplitudes_among(rows)
    force: Any = attraction(member, total_pull(member, amplitudes), time) if amplitudes else None
    for name in names:
        if name == "electrostatic_force":
            found[name] = force
        elif name == "lateral_force":
            found[name] = _friction(member, time, force)
        elif name == "drive_voltage":
            found[name] = below([_voltage(terms, time) for _, terms in driven])
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


def below(rows: list[Real]) -> Real:
    """Return rows of ranges of fingers below each other."""
    return rows[0] if len(rows) == 1 else np.concatenate([np.atleast_2d(row) for row in rows])


def _voltage(terms: DrivenBy, time: Real) -> Real:
    """Return the drive of fingers over time."""
    values = [sum((part.value(time) for part in parts), np.zeros(len(time))) for _, parts in terms]
    return np.asarray(total_of(factor * row for (factor, _), row in zip(terms, values, strict=True)))


def _of_one_sine(member: Scenario, terms: DrivenBy, time: Real) -> dict[Key, Any]:
    """Return the amplitudes of a law that is defined by magnitudes at the frequency of one sine."""
    frequency, _ = loudest_tone(member)

    def amplitude(parts: Sequence[Part]) -> complex:
        tones = [part for part in parts if isinstance(part, Tones)]
        return complex(sum(part.amplitudes[part.frequencies == frequency].sum() for part in tones))

    tone: Any = total_of(factor * amplitude(parts) for factor, parts in terms)
    return of_one_sine(member, frequency, tone * np.exp(2j * np.pi * frequency[0] * time))


def per_unit(
    transfers: Mapping[K, Transfer], drives: Mapping[str, Sequence[Part]], time: Real, *, settled: bool
) -> dict[K, list[Real]]:
    """Return the response of linear quantities to each of some drives, (n,) or (fingers, n).

    That of the empty path has the factor 1 in every finger, and initial charges respond with it.
    """
    found: dict[K, list[Real]] = {key: [] for key in transfers}
    for path, parts in drives.items():
        own = dict(transfers) if not path else {key: _without_charge(each) for key, each in transfers.items()}
        integral = None
        if settled and is_integrating(own):
            if mean_of(parts):
                raise NotInArraysError("the integral of a drive with a mean has no period")
            integral = integral_of(parts, time)
        rows = settled_response(own, parts, time, integral) if settled else Response(own, parts).at(time)
        for key, row in rows.items():
            found[key].append(row)
    return found


def _without_charge(transfer: Transfer) -> Transfer:
    return replace(transfer, free=np.zeros(transfer.rates.shape[-1])) if np.any(transfer.free) else transfer


def of_factors(
    unit: Mapping[K, list[Real]], factors: Sequence[Any], stacks: Any = slice(None)
) -> dict[K, Real]:
    """Return the responses of fingers (fingers, n) to the sum of drives times factors, 1 or columns, with the stack of each."""

    def summed(rows: list[Real]) -> Real:
        each = [row[stacks] if row.ndim > 1 and len(row) > 1 else row for row in rows]
        return np.asarray(
            total_of(row if np.ndim(one) == 0 else one * row for one, row in zip(factors, each, strict=True))
        )

    return {key: summed(rows) for key, rows in unit.items()}


def some_of(transfers: Mapping[K, Transfer], part: slice) -> dict[K, Transfer]:
    """Return the transfer functions of some fingers; what several have in common stays common."""
    known: dict[int, Any] = {}

    def some(number: Any) -> Any:
        return number if np.ndim(number) < 2 else known.setdefault(id(number), number[part])

    return {
        key: replace(each, **{name: some(number) for name, number in vars(each).items()})
        for key, each in transfers.items()
    }
