"""Signals of many fingers in arrays over fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np

from electrovib.core.changes import stored_path
from electrovib.core.errors import InputError
from electrovib.physics.interface import beside_interface
from electrovib.scenario import PeriodicState
from electrovib.solve.electrics.attraction import attraction, total_pull
from electrovib.solve.electrics.methods import TRANSIENT
from electrovib.solve.electrics.solution import Solution
from electrovib.solve.mechanics.friction_chain import FrictionChain
from electrovib.solve.population.kernels import kernel_name
from electrovib.solve.population.one_by_one import OneByOne
from electrovib.solve.population.together.accepted import refuse_apart
from electrovib.solve.population.together.amplitude import shared_drive
from electrovib.solve.population.together.arrays import check_ranges, stored_columns, with_columns
from electrovib.solve.population.together.quadratic import is_quadratic
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.response import Response
from electrovib.solve.population.together.section import ManySection
from electrovib.solve.stack.expand import reductions

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Indices, Real
    from electrovib.physics.debye_sum import DebyeSum
    from electrovib.scenario import Scenario
    from electrovib.solve.population.together.amplitude import SharedDrive
    from electrovib.solve.population.together.transfers import Transfers

AT_ONCE: Final = 256
"""Fingers whose modes are in memory together."""
FORCES: Final = 64
"""Fingers whose responses are in memory together."""
FEWEST: Final = 8
"""Fewest fingers of an array: sums over modes are formed row by row only for two columns or more."""


class Together:
    """Fingers of a scenario with linear layers, a fixed gap and a drive of straight pieces or sines, in arrays.

    Parameters
    ----------
    scenario : Scenario
        Experiment with the values that all fingers share.
    free : tuple of str
        Dotted paths of the parameters that differ between fingers.
    names : tuple of str
        Signals over time.
    time : ndarray, shape (n,)
        Output times [s].
    alone : OneByOne
        The same fingers one by one, for those whose numbers have another form.

    Raises
    ------
    NotTogetherError
        If arrays over fingers do not cover the scenario; with the reason.
    """

    def __init__(
        self, scenario: Scenario, free: tuple[str, ...], names: tuple[str, ...], time: Real, alone: OneByOne
    ) -> None:
        refuse_apart(scenario, free, names)
        self.scenario, self.free, self.names, self.time = scenario, free, names, time
        self.alone = alone
        self.settled = isinstance(scenario.time.initial_state, PeriodicState)
        of_drive = tuple(stored_path(scenario, path) for path in free if path.startswith("drive."))
        self.drive: SharedDrive = shared_drive(scenario, of_drive, time, settled=self.settled)
        self.reduced = _reduced(scenario, free, time)
        self.is_quadratic = is_quadratic(scenario.force)
        self.kernel = kernel_name()

    def signals(self, draws: Mapping[str, Real], *, threads: int | None = None) -> dict[str, Any]:
        """Return the signals of fingers.

        Parameters
        ----------
        draws : mapping of str to ndarray, shape (fingers,)
            Dotted path to the value of each finger, in SI units.
        threads : int, optional
            Threads of the kernel.

        Returns
        -------
        signals : dict of str to ndarray, shape (fingers, n) or (fingers, layers, n)
            Each signal in its unit.

        Raises
        ------
        InputError
            If a value is outside its range; names the first such finger.
        """
        check_ranges(self.scenario, draws)
        fingers = len(next(iter(draws.values())))
        found = {name: np.empty(self._shape(name, fingers)) for name in self.names}
        for begin in range(0, fingers, AT_ONCE):
            part = slice(begin, min(begin + AT_ONCE, fingers))
            some = {path: values[part] for path, values in draws.items()}
            self._write({name: rows[part] for name, rows in found.items()}, some, threads)
        return found

    def squares(self, draws: Mapping[str, Real]) -> Squares | None:
        """Return the attraction of fingers as factors times squares of sums of modes, for streamed statistics.

        Parameters
        ----------
        draws : mapping of str to ndarray, shape (fingers,)
            Dotted path to the value of each finger, in SI units.

        Returns
        -------
        squares : Squares or None
            Arguments of `kernels.square_moments_many`; None where the law is not quadratic, the drive is not one sum of
            straight pieces for all fingers, or a finger has another form.

        Raises
        ------
        InputError
            If a value is outside its range; names the first such finger.
        """
        check_ranges(self.scenario, draws)
        if not self.is_quadratic or self.names != ("electrostatic_force",):
            return None
        fingers = self.section(draws)
        square = self._square(fingers.scenario.force.amplitudes(fingers.section), fingers)
        if square is None or not np.all(fingers.section.modes.regular[: fingers.count]):
            return None
        parts, some = self.responses(square.base, fingers), slice(0, fingers.count)
        if len(parts) > 1 or not parts[0].is_alone_stepped:
            return None
        drive = parts[0].drive
        return Squares(
            rates=parts[0].rates[some],
            residues=parts[0].residues[some],
            direct=parts[0].direct[some],
            state=parts[0].state[some],
            voltage=drive.voltage,
            time=drive.time,
            factor=square.factor[some],
            places=drive.places,
        )

    def _shape(self, name: str, fingers: int) -> tuple[int, ...]:
        if name in {"field", "displacement"}:
            return fingers, len(self.scenario.stack.layers), len(self.time)
        return fingers, len(self.time)

    def _write(self, found: Mapping[str, Any], draws: Mapping[str, Real], threads: int | None) -> None:
        """Write the signals of some fingers, those of another form one by one."""
        whole = self.section(draws)
        count = len(next(iter(draws.values())))
        regular = whole.section.modes.regular[:count]
        if np.all(regular):
            for name, rows in found.items():
                self._fill(rows, name, whole, threads)
            return
        for kept, engine in ((~regular, self.alone), (regular, self)):
            if np.any(kept):
                chosen = {path: values[kept] for path, values in draws.items()}
                for name, rows in engine.signals(chosen).items():
                    found[name][kept] = rows

    def section(self, draws: Mapping[str, Real]) -> Fingers:
        """Return the stacks of fingers as relaxation modes.

        Parameters
        ----------
        draws : mapping of str to ndarray, shape (fingers,)
            Dotted path to the value of each finger, in SI units.

        Returns
        -------
        Fingers
            With at least `FEWEST` rows; those beyond the fingers repeat the last one.
        """
        columns = stored_columns(self.scenario, draws)
        count = len(next(iter(columns.values())))
        if count < FEWEST:
            columns = {
                path: np.pad(column, ((0, FEWEST - count), (0, 0)), "edge")
                for path, column in columns.items()
            }
        of_scenario = {path: column for path, column in columns.items() if not path.startswith("drive.")}
        scenario = with_columns(self.scenario, of_scenario)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):  # fingers of another form
            section = ManySection(scenario, tuple(of_scenario), self.reduced, max(count, FEWEST))
        return Fingers(scenario, section, columns, count)

    def _fill(self, rows: Real, name: str, fingers: Fingers, threads: int | None) -> None:
        """Write one signal of fingers."""
        scenario, section = fingers.scenario, fingers.section
        if name == "electrostatic_force":
            self._forces(rows, fingers, threads)
        elif name == "drive_voltage":
            self._voltages(rows, fingers)
        elif name in {"normal_force", "sliding_speed"}:
            given = scenario.load.forces if name == "normal_force" else scenario.motion.speeds
            if name == "sliding_speed" and scenario.motion.speed is None:
                raise InputError("signals: this scenario has no 'sliding_speed'. Declare motion.speed")
            rows[:] = np.broadcast_to(given(self.time), (len(section.modes.regular), len(self.time)))[
                : len(rows)
            ]
        elif name == "lateral_force":
            force = np.empty((len(rows), len(self.time)))
            self._forces(force, fingers, threads)
            self._friction(rows, force, fingers)
        elif name in {"field", "displacement"}:
            for place, layer in enumerate(section.names):
                self._linear(rows[:, place], getattr(section[layer], name), fingers, threads)
        else:
            self._linear(rows, self._quantity(name, fingers), fingers, threads)

    def _quantity(self, name: str, fingers: Fingers) -> Transfers:
        """Return a linear quantity by the name of its signal."""
        section = fingers.section
        if name == "stack_voltage":
            return section.voltage
        if name == "effective_voltage":
            found = fingers.scenario.force.effective_voltage(section)
            if found is None:
                raise NotTogetherError("the force law has no effective voltage")
            return found  # type: ignore[no-any-return]
        gap = beside_interface(section.roles, "gap")
        if gap is None:
            from electrovib.core.constants import eps0

            return section.interface_displacement * (1 / eps0)
        return section[gap].field

    def responses(self, transfers: Transfers, fingers: Fingers) -> list[Response]:
        """Return the responses of a quantity to the parts of the drive, whose sum is its response.

        Parameters
        ----------
        transfers : Transfers
            The quantity, per volt.
        fingers : Fingers
            Of the same fingers.

        Returns
        -------
        responses : list of Response
            One for each part of the drive.
        """
        found = []
        for factor, drive in self.drive.terms(fingers.columns):
            found.append(Response(transfers.under(factor), drive))
            transfers = transfers.without_charge()  # charge acts once
        return found

    def _linear(self, rows: Real, transfers: Transfers, fingers: Fingers, threads: int | None) -> None:
        """Write a linear quantity of fingers."""
        parts = self.responses(transfers, fingers)
        for some in _parts(len(rows)):
            _write(rows[some], parts, some, threads)

    def _forces(self, rows: Real, fingers: Fingers, threads: int | None) -> None:
        """Write the attraction of fingers, by the text of the force law."""
        asked = fingers.scenario.force.amplitudes(fingers.section)
        square = self._square(asked, fingers)
        if square is not None:
            parts = self.responses(square.base, fingers)
            for some in _parts(len(rows)):
                if len(parts) == 1:
                    parts[0].write(rows[some], some, factor=square.factor, threads=threads)
                else:
                    _write(rows[some], parts, some, threads)
                    np.multiply(rows[some], rows[some], out=rows[some])
                    rows[some] *= square.factor[some, None]
            return
        asked_parts = {name: self.responses(transfers, fingers) for name, transfers in asked.items()}
        for some in _parts(len(rows)):
            values = {name: np.empty(rows[some].shape) for name in asked_parts}
            for name, parts in asked_parts.items():
                _write(values[name], parts, some, threads)
            member = fingers.some(some)
            rows[some] = attraction(member, total_pull(member, values), self.time)

    def _square(self, asked: Mapping[str, Transfers], fingers: Fingers) -> Square | None:
        """Return the attraction as a factor times the square of one linear quantity; None where it is not of that form."""
        if not self.is_quadratic:
            return None
        bases = {id(each.base or each): each.base or each for each in asked.values()}
        if len(bases) != 1:
            return None
        (base,) = bases.values()
        rows = len(fingers.section.modes.regular)
        shares = {
            name: np.broadcast_to(1.0 if each.base is None else each.share, rows)[:, None]
            for name, each in asked.items()
        }
        factor = attraction(fingers.scenario, total_pull(fingers.scenario, shares))
        return Square(base, np.ascontiguousarray(np.broadcast_to(factor, (rows, 1))[:, 0]))

    def _voltages(self, rows: Real, fingers: Fingers) -> None:
        """Write the voltage of the drive."""
        rows[:] = 0.0
        for factor, drive in self.drive.terms(fingers.columns):
            share = factor if isinstance(factor, float) else factor[: len(rows)]
            rows += share * drive.values()

    def _friction(self, rows: Real, force: Real, fingers: Fingers) -> None:
        """Write the friction under the attraction."""
        for some in _parts(len(rows)):
            member = fingers.some(some)
            solution = Solution(found={}, method=TRANSIENT, reason="", force=force[some])
            chain = FrictionChain(member, self.time, solution, lambda _, found=solution: found)  # type: ignore[misc]
            rows[some] = chain.known(chain.steady(self.time, force[some]))


class Fingers(NamedTuple):
    """Fingers in arrays.

    Parameters
    ----------
    scenario : Scenario
        With columns.
    section : ManySection
        Their stacks.
    columns : dict of str to ndarray, shape (rows, 1)
        Values of the free parameters by stored path.
    count : int
        Number of fingers; further rows repeat the last one.
    """

    scenario: Scenario
    section: ManySection
    columns: dict[str, Real]
    count: int

    def some(self, part: slice) -> Scenario:
        """Return the scenario with the columns of a range of fingers."""
        cut = {path: column[part] for path, column in self.columns.items() if not path.startswith("drive.")}
        return with_columns(self.scenario, cut)


class Squares(NamedTuple):
    """The attraction of fingers as a factor times the square of a sum of modes, on a grid with the corners of the drive.

    Parameters
    ----------
    rates, residues, state : ndarray, shape (fingers, modes)
        As for `kernels.first_order_hold_many`.
    direct : ndarray, shape (fingers,)
        As for `kernels.first_order_hold_many`.
    voltage, time : ndarray, shape (m,)
        Drive [V] and times of the grid [s], the same for every call.
    factor : ndarray, shape (fingers,)
        Attraction over the square of the response.
    places : ndarray of int, shape (n,)
        Index of each output time in the grid.
    """

    rates: Real
    residues: Real
    direct: Real
    state: Real
    voltage: Real
    time: Real
    factor: Real
    places: Indices


class Square(NamedTuple):
    """The attraction of fingers as a factor times the square of a linear quantity.

    Parameters
    ----------
    base : Transfers
        The quantity, per volt.
    factor : ndarray, shape (rows,)
        Factor of each finger, in N over the unit of the quantity squared.
    """

    base: Transfers
    factor: Real


def _parts(count: int) -> list[slice]:
    return [slice(begin, min(begin + FORCES, count)) for begin in range(0, count, FORCES)]


def _write(out: Real, parts: list[Response], some: slice, threads: int | None) -> None:
    """Write the sum of the responses of some fingers."""
    parts[0].write(out, some, threads=threads)
    for part in parts[1:]:
        more = np.empty(out.shape)
        part.write(more, some, threads=threads)
        out += more


def _reduced(scenario: Scenario, free: tuple[str, ...], time: Real) -> dict[str, DebyeSum]:
    """Return the bound permittivities that have to be reduced to Debye terms, which are the same for all fingers."""
    dispersive = [name for name, layer in scenario.stack.layers.items() if layer.material.debye() is None]
    for name in dispersive:
        start = f"stack.{name}.material."
        changed = [path.removeprefix(start) for path in free if path.startswith(start)]
        if any(path != "conductivity" for path in changed):
            raise NotTogetherError(
                f"{start}{changed[0]} changes a permittivity that each finger has to reduce by itself"
            )
        material = scenario.stack.layers[name].material
        if changed and not _is_apart_from_conduction(material):
            raise NotTogetherError(
                f"the bound permittivity of stack.{name}.material depends on its conductivity"
            )
    if not dispersive:
        return {}
    found = reductions(scenario, time)
    return {name: found[name].debye for name in dispersive}


def _is_apart_from_conduction(material: Any) -> NDArray[np.bool_] | bool:
    """Return whether the bound permittivity does not depend on the conductivity."""
    frequency = np.geomspace(1e-2, 1e8, 21)
    try:
        other = material.replace({"conductivity": 0.5 * material.conductivity or 1e-6})
    except InputError:
        return False
    one, two = (each.bound_permittivity(frequency) for each in (material, other))
    return bool(np.array_equal(one, two)) and material.slowest_relaxation == other.slowest_relaxation
