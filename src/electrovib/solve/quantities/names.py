"""Names of the numbers that one may ask of a solution: what is taken of which signal."""

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
    "final": "value at the end, before a jump that falls there",
}
"""What may be taken of a signal."""
DEFAULTS: Final = (
    "peak electrostatic_force",
    "mean electrostatic_force",
    "swing lateral_force",
    "peak current",
)
"""What is answered if nothing is asked."""


@dataclass(frozen=True)
class Named:
    """A quantity by its name.

    Parameters
    ----------
    taken : str
        One of `TAKEN`.
    signal : str
        A signal over time.
    layer : str
        Of a signal that layers have; else empty.
    """

    taken: str
    signal: str
    layer: str = ""

    @property
    def name(self) -> str:
        """As it is asked for and written: ``mean electrostatic_force``, ``peak field in gap``."""
        return f"{self.taken} {self.signal}" + (f" in {self.layer}" if self.layer else "")

    @property
    def unit(self) -> str:
        """SI unit."""
        return SIGNALS[self.signal].unit

    @property
    def meaning(self) -> str:
        """In words."""
        where = f" '{self.layer}'" if self.layer else ""
        return f"{TAKEN[self.taken]}: {SIGNALS[self.signal].doc}{where}"

    @property
    def key(self) -> tuple[str, str]:
        """Signal and layer."""
        return self.signal, self.layer


def signals_over_time() -> list[str]:
    """List the signals of which a quantity can be taken."""
    return [name for name, known in SIGNALS.items() if "time" in known.dims]


def read_name(text: str, layers: tuple[str, ...], *, others: Iterable[str] = ()) -> Named:
    """Read the name of a quantity.

    Parameters
    ----------
    text : str
        What is taken, a signal, and of a field or displacement the layer: ``"peak field in gap"``. Words of a signal
        may be joined by blanks.
    layers : tuple of str
        There are.
    others : iterable of str
        Quantities that are known elsewhere, for the message.

    Returns
    -------
    Named
        Of a signal that the nomenclature has.

    Raises
    ------
    InputError
        With the nearest name.
    """
    head, _, where = text.strip().partition(" in ")
    taken, *rest = head.split() or [""]
    signal, layer = "_".join(rest), "_".join(where.split())
    if taken not in TAKEN:
        raise InputError(f"quantity '{text}': {_begin(text, taken, signal, others)}")
    if signal not in signals_over_time():
        raise InputError(
            f"quantity '{text}': '{signal}' is no signal over time.{nearest(signal, signals_over_time())}"
        )
    layered = "layer" in SIGNALS[signal].dims
    if layered != bool(layer) or (layer and layer not in layers):
        why = f"'{signal}' has no layers: leave 'in {layer}' away"
        if layered:
            why = f"name one layer, '{taken} {signal} in {layers[0]}'.{nearest(layer, layers)}"
        raise InputError(f"quantity '{text}': {why}")
    return Named(taken, signal, layer)


def _begin(text: str, taken: str, signal: str, others: Iterable[str]) -> str:
    """Say how the name of a quantity begins, and which is meant."""
    meant = closest(text, others)
    if meant is None:
        known = next(
            (name for name in (signal, f"{taken}_{signal}", taken) if name in signals_over_time()), ""
        )
        meant = f"{closest(taken, TAKEN) or 'peak'} {known}" if known else closest(text, _every())
    if meant is not None:
        return f"it begins with none of {', '.join(TAKEN)}. Did you mean '{meant}'?"
    listed = ", ".join(f"{name} ({words})" for name, words in TAKEN.items())
    return f"expected one of {listed}, and a signal, for instance '{DEFAULTS[1]}'"


def _every() -> list[str]:
    return [f"{taken} {signal}" for taken in TAKEN for signal in signals_over_time()]
