"""Declared limits of a set-up, and whether a run exceeds them."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic, against
from electrovib.core.errors import InputError
from electrovib.core.mistakes import shown
from electrovib.core.model import Model
from electrovib.core.quantity import Number, Quantity

if TYPE_CHECKING:
    from collections.abc import Iterable, Mapping

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Real

_INTO: Final = "into plate, stray capacitance and finger"
_CURRENT: Final = f"of the amplifier {_INTO} together, by its own limiter"
_ENERGY: Final = "the energy stored in contact and stray capacitance"
PEAK: Final = "peak"
MEAN_SQUARE: Final = "root mean square"
HIGHEST_VOLTAGE: Final = 1e6
"""Largest voltage of a plate [V]; films break far below."""
VOLTAGE: Final = ("V", 1e-3, HIGHEST_VOLTAGE)
"""Range of the largest voltage of a set-up, of either sign."""
MOST_HELD: Final = 64
"""Most constant voltages that a contact goes through."""


@dataclass(frozen=True)
class LimitedQuantity(Quantity):
    """The range of a limit, and the quantity that it is compared with.

    `named` are its words where they are not those of the meaning of the limit. `order` is the power of the drive in which it
    grows while the set-up responds linearly, `of_rate` whether it follows the rate of change of the drive; `statistic` is `PEAK`
    or `MEAN_SQUARE` where the name of the limit does not say which value counts.
    """

    named: str = ""
    order: int = 1
    of_rate: bool = False
    statistic: str = ""

    @property
    def words(self) -> str:
        """The quantity in words."""
        return self.named or f"the {self.doc.removeprefix('largest ')}"


class Limits(Model):
    """Declared limits of the set-up; a limit that is not declared is not judged.

    Notes
    -----
    `voltage` is that of the plate relative to ground. `current` is that of the amplifier into the plate, the stray
    capacitance and the finger; `body_current` is the part of it through the finger. `charge` is that on the plate under the
    finger, D A with the bound displacement D of the layer at the plate. `stored_energy` is the energy that plate, layers and
    stray capacitance could release, A sum(T E D)/2 + C v^2/2 with thickness T, field E and bound displacement D of each
    layer and the voltage v of the plate; for two contacts the sum. `rms_voltage` and `rms_current` are root mean squares over
    the whole run, or over one period of a periodic state; `slew_rate` is that of the drive times the gain of the amplifier,
    before a bandwidth or a limit of the amplifier reduces it, and infinite at a discontinuity.
    """

    voltage: Annotated[
        Number | None, LimitedQuantity(*VOLTAGE, "largest voltage of the plate", statistic=PEAK)
    ] = None
    current: Annotated[
        Number | None,
        LimitedQuantity(
            *("A", 1e-9, 10, f"largest current {_CURRENT}"),
            named=f"the current {_INTO}",
            statistic=PEAK,
            of_rate=True,
        ),
    ] = None
    charge: Annotated[
        Number | None, LimitedQuantity("C", 1e-15, 1, "largest charge on the plate under the finger")
    ] = None
    stored_energy: Annotated[
        Number | None,
        LimitedQuantity(
            "J", 1e-15, 1e3, "largest energy in contact and stray capacitance", named=_ENERGY, order=2
        ),
    ] = None
    body_current: Annotated[
        Number | None,
        LimitedQuantity("A", 1e-9, 10, "largest current through the finger", statistic=PEAK, of_rate=True),
    ] = None
    rms_voltage: Annotated[
        Number | None,
        LimitedQuantity(*VOLTAGE, "largest root-mean-square voltage of the plate", statistic=MEAN_SQUARE),
    ] = None
    rms_current: Annotated[
        Number | None,
        LimitedQuantity(
            *("A", 1e-9, 10, f"largest root-mean-square current {_CURRENT}"),
            named=f"the root-mean-square current {_INTO}",
            statistic=MEAN_SQUARE,
        ),
    ] = None
    slew_rate: Annotated[
        Number | None,
        LimitedQuantity(
            "V/s", 1e-3, 1e13, "largest rate of change of the drive times the gain", of_rate=True
        ),
    ] = None
    example: ClassVar[dict[str, Any]] = {}


def limited(name: str) -> LimitedQuantity:
    """Return what a limit is compared with, which its field declares."""
    return next(each for each in Limits.model_fields[name].metadata if isinstance(each, LimitedQuantity))


WORDS: Final[Mapping[str, str]] = {name: limited(name).words for name in Limits.model_fields}
"""The quantity that each limit is compared with."""
PEAKS: Final = tuple(name for name in WORDS if limited(name).statistic == PEAK)
"""Limits whose name does not contain that they are those of a peak."""
MEAN_SQUARES: Final = tuple(name for name in WORDS if limited(name).statistic == MEAN_SQUARE)
"""Limits of root mean squares."""
SWITCH_ON: Final = " at switch-on"
"""Follows the name of a limit with which the current of the step at time 0 is compared."""


def held_voltages(voltage: ArrayLike) -> Real:
    """Return constant voltages [V] in a row, as many as a contact goes through and as large as a plate may have."""
    found = np.atleast_1d(np.asarray(voltage, dtype=float))
    if found.ndim != 1 or not 1 <= found.size <= MOST_HELD or not (np.abs(found) <= HIGHEST_VOLTAGE).all():
        raise InputError(
            f"voltage = {shown(found.tolist())}: expected 1 to {MOST_HELD} voltages in a row, at most {HIGHEST_VOLTAGE:g} V in"
            " size, for instance [0, 50, 100]"
        )
    return found


def limit_diagnostics(
    reached: Mapping[str, float], limits: Limits, *, amplified: bool = True
) -> list[Diagnostic]:
    """Compare the largest values of a run with the declared limits: one diagnostic for each limit that has a value.

    `reached` has by name of the limit the largest absolute value in its unit; with `SWITCH_ON` after the name
    the value that the step at time 0 alone causes. `amplified`: there is an amplifier, whose current may also
    enter a stray capacitance.
    """
    found = []
    for name, words in WORDS.items():
        limit = getattr(limits, name)
        if limit is None:
            continue
        what = words if amplified else words.replace(_INTO, "into the contact")
        why = f"the declared limit (limits.{name})"
        for when, more in (("", ""), (SWITCH_ON, " in the step at time 0")):
            if name + when in reached:
                title, value = _title(name) + when, reached[name + when]
                found.append(
                    against(
                        title, value=value, limit=limit, unit=unit_of_limit(name), what=what + more, why=why
                    )
                )
    return found


def unit_of_limit(name: str) -> str:
    """Return the SI unit of a limit."""
    return limited(name).unit


def _title(name: str) -> str:
    return name.replace("_", " ")


TITLES: Final = frozenset(_title(name) + when for name in WORDS for when in ("", SWITCH_ON))
"""Names of the diagnostics of declared limits."""


def broken(diagnostics: Iterable[Diagnostic]) -> list[Diagnostic]:
    """Select the diagnostics of declared limits that are exceeded."""
    return [each for each in diagnostics if each.name in TITLES and each.state == "warning"]
