"""Modes and their drive, checked once before a recursion runs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from electrovib.core.arrays import Numbers, Real
from electrovib.core.errors import InputError


class Modes(NamedTuple):
    """Modes and their shares in each output.

    Parameters
    ----------
    poles : ndarray, (poles,)
        Rates [1/s]: negative, or complex with a negative real part.
    gains : ndarray, (outputs, poles)
        Share of every mode in every output [-], doubled for a mode that represents a pair. The output is the real part
        of the sum.
    direct : ndarray, (outputs,)
        Share of the drive itself in every output [-].
    lag : ndarray of bool, (outputs,)
        Whether an output takes the lag of every mode behind the drive in the place of the mode.
    """

    poles: Numbers
    gains: Numbers
    direct: Real
    lag: NDArray[np.bool_]


class StraightDrive(NamedTuple):
    """A drive of straight pieces.

    Parameters
    ----------
    starts, ends : ndarray, (pieces,)
        Drive just after the beginning and just before the end of each piece.
    steps : ndarray, (pieces,) or ()
        Durations [s]; one number when all are equal.
    """

    starts: Real
    ends: Real
    steps: Real

    def jumps(self) -> Real | None:
        """Return the drop of the drive at the beginning of each piece, or None for a continuous drive."""
        before, after = self.ends[:-1], self.starts[1:]
        same_memory = before.ctypes.data == after.ctypes.data  # both are contiguous and equally long
        if same_memory or np.array_equal(before, after):
            return None
        return np.concatenate(([0.0], before - after))


def gather(
    poles: ArrayLike,
    gains: ArrayLike,
    direct: ArrayLike,
    starts: ArrayLike,
    ends: ArrayLike,
    steps: ArrayLike,
    initial_state: ArrayLike,
    *,
    lag: ArrayLike = False,
    pairs: bool = False,
) -> tuple[Modes, StraightDrive, Numbers]:
    """Convert the arguments of a recursion into contiguous arrays and refuse arguments that disagree.

    Returns `state` (poles,).
    """
    kind = np.complex128 if pairs else np.float64
    shares = np.ascontiguousarray(direct, np.float64)
    modes = Modes(
        np.ascontiguousarray(poles, kind),
        np.ascontiguousarray(gains, kind),
        shares,
        np.broadcast_to(np.asarray(lag, bool), shares.shape),
    )
    sides = [np.ascontiguousarray(each, np.float64) for each in (starts, ends)]
    drive = StraightDrive(sides[0], sides[1], np.asarray(steps, np.float64))
    state: Numbers = np.array(initial_state, kind)
    problems = [*_shape_problems(modes, drive, state), *_value_problems(modes, drive)]
    if problems:
        raise InputError(problems)
    if pairs:
        modes = modes._replace(gains=modes.gains * np.where(modes.poles.imag == 0.0, 1.0, 2.0))
    if drive.steps.ndim and drive.steps.min() == drive.steps.max():
        drive = drive._replace(steps=drive.steps[0])
    return modes, drive, state


def _shape_problems(modes: Modes, drive: StraightDrive, state: Numbers) -> list[str]:
    """Return a message for every array whose shape disagrees with the poles, the outputs or the pieces of the drive."""
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


def _value_problems(modes: Modes, drive: StraightDrive) -> list[str]:
    """Return messages for poles that do not decay and for durations that are negative or not finite."""
    found = []
    if not np.all((modes.poles.real < 0.0) & (modes.poles.imag >= 0.0)):
        found.append(
            f"march.poles = {modes.poles}: every pole must be negative; "
            "a conserved quantity (pole 0) has to be integrated separately."
            + " Of a conjugate pair give the one with the positive imaginary part."
            * np.iscomplexobj(modes.poles)
        )
    if not np.all((drive.steps >= 0.0) & np.isfinite(drive.steps)):
        found.append("march.steps has a negative or non-finite duration; sort the time stamps.")
    return found
