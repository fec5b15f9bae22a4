"""Search for the rms height and modulus whose rough contact has measured capacitances over the load.

Without attraction a rough contact has no scale of its own: its gaps over the rms height follow from the pressure over that which
bends the longest wave by the rms height. One table of contacts under `REDUCED_LOADS`, solved once, therefore serves every rms
height, and every modulus of a body whose parts keep the ratio of theirs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np

from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.topography import MeasuredHeights, SelfAffine
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.interval import Interval, student
from electrovib.solve.rough_contact import Loaded
from electrovib.solve.stack.blocking import BlockingStack

REDUCED_LOADS: Final = np.geomspace(1e-4, 1e2, 31)
"""Pressures over `_stiffness`: from a few summits that touch to a contact that is nearly closed."""
KEPT: Final = 1 << 16
"""Gaps that are kept of each contact, in order of size."""
METHOD: Final = "Student's t over the scatter of the capacitances"
FREE: Final = ("rms", "modulus")
"""What can be fitted."""


class ReducedContacts(NamedTuple):
    """Gaps over the rms height under each of `REDUCED_LOADS`, shape (loads, places)."""

    gaps: Real

    def inverse(self, at: Real, reach: float) -> tuple[Real, Real, Real]:
        """Logarithm of mean(1/(gap + reach)) at logarithms of the load, its derivatives after `at` and `reach`."""
        from scipy.interpolate import CubicSpline

        near = 1 / (self.gaps + reach)
        mean = near.mean(1)
        value, slope = (
            CubicSpline(np.log(REDUCED_LOADS), each) for each in (np.log(mean), -(near**2).mean(1) / mean)
        )
        return value(at), value(at, 1), slope(at)


def solved(
    roughness: SelfAffine | MeasuredHeights, body: Elastic | Coated, shape: tuple[int, int], seed: int
) -> ReducedContacts:
    """Solve the contact under each of `REDUCED_LOADS`, on a grid of a shape, with one draw of the phases."""
    periods, rms = roughness.periods, roughness.rms
    heights = roughness.heights(shape, periods, seed=seed)
    unit, step = _stiffness(body, roughness), max(1, heights.size // KEPT)

    def gaps(load: float) -> Real:
        loaded = Loaded(heights=heights, periods=periods, compliance=body.compliance, pressure=load * unit)
        found: Real = np.sort(loaded.rest().gap, axis=None)[step // 2 :: step] / rms
        return found

    return ReducedContacts(np.stack([gaps(load) for load in REDUCED_LOADS.tolist()]))


def best_contact(
    loads: Real,
    measured: Real,
    stack: BlockingStack,
    table: ReducedContacts,
    roughness: SelfAffine | MeasuredHeights,
    body: Elastic | Coated,
    fitted: tuple[str, ...],
) -> tuple[LeastSquaresEstimate, Real]:
    """Return rms height and stiffness that agree best with the capacitances for one draw, and the fitted capacitances [F]."""
    pressure, scale = loads / stack.area, eps0 * stack.filling * stack.area
    unit = _stiffness(body, roughness)
    low, high = pressure.max() / REDUCED_LOADS[-1], pressure.min() / REDUCED_LOADS[0]
    if not low < high:
        raise InputError(
            f"load: from {loads[0]:g} to {loads[-1]:g} N; omit loads until they span less than a factor of 1e6"
        )
    stiffness = FreeParameter(start=min(max(unit, low), high), lower=low, upper=high, logarithmic=True)
    bounded = {name: roughness.rms / unit * getattr(stiffness, name) for name in ("start", "lower", "upper")}
    free = {
        FREE: {"rms": FreeParameter(start=roughness.rms, logarithmic=True), "stiffness": stiffness},
        FREE[1:]: {"stiffness": stiffness},
        FREE[:1]: {"rms": FreeParameter(**bounded, logarithmic=True)},
    }[fitted]

    def logarithm(at: Mapping[str, float]) -> tuple[Real, Real]:
        """Logarithm of the capacitance, and its derivatives after what is free; with a known modulus stiffness follows rms."""
        rms = at.get("rms", roughness.rms)
        stiff = at.get("stiffness", unit * rms / roughness.rms)
        value, *slopes = table.inverse(np.log(pressure / stiff), stack.electrical_thickness / rms)
        reach = -slopes[1] * stack.electrical_thickness / rms**2
        over_rms = reach - 1 / rms - (0.0 if "stiffness" in at else slopes[0] / rms)
        columns = {"rms": over_rms, "stiffness": -slopes[0] / stiff}
        return value + math.log(scale / rms), np.column_stack([columns[name] for name in free])

    estimate = least_squares(
        lambda at: logarithm(at)[0] - np.log(measured),
        free,
        derivatives=lambda at: logarithm(at)[1],
        noise_is_known=False,
    )
    return estimate, np.exp(logarithm(estimate.values)[0])


def intervals(
    estimate: LeastSquaresEstimate, body: Elastic | Coated, roughness: SelfAffine | MeasuredHeights
) -> tuple[Interval, Interval]:
    """Return rms height and modulus with their intervals, or refuse data that do not determine them."""
    why = estimate.why_no_covariance
    if side := next(iter(estimate.on_bound.values()), ""):
        why = f"they agree best with a contact that is {'nearly closed' if side == 'lower' else 'hardly touched'} at every load"
    if why or not estimate.converged:
        raise InputError(
            f"load, capacitance: they do not determine rms height and modulus: {why or 'the search did not end'}; measure over"
            " more loads, or check contact.area, stack, and what was subtracted for the leads"
        )
    known, values = _modulus(body), estimate.values
    rms = estimate.parameter("rms") if "rms" in values else _declared(roughness.rms)
    modulus = _declared(known)
    if stiffness := values.get("stiffness"):
        value = known * (stiffness / _stiffness(body, roughness)) * (roughness.rms / rms.value)
        modulus = estimate.derived(value, {"rms": -value / rms.value, "stiffness": value / stiffness})
    first, second = (
        replace(each, method=METHOD).above(0.0) if each.standard_error else each for each in (rms, modulus)
    )
    return first, second


def _declared(value: float) -> Interval:
    return Interval(value=value, lower=value, upper=value, standard_error=0.0, method="as declared")


def over_draws(each: Sequence[Interval], freedom: int) -> Interval:
    """Return the geometric mean of a number over draws, with the interval of one draw more and of noise; one keeps its own."""
    if len(each) == 1:
        return each[0]
    logarithms = np.log([one.value for one in each])
    noise = float(np.mean([(one.standard_error / one.value) ** 2 for one in each]))
    between = float(logarithms.var(ddof=1)) * (1 + 1 / len(each))
    variance = noise + between
    degrees = variance**2 / (noise**2 / freedom + between**2 / (len(each) - 1)) if variance else math.inf
    value, half = math.exp(logarithms.mean()), student(degrees) * math.sqrt(variance)
    return Interval(
        value=value,
        lower=value * math.exp(-half),
        upper=value * math.exp(half),
        standard_error=value * math.sqrt(variance),
        scatter=value * float(logarithms.std(ddof=1)),
        count=len(each),
        method=f"noise, and {len(each)} draws of the phases",
    )


def with_rms(roughness: SelfAffine | MeasuredHeights, rms: float) -> SelfAffine | MeasuredHeights:
    """Return the same roughness with another rms height [m]."""
    if isinstance(roughness, SelfAffine):
        return roughness.replace({"rms": rms})
    return MeasuredHeights(values=roughness.level() * (rms / roughness.rms), spacing=roughness.spacing)


def with_modulus(body: Elastic | Coated, modulus: float) -> Elastic | Coated:
    """Return a body with another modulus [Pa]; of a coated one the moduli keep their ratio."""
    if isinstance(body, Elastic):
        return body.replace({"modulus": modulus})
    below = body.below.modulus * modulus / body.film.modulus
    return body.replace({"film.modulus": modulus, "below.modulus": below})


def _modulus(body: Elastic | Coated) -> float:
    return (body if isinstance(body, Elastic) else body.film).modulus


def _stiffness(body: Elastic | Coated, roughness: SelfAffine | MeasuredHeights) -> float:
    """Return the unit of pressure [Pa]; it bends the longest wave by the rms height over pi: E* rms/longest of a half-space."""
    softness = body.compliance(2 * math.pi / max(roughness.periods))
    return roughness.rms / (math.pi * float(softness))
