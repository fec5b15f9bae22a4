"""A permittivity as a sum of Debye relaxations: the form that has a finite state in time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from electrovib.core.errors import refuse


@dataclass(frozen=True)
class DebyeSum:
    r"""Polarisation that relaxes with a finite number of time constants.

    Parameters
    ----------
    high : float
        Relative permittivity far above all relaxations, 1, > 0.
    strengths : tuple of float
        Step of relative permittivity of each relaxation, 1, each >= 0.
    relaxation_times : tuple of float
        Time constant of each relaxation, s, each > 0, as many as ``strengths``.

    Raises
    ------
    InputError
        A value is outside its range or the two tuples differ in length.

    Notes
    -----
    With the time factor ``exp(+j w t)``,

    .. math:: \varepsilon(\omega) = h + \sum_m \frac{s_m}{1 + j \omega \tau_m}.

    Each number can be a column of shape (fingers, 1), which gives a row for each finger.
    Conduction is not part of it. Non-negative strengths make the sum passive and causal at every frequency.

    References
    ----------
    .. [1] P. Debye, *Polar Molecules*, Chemical Catalog Company, New York, 1929.
    """

    high: float
    strengths: tuple[float, ...] = ()
    relaxation_times: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        problems: list[str] = []
        if not _is_at_least(self.high, above=True):
            problems.append(f"high = {self.high!r}: a relative permittivity must be finite and above 0.")
        if len(self.strengths) != len(self.relaxation_times):
            problems.append(
                f"{len(self.strengths)} strengths but {len(self.relaxation_times)} relaxation_times: "
                "give one time for each strength."
            )
        problems += [
            f"strengths[{index}] = {value!r}: must be finite and >= 0, otherwise the dielectric is active."
            for index, value in enumerate(self.strengths)
            if not _is_at_least(value, above=False)
        ]
        problems += [
            f"relaxation_times[{index}] = {value!r}: must be finite and above 0 s."
            for index, value in enumerate(self.relaxation_times)
            if not _is_at_least(value, above=True)
        ]
        refuse(problems)

    def permittivity(self, frequency: npt.ArrayLike) -> npt.NDArray[np.complex128]:
        """Return the relative permittivity ``eps' - j eps''`` without conduction, of the shape of the frequency [Hz].

        Frequency 0 gives the static value.
        """
        angular = 2 * np.pi * np.asarray(frequency, dtype=float)
        if any(np.ndim(value) for value in (self.high, *self.strengths, *self.relaxation_times)):
            terms = zip(self.strengths, self.relaxation_times, strict=True)
            rows = sum((strength / (1 + 1j * angular * time) for strength, time in terms), start=0j * angular)
            return np.asarray(self.high + rows)
        angular = angular[..., np.newaxis]
        times = np.asarray(self.relaxation_times, dtype=float)
        strengths = np.asarray(self.strengths, dtype=float)
        return np.asarray(self.high + (strengths / (1 + 1j * angular * times)).sum(axis=-1))


def _is_at_least(value: float | npt.NDArray[np.float64], *, above: bool) -> bool:
    """Tell whether a number, or each of a column, is finite and at least 0, or above it."""
    if isinstance(value, np.ndarray):
        return bool(np.all(np.isfinite(value) & ((value > 0) if above else (value >= 0))))
    return math.isfinite(value) and (value > 0 if above else value >= 0)
