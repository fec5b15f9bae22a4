"""Signals over time of many fingers, in arrays over fingers."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.changes import stored_path
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.core.paths import quantity_at
from electrovib.physics.interface import beside_interface
from electrovib.scenario import PeriodicState
from electrovib.solve.population.kernels import kernel_name
from electrovib.solve.population.together.accepted import refuse_apart
from electrovib.solve.population.together.amplitude import shared_drive
from electrovib.solve.population.together.arrays import check_values
from electrovib.solve.population.together.forces import write_forces, write_friction
from electrovib.solve.population.together.quadratic import is_quadratic
from electrovib.solve.population.together.reduced import count_poles, shared_reductions
from electrovib.solve.population.together.refusal import NotTogetherError
from electrovib.solve.population.together.tile import FingerTile

if TYPE_CHECKING:
    from collections.abc import Mapping

    from numpy.typing import NDArray

    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.solve.population.one_by_one import OneByOne
    from electrovib.solve.population.together.transfers import Transfers

AT_ONCE: Final = (1024, 256)
"""Fingers whose modes are in memory together: with few poles, and with many."""
FEW_POLES: Final = 8
"""Number of poles of the layers up to which they are few."""


class OverTime:
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
    band : ndarray, shape (m,), optional
        Times over whose band materials are reduced to Debye terms [s]; by default the output times.

    Raises
    ------
    NotTogetherError
        If arrays over fingers do not cover the scenario; with the reason.
    """

    def __init__(
        self,
        scenario: Scenario,
        free: tuple[str, ...],
        names: tuple[str, ...],
        time: Real,
        alone: OneByOne,
        *,
        band: Real | None = None,
    ) -> None:
        refuse_apart(scenario, free, names)
        self.scenario, self.free, self.names, self.time = scenario, free, names, time
        self.alone = alone
        settled = isinstance(scenario.time.initial_state, PeriodicState)
        of_drive = tuple(stored_path(scenario, path) for path in free if path.startswith("drive."))
        self.drive = shared_drive(scenario, of_drive, time, settled=settled)
        self.reduced = shared_reductions(scenario, free, time if band is None else band)
        self.at_once = AT_ONCE[count_poles(scenario, self.reduced) > FEW_POLES]
        self.is_quadratic = is_quadratic(scenario.force)
        self._quantities = {path: quantity_at(scenario, path) for path in free}
        self.kernel = kernel_name()

    def signals(
        self,
        draws: Mapping[str, Real],
        *,
        out: Mapping[str, NDArray[Any]] | None = None,
    ) -> dict[str, Any]:
        """Return the signals of fingers."""
        check_values(self.scenario, self._quantities, draws)
        fingers = len(next(iter(draws.values())))
        found: dict[str, Any] = dict(out or {})
        for name in self.names:
            found.setdefault(name, np.empty(self._shape(name, fingers)))
        for begin in range(0, fingers, self.at_once):
            part = slice(begin, min(begin + self.at_once, fingers))
            some = {path: values[part] for path, values in draws.items()}
            self._write({name: found[name][part] for name in self.names}, some)
        return {name: found[name] for name in self.names}

    def tile(self, draws: Mapping[str, Real]) -> FingerTile:
        """Return fingers in arrays."""
        return FingerTile.of(self.scenario, draws, self.reduced, self.drive)

    def _shape(self, name: str, fingers: int) -> tuple[int, ...]:
        if name in {"field", "displacement"}:
            return fingers, len(self.scenario.stack.layers), len(self.time)
        return fingers, len(self.time)

    def _write(self, found: Mapping[str, Any], draws: Mapping[str, Real]) -> None:
        """Write the signals of some fingers, those of another form one by one."""
        tile = self.tile(draws)
        regular = tile.section.modes.regular[: tile.fingers]
        if np.all(regular):
            for name, rows in found.items():
                if name != "lateral_force":
                    self._fill(rows, name, tile)
            if "lateral_force" in found:
                self._rub(found, tile)
            return
        for kept, engine in ((~regular, self.alone), (regular, self)):
            if np.any(kept):
                chosen = {path: values[kept] for path, values in draws.items()}
                for name, rows in engine.signals(chosen).items():
                    found[name][kept] = rows

    def _fill(self, rows: Real, name: str, tile: FingerTile) -> None:
        """Write one signal of fingers."""
        if name == "electrostatic_force":
            write_forces(rows, tile, self.time, quadratic=self.is_quadratic)
        elif name == "drive_voltage":
            total = np.zeros(rows.shape)
            for factor, drive in self.drive.terms(tile.columns):
                total += (factor if isinstance(factor, float) else factor[: len(rows)]) * drive.values()
            rows[:] = total
        elif name in {"normal_force", "sliding_speed"}:
            rows[:] = self._given(name, tile)[: len(rows)]
        elif name in {"field", "displacement"}:
            for place, layer in enumerate(tile.section.names):
                tile.write(rows[:, place], getattr(tile.section[layer], name))
        else:
            tile.write(rows, _quantity(name, tile))

    def _rub(self, found: Mapping[str, Any], tile: FingerTile) -> None:
        """Write the friction of fingers, under the attraction that has been written if it is not rounded."""
        rows, force = found["lateral_force"], found.get("electrostatic_force")
        if force is None or force.dtype != np.float64:
            force = np.empty((len(rows), len(self.time)))
            write_forces(force, tile, self.time, quadratic=self.is_quadratic)
        write_friction(rows, force, tile, self.time)

    def _given(self, name: str, tile: FingerTile) -> Real:
        """Return the load or the speed, shape (rows, n)."""
        load, motion = tile.scenario.load, tile.scenario.motion
        if name == "sliding_speed" and motion.speed is None:
            raise InputError("signals: this scenario has no 'sliding_speed'. Declare motion.speed")
        found = load.forces(self.time) if name == "normal_force" else motion.speeds(self.time)
        return np.broadcast_to(found, (tile.rows, len(self.time)))


def _quantity(name: str, tile: FingerTile) -> Transfers:
    """Return a linear quantity by the name of its signal."""
    section = tile.section
    if name == "stack_voltage":
        return section.voltage
    if name == "effective_voltage":
        found: Transfers | None = tile.scenario.force.effective_voltage(section)
        if found is None:
            raise NotTogetherError("the force law has no effective voltage")
        return found
    gap = beside_interface(section.roles, "gap")
    return section.interface_displacement.times(1 / eps0) if gap is None else section[gap].field
