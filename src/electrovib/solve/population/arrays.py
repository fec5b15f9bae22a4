"""Signals of fingers in arrays over fingers: what arrays cover, modes of all, responses to their drive, force, friction."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any, Final, TypeVar

import numpy as np

from electrovib.core.errors import InputError
from electrovib.core.tables import derived_at
from electrovib.physics.drive.parts import Tones
from electrovib.physics.stack import INTERFACE
from electrovib.solve.choice import chosen
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.over_frequency import OVER_FREQUENCY, loudest_tone
from electrovib.solve.electrics.rows import NOTHING, some_cases
from electrovib.solve.electrics.solution import TRANSIENT, Solution, linear_quantities
from electrovib.solve.electrics.transient import respond
from electrovib.solve.mechanics.lateral import resting
from electrovib.solve.mechanics.mechanical import FrictionChain
from electrovib.solve.stack.expand import phasors
from electrovib.solve.stack.harmonics import integral_of, mean_of
from electrovib.solve.stack.keys import AmplitudeOf, DisplacementOf, FieldOf, amplitudes_among
from electrovib.solve.stack.section import total_of
from electrovib.solve.stack.transfer import NotInArraysError, Transfer

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.population.drive import Parts, Terms
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
    responses: list[dict[Key, Real]],
    driven: list[Terms],
    names: tuple[str, ...],
    time: Real,
) -> dict[str, Any]:
    """Return signals over time of fingers, from the responses and drives of ranges of them; `time` (n,) [s]."""
    rows: dict[Any, Any] = {key: _below([row[key] for row in responses]) for key in responses[0]}
    if not member.force.causal:
        rows |= _of_one_sine(member, driven[0], time)
    found: dict[str, Any] = {}
    amplitudes = amplitudes_among(rows)
    force: Any = attraction(member, total_pull(member, amplitudes), time) if amplitudes else None
    for name in names:
        if name == "electrostatic_force":
            found[name] = force
        elif name == "lateral_force":
            found[name] = _friction(member, time, force)
        elif name == "drive_voltage":
            own = [
                total_of(factor * part.value(time) for factor, parts in terms for part in parts)
                for terms in driven
            ]
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
    solution = Solution(found={}, method=TRANSIENT, reason="", force=force)
    chain = FrictionChain(member, time, solution, lambda _: solution)
    return chain.known(chain.steady(time, force))


def _below(rows: list[Real]) -> Real:
    """Return rows of ranges of fingers below each other."""
    return rows[0] if len(rows) == 1 else np.concatenate(rows)


def _of_one_sine(member: Scenario, terms: Terms, time: Real) -> dict[Key, Any]:
    """Return the amplitudes of a law that is defined by magnitudes at the frequency of one sine."""
    frequency, _ = loudest_tone(member)
    tone: Any = total_of(
        factor * part.amplitudes[part.frequencies == frequency].sum()
        for factor, parts in terms
        for part in parts
        if isinstance(part, Tones)
    )
    wave = tone * np.exp(2j * np.pi * frequency[0] * time)
    exact = phasors(member, frequency)
    found: dict[Key, Any] = {
        AmplitudeOf(name): np.real(value * wave) for name, value in member.force.amplitudes(exact).items()
    }
    effective = member.force.effective_voltage(exact)
    return found if effective is None else found | {"effective_voltage": np.real(effective * wave)}


def respond_to(
    transfers: Mapping[K, Transfer], terms: Terms, time: Real, *, settled: bool
) -> Callable[[slice], dict[K, Real]]:
    """Return the response of linear quantities to a sum of drives with factors, as a function of stretches of the fingers.

    `terms` are factors, 1 or a column (fingers, 1), and the parts of drives; `time` (n,) [s]. Rows are (fingers, n), or (1, n)
    for what does not differ.
    """

    def alone(given: Mapping[K, Transfer], parts: Parts) -> Callable[[slice], dict[K, Real]]:
        def integral() -> Real:
            if mean_of(parts):
                raise NotInArraysError("the integral of a drive with a mean has no period")
            return integral_of(parts, time)

        return respond(given, parts, time, settled=settled, integral=integral, many=True)

    forced = {key: replace(each, free=np.zeros(0)) for key, each in transfers.items()}
    left = {key: replace(each * 0.0, free=each.free) for key, each in transfers.items() if np.any(each.free)}
    driven = [(factor, alone(forced, parts)) for factor, parts in terms]
    driven += [(1.0, alone(left, [NOTHING]))] if left else []

    def through(stretch: slice) -> dict[K, Real]:
        rows = [(some_cases(factor, stretch), each(stretch)) for factor, each in driven]
        return {
            key: total_of(
                row[key] if np.ndim(factor) == 0 else factor * row[key] for factor, row in rows if key in row
            )
            for key in transfers
        }

    return through


def some_of(transfers: Mapping[K, Transfer], part: slice) -> dict[K, Transfer]:
    """Return the transfer functions of some fingers; what several have in common stays common."""
    known: dict[int, Any] = {}

    def some(number: Any) -> Any:
        return number if np.ndim(number) < 2 else known.setdefault(id(number), number[part])

    return {
        key: replace(each, **{name: some(number) for name, number in vars(each).items()})
        for key, each in transfers.items()
    }
