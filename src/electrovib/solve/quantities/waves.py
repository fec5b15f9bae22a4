"""Responses of one stack to many sines, as arrays over all cases."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.core.arrays import Complex, Indices, Real
    from electrovib.solve.stack.keys import Key
    from electrovib.solve.stack.transfer import Transfer


@dataclass(frozen=True)
class Sines:
    """Sines that drive one stack, one in each case.

    Parameters
    ----------
    frequency : ndarray, shape (cases,)
        Frequencies [Hz].
    amplitude : ndarray of complex, shape (cases,)
        Complex amplitudes: peak values with phase [V].
    """

    frequency: Real
    amplitude: Complex

    def weights(self, transfers: Mapping[Key, Transfer]) -> dict[Key, Complex]:
        """Return the complex amplitudes of linear quantities in every case."""
        groups: dict[bytes, list[Key]] = {}
        for name, transfer in transfers.items():
            groups.setdefault(transfer.rates.tobytes(), []).append(name)
        s, found = 2j * np.pi * self.frequency, dict[Any, Any]()
        for names in groups.values():
            rates = transfers[names[0]].rates
            share = 1 / (s[:, None] + rates)
            for name in names:
                each = transfers[name]
                level, parts = (
                    (each.direct, each.gains * rates) if each.static is None else (each.static, 0.0)
                )
                modal = share @ parts if each.static is None else -s * (share @ each.gains)
                found[name] = (level + each.slope * s + modal) * self.amplitude
        return found

    def waves(self, cases: Indices, times: Real) -> tuple[Real, Real]:
        """Return cosine and sine of the phase of some cases at some times.

        `cases` (n,), `times` (n,) [s]; returns `cosine`, `sine` (n,).
        """
        phase = 2 * np.pi * self.frequency[cases] * times
        return np.cos(phase), np.sin(phase)


def rows_of(weights: Mapping[Key, Complex], cases: Indices, waves: tuple[Real, Real]) -> dict[Key, Real]:
    """Return linear quantities of some cases over time from their complex amplitudes.

    `cases` (n,).
    """
    cosine, sine = waves
    return {name: each.real[cases] * cosine - each.imag[cases] * sine for name, each in weights.items()}
