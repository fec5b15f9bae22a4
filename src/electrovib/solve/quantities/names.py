"""Names of the quantities of a solution: a statistic of a signal."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from electrovib.core.errors import InputError, closest, nearest
from electrovib.core.signals import SIGNALS

if TYPE_CHECKING:
    from collections.abc import Iterable

TAKEN: Final = {
    "peak": "largest magnitude",
    "maximum": "largest value",
    "minimum": "smallest value",
    "swing": "largest less smallest value",
    "mean": "mean over time",
    "rms": "root of the mean square over time",
    "final": "value at the end, before a discontinuity at that time",
}
"""Statistics of a signal, with their meanings."""
DEFAULTS: Final = (
    "peak electrostatic_force",
    "mean electrostatic_force",
    "swing lateral_force",
    "peak current",
)
"""Quantities that are returned if none is named."""
_MOST: Final = 3


@dataclass(frozen=True)
class Named:
    """A quantity, by statistic, signal and layer.

    Parameters
    ----------
    taken : str
        Statistic, one of `TAKEN`.
    signal : str
        Signal over time.
    layer : str
        Layer of a signal that each layer has; else empty.
    """

    taken: str
    signal: str
    layer: str = ""

    @property
    def name(self) -> str:
        """Name as typed and printed: ``mean electrostatic_force``, ``peak field in gap``."""
        return f"{self.taken} {self.signal}" + (f" in {self.layer}" if self.layer else "")

    @property
    def unit(self) -> str:
        """SI unit."""
        return SIGNALS[self.signal].unit

    @property
    def meaning(self) -> str:
        """Meaning in words."""
        where = f" '{self.layer}'" if self.layer else ""
        return f"{TAKEN[self.taken]}: {SIGNALS[self.signal].doc}{where}"

    @property
    def key(self) -> tuple[str, str]:
        """Signal and layer."""
        return self.signal, self.layer


def signals_over_time() -> list[str]:
    """Return the names of the signals over time, of which quantities can be taken."""
    return [name for name, known in SIGNALS.items() if "time" in known.dims]


def read_name(text: str, layers: tuple[str, ...], *, others: Iterable[str] = ()) -> Named:
    """Read the name of a quantity."""
    head, _, where = text.strip().partition(" in ")
    taken, *rest = head.split() or [""]
    signal, layer = "_".join(rest), "_".join(where.split())
    if taken not in TAKEN:
        raise InputError(f"quantity '{text}': {_begin(text, taken, signal, others)}")
    if signal not in signals_over_time():
        near = _ending(taken, signal) or nearest(signal, signals_over_time())
        raise InputError(f"quantity '{text}': '{signal}' is not a signal over time.{near}")
    layered = "layer" in SIGNALS[signal].dims
    if layered != bool(layer) or (layer and layer not in layers):
        why = f"'{signal}' is not a signal of layers: omit 'in {layer}'"
        if layered:
            why = f"name one layer, '{taken} {signal} in {layers[0]}'.{nearest(layer, layers)}"
        raise InputError(f"quantity '{text}': {why}")
    return Named(taken, signal, layer)


def _begin(text: str, taken: str, signal: str, others: Iterable[str]) -> str:
    """Return how the name of a quantity begins, and the nearest one."""
    meant = closest(text, others)
    first, _, rest = text.strip().partition("_")
    ending = _ending(first, rest) if first in TAKEN else _ending("peak", text.strip())
    if meant is None and ending:
        return f"it does not begin with one of {', '.join(TAKEN)}.{ending}"
    if meant is None:
        known = next(
            (name for name in (signal, f"{taken}_{signal}", taken) if name in signals_over_time()), ""
        )
        meant = (
            f"{closest(taken, TAKEN) or 'peak'} {known}"
            if known
            else closest(text, [f"{every} {signal}" for every in TAKEN for signal in signals_over_time()])
        )
    if meant is not None:
        return f"it does not begin with one of {', '.join(TAKEN)}. Did you mean '{meant}'?"
    listed = ", ".join(f"{name} ({words})" for name, words in TAKEN.items())
    return f"expected one of {listed}, and a signal, for instance '{DEFAULTS[1]}'"


def _ending(taken: str, word: str) -> str:
    """Ask for the signals whose names end with a word, those of `DEFAULTS` first; empty without any."""
    usual = [name.rpartition(" ")[2] for name in DEFAULTS]
    names = sorted(signals_over_time(), key=lambda name: (name not in usual, name))
    found = [f"'{taken} {name}'" for name in names if name == word or name.endswith(f"_{word}")]
    return f" Did you mean {' or '.join(found[:_MOST])}?" if word and found else ""
