"""The forms of dispersion that are offered to a measured spectrum, each with initial values from the data."""

from __future__ import annotations

import itertools
import math
import re
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.errors import InputError, nearest
from electrovib.physics.material import ColeCole, Constant, ConstantPhase, Debye, HavriliakNegami, Prony

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator

    from electrovib.core.arrays import Complex, Real
    from electrovib.physics.material import Material

_PLACES: Final = 5
"""Relaxation times, evenly on a logarithmic scale over the band, at which a search begins."""


def _levels(frequency: Real, permittivity: Complex) -> tuple[float, float, float]:
    """Relative permittivity at both ends of the band, and the least conductivity [S/m]."""
    order = np.argsort(frequency)
    real = permittivity.real[order]
    conductivity = -permittivity.imag * 2 * math.pi * frequency * eps0
    return max(float(real[-1]), 1.0), max(float(real[0]), 1.0), max(float(conductivity.min()), 1e-15)


def _times(frequency: Real) -> Real:
    shortest = 1 / (2 * math.pi * float(frequency.max()) * 3)
    longest = 1 / (2 * math.pi * float(frequency.min()) / 3)
    return np.geomspace(shortest, longest, _PLACES)


def _constant(frequency: Real, permittivity: Complex) -> Iterator[Material]:
    """A dielectric without dispersion, with the median of the permittivity and of the conductivity."""
    conductivity = -permittivity.imag * 2 * math.pi * frequency * eps0
    level = max(float(np.median(permittivity.real)), 1.0)
    yield Constant(permittivity=level, conductivity=max(float(np.median(conductivity)), 1e-15))


def _constant_phase(frequency: Real, permittivity: Complex) -> Iterator[Material]:
    """A power law, from the slope of the permittivity over the band."""
    middle = math.exp(float(np.mean(np.log(frequency))))
    slope = float(np.polyfit(np.log(frequency), np.log(np.maximum(permittivity.real, 1.0)), 1)[0])
    at_middle = float(np.exp(np.mean(np.log(np.maximum(permittivity.real, 1.0)))))
    least = _levels(frequency, permittivity)[2]
    for exponent in {min(max(1 + slope, 0.1), 0.99), 0.5, 0.8}:
        yield ConstantPhase(
            permittivity=at_middle, reference_frequency=middle, exponent=exponent, conductivity=least / 2
        )


def _one(
    kind: type[Debye | HavriliakNegami], share: float, **shape: float
) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make one relaxation, begun at several times, with a part of the permittivity at the highest frequency."""

    def starts(frequency: Real, permittivity: Complex) -> Iterator[Material]:
        high, low, least = _levels(frequency, permittivity)
        for time in _times(frequency):
            yield kind(
                permittivity_high=max(high * share, 1.0), strength=max(low - high, 0.1 * high),
                relaxation_time=float(time), conductivity=least / 2, **shape,
            )  # fmt: skip

    return starts


def _cole_cole(count: int) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make the sum of so many broadened relaxations, begun at several times."""

    def starts(frequency: Real, permittivity: Complex) -> Iterator[Material]:
        high, low, least = _levels(frequency, permittivity)
        strength = max(low - high, 0.1 * high) / count
        for times in itertools.combinations(_times(frequency), count):
            terms = [
                {"strength": strength, "relaxation_time": float(time), "broadening": 0.2} for time in times
            ]
            yield ColeCole(permittivity_high=max(high / 2, 1.0), terms=terms, conductivity=least / 2)

    return starts


def _prony(count: int) -> Callable[[Real, Complex], Iterator[Material]]:
    """Make the sum of so many relaxations of one time each, begun with times evenly over the band."""

    def starts(frequency: Real, permittivity: Complex) -> Iterator[Material]:
        high, low, least = _levels(frequency, permittivity)
        strength = max(low - high, 0.1 * high) / count
        band = _times(frequency)
        for inwards in (1.0, 3.0):
            times = np.geomspace(band[0] * inwards, band[-1] / inwards, count)
            terms = [{"strength": strength, "relaxation_time": float(time)} for time in times]
            yield Prony(permittivity_high=high, terms=terms, conductivity=least / 2)

    return starts


FORMS: Final[dict[str, Callable[[Real, Complex], Iterator[Material]]]] = {
    "Constant": _constant,
    "ConstantPhase": _constant_phase,
    "Debye": _one(Debye, 1.0),
    "ColeCole, 1 term": _cole_cole(1),
    "ColeCole, 2 terms": _cole_cole(2),
    "HavriliakNegami": _one(HavriliakNegami, 0.5, broadness=0.8, skewness=0.8),
    "ColeCole, 3 terms": _cole_cole(3),
    "ColeCole, 4 terms": _cole_cole(4),
    "Prony, 2 terms": _prony(2),
    "Prony, 3 terms": _prony(3),
    "Prony, 4 terms": _prony(4),
    "Prony, 6 terms": _prony(6),
}
"""Name to initial values; the search keeps the best of them."""
OFFERED: Final = tuple(FORMS)[:6]
"""Forms among which the criterion chooses unless others are named."""


GABRIEL: Final = "gabriel"


def _command_name(form: str) -> tuple[str, str]:
    """Return the name of a form for a command, ``cole-cole``, and its number of terms as text."""
    name, _, terms = form.partition(",")
    kebab = re.sub(r"(?<=[a-z])(?=[A-Z])", "-", name).lower()
    return kebab, terms.strip().partition(" ")[0]


def forms_of(name: str) -> tuple[str, ...]:
    """Return the names among `FORMS` that a short name stands for, between which the criterion of Akaike decides.

    It is ``auto``, the name of a form such as ``cole-cole``, with any number of terms, that with a number of
    terms such as ``cole-cole-2``, or ``gabriel`` for four Cole-Cole terms.
    """
    known: dict[str, tuple[str, ...]] = {"auto": OFFERED}
    for form in FORMS:
        kebab, terms = _command_name(form)
        known[kebab] = (*known.get(kebab, ()), form)
        if terms:
            known[f"{kebab}-{terms}"] = (form,)
    known[GABRIEL] = known["cole-cole-4"]
    if name not in known:
        raise InputError(f"form = '{name}': no form of dispersion.{nearest(name, known)}")
    return known[name]
