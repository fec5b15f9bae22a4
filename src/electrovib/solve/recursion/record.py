"""Modes and the drive they follow, checked once before either recursion runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.errors import InputError

Array = NDArray[np.float64]


class Modes(NamedTuple):
    """Real relaxing modes and what each of them gives to each output.

    Parameters
    ----------
    poles : ndarray, (poles,)
        Rates [1/s], negative.
    gains : ndarray, (outputs, poles)
        Share of every mode in every output [-].
    direct : ndarray, (outputs,)
        Share of the drive itself in every output [-].
    """

    poles: Array
    gains: Array
    direct: Array


class Drive(NamedTuple):
    """A drive of straight pieces.

    Parameters
    ----------
    starts, ends : ndarray, (pieces,)
        Drive just after the beginning and just before the end of each piece.
    steps : ndarray, (pieces,) or ()
        Durations [s]; one number when all are equal.
    """

    starts: Array
    ends: Array
    steps: Array

    def jumps(self) -> Array | None:
        """Give the drop of the drive at the beginning of each piece, or None when it never jumps."""
        before, after = self.ends[:-1], self.starts[1:]
        if _same_memory(before, after) or np.array_equal(before, after):
            return None
        return np.concatenate(([0.0], before - after))


def _same_memory(one: Array, other: Array) -> bool:
    """Tell whether both views begin at the same number; both are contiguous and equally long."""
    return bool(one.__array_interface__["data"][0] == other.__array_interface__["data"][0])


def gather(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
) -> tuple[Modes, Drive, Array]:
    """Turn the arguments of a recursion into contiguous arrays and refuse what does not fit together.

    Parameters
    ----------
    poles, gains, direct, starts, ends, steps, initial_state : array_like
        As in ``march``.

    Returns
    -------
    modes : Modes
        Poles, gains and direct share.
    drive : Drive
        Pieces; ``steps`` has shape () when all durations are equal.
    state : ndarray, (poles,)
        State at the first point, a copy.

    Raises
    ------
    InputError
        If shapes disagree, a pole is not negative, or a duration is negative or not finite.
    """
    given = [np.ascontiguousarray(each, np.float64) for each in (poles, gains, direct, starts, ends)]
    modes, drive = Modes(*given[:3]), Drive(given[3], given[4], np.asarray(steps, np.float64))
    state = np.array(initial_state, np.float64)
    problems = [*_shape_problems(modes, drive, state), *_value_problems(modes, drive)]
    if problems:
        raise InputError(problems)
    if drive.steps.ndim and drive.steps.min() == drive.steps.max():
        drive = drive._replace(steps=drive.steps[0])
    return modes, drive, state


def _shape_problems(modes: Modes, drive: Drive, state: Array) -> list[str]:
    """List every array whose shape disagrees with the poles, the outputs or the pieces of drive."""
    count, outputs, pieces = modes.poles.size, modes.direct.size, drive.starts.size
    wanted = {
        "poles": (modes.poles, (count,)),
        "gains": (modes.gains, (outputs, count)),
        "direct": (modes.direct, (outputs,)),
        "starts": (drive.starts, (pieces,)),
        "ends": (drive.ends, (pieces,)),
        "steps": (drive.steps, (pieces,) if drive.steps.ndim else ()),
        "initial_state": (state, (count,)),
    }
    found = [
        f"march.{name} has shape {array.shape}, expected {shape}: {count} poles, {outputs} outputs, "
        f"{pieces} pieces of drive."
        for name, (array, shape) in wanted.items()
        if array.shape != shape
    ]
    return found if pieces else [*found, "march.starts is empty: give at least one piece of drive."]


def _value_problems(modes: Modes, drive: Drive) -> list[str]:
    """List poles that do not relax and durations that run backwards."""
    found = []
    if not np.all(modes.poles < 0.0):
        found.append(
            f"march.poles = {modes.poles}: every pole must be negative; "
            "a conserved quantity (pole 0) is integrated, not relaxed."
        )
    if not np.all((drive.steps >= 0.0) & np.isfinite(drive.steps)):
        found.append("march.steps holds a negative or not finite duration; sort the time stamps.")
    return found
