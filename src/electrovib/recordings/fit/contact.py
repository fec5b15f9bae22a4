"""Roughness and modulus of a contact from its capacitance over the load, so that its forces are predicted.

Without attraction a rough contact on a homogeneous body has no scale of its own: its gaps over the rms height follow from the
pressure over E* rms/longest, E* = E/(1 - nu^2). One table of contacts under `REDUCED_LOADS`, solved once, therefore serves every
rms height and modulus.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.arrays import Real
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.marks import Form, csv_text
from electrovib.physics.half_space import Elastic
from electrovib.physics.topography import SelfAffine
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.interval import Interval
from electrovib.scenario import Source, read_scenario
from electrovib.solve.diagnostics.judge import declared_diagnostics
from electrovib.solve.equilibrium.of_scenario import BlockingStack, uniform_stack
from electrovib.solve.rough_contact import Loaded

REDUCED_LOADS: Final = np.geomspace(1e-4, 1e2, 31)
"""Pressures over E* rms/longest: from a few summits that touch to a contact that is nearly closed."""
KEPT: Final = 1 << 16
"""Gaps that are kept of each contact, in order of size."""
FEWEST: Final = 3
METHOD: Final = "Student's t over the scatter of the capacitances"


@dataclass(frozen=True, kw_only=True, repr=False)
class ContactFit(Answer):
    """Roughness and body of a contact, whose capacitances over the load agree best with measured ones.

    Parameters
    ----------
    roughness : SelfAffine
        The declared spectrum with the fitted rms height.
    body : Elastic
        The fitted modulus, with the declared Poisson's ratio.
    rms, modulus : Interval
        Rms height [m] and Young's modulus [Pa], with 95 % intervals.
    load, capacitance, fitted : ndarray, shape (n,)
        Loads [N] in rising order, measured and fitted capacitances [F].
    scatter : float
        Standard deviation of the logarithm of measured over fitted capacitances [1].
    stack : BlockingStack
        Area and layers of the capacitance.
    diagnostics : tuple of Diagnostic
        Of what the scenario declares.
    """

    FILES: ClassVar = {"contact.csv": Form.TABLE}
    roughness: SelfAffine
    body: Elastic
    rms: Interval
    modulus: Interval
    load: Real
    capacitance: Real
    fitted: Real
    scatter: float
    stack: BlockingStack
    diagnostics: tuple[Diagnostic, ...]

    @property
    def document(self) -> Document:
        """Both numbers with their intervals, a row for each load, and the capacitance over the load."""
        columns = zip(self.load, self.capacitance, self.fitted, strict=True)
        rows = [
            (_shown(load, "N"), _shown(measured, "F"), _shown(fitted, "F"), f"{measured / fitted:.3f}")
            for load, measured, fitted in columns
        ]
        return Document(
            title="A rough contact from its capacitance over the load",
            sentences=[
                f"rms height of the roughness {self.rms.in_words('m')}",
                f"Young's modulus {self.modulus.in_words('Pa')}",
                f"the capacitances scatter by {100 * self.scatter:.2g} % about those of this contact",
            ],
            numbers=[Table("", ("load", "measured", "fitted", "measured over fitted"), tuple(rows))],
            diagnostics=self.diagnostics,
            figures=[
                Panel(
                    id="capacitance", title="Capacitance over the load", x=("load", "N"), y=("capacitance", "F"), log_x=True,
                    caption="Measured, and of the rough contact with the fitted rms height and modulus.",
                    curves=(
                        Curve(label="measured", x=self.load, y=self.capacitance, kind="points"),
                        Curve(label="fitted", x=self.load, y=self.fitted),
                    ),
                )
            ],
            remarks=[
                "the intervals are those of a body, a spectrum and random phases as declared. Other phases give other numbers,"
                " less so where the longest wavelength is many times that of the roll-off, and loads of one run that err together"
                " make the intervals wider: repeat with another seed, and predict with both",
                *reasons(self.diagnostics),
            ],
        )  # fmt: skip

    def content(self, name: str) -> str:
        """Write loads, measured and fitted capacitances as CSV, in SI, below both numbers with their intervals."""
        del name
        rows = np.column_stack([self.load, self.capacitance, self.fitted]).tolist()
        return csv_text(("load", "capacitance", "fitted"), rows, remarks=self.document.sentences)


def fit_contact(
    scenario: Source,
    *,
    load: ArrayLike,
    capacitance: ArrayLike,
    roughness: SelfAffine,
    body: Elastic,
    points: int | None = None,
    seed: int = 0,
) -> ContactFit:
    """Find rms height and modulus of a rough contact from its capacitance over the load.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `rough_contact`: contact area, and a stack with a gap that does not conduct. Load, drive and the thickness of the
        gap have no effect.
    load : array_like, shape (n,)
        Loads [N] above 0 at which the capacitance was measured, at least 3.
    capacitance : array_like, shape (n,)
        Capacitance of the contact at each [F], measured with a voltage that does not attract, without that of the leads.
    roughness : SelfAffine
        Shape of the spectrum. The search begins with its rms height.
    body : Elastic
        Poisson's ratio. The search begins with its modulus.
    points : int, optional
        Points along a side of the grid, as for `rough_contact`.
    seed : int, optional
        Of the random phases of the roughness. Predict with the same.

    Returns
    -------
    ContactFit
        `roughness` and `body`, which `rough_contact` takes, and the intervals of both numbers.

    Raises
    ------
    InputError
        If a capacitance is above that of the layers alone, the data do not determine both numbers, or the scenario is one that
        `rough_contact` refuses.

    Notes
    -----
    Least squares of the logarithms, so that errors are taken as proportional to the capacitance. The capacitance is
    eps0 A mean(1/(g + K)) with the local gap g and the electrical thickness K of the layers. Gaps of 31 contacts are
    interpolated over the logarithm of the load, to 2 % of both numbers. Forces predicted from the contact depend on the
    ratios of the wavelengths alone.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    >>> found = ev.fit_contact(
    ...     "bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e6), load=[0.1, 0.3, 1.0, 3.0],
    ...     capacitance=[255e-12, 280e-12, 330e-12, 420e-12],
    ... )
    >>> forces = ev.rough_contact("bau_2010/sine", roughness=found.roughness, body=found.body, voltage=[50.0]).force
    """
    known = read_scenario(scenario)
    stack = uniform_stack(known)
    loads, measured = _points(load, capacitance, stack)
    pressure, longest = loads / stack.area, roughness.longest
    table = _solved(roughness, body, points, seed)
    scale = eps0 * stack.filling * stack.area

    def logarithm(at: Mapping[str, float]) -> tuple[Real, Real, Real]:
        """Logarithm of the capacitance, its derivative after that of the load, and after the rms height."""
        rms = at["rms"]
        value, *slopes = table.inverse(np.log(pressure / at["stiffness"]), stack.electrical_thickness / rms)
        reach = -slopes[1] * stack.electrical_thickness / rms**2
        return value + math.log(scale / rms), slopes[0], reach - 1 / rms

    def derivatives(at: Mapping[str, float]) -> Real:
        _, over_load, over_rms = logarithm(at)
        return np.column_stack([over_rms, -over_load / at["stiffness"]])

    low, high = pressure.max() / REDUCED_LOADS[-1], pressure.min() / REDUCED_LOADS[0]
    if not low < high:
        raise InputError(
            f"load: from {loads[0]:g} to {loads[-1]:g} N; omit loads until they span less than a factor of 1e6"
        )
    unit = _stiffness(body, roughness.rms, longest)
    free = {
        "rms": FreeParameter(start=roughness.rms, logarithmic=True),
        "stiffness": FreeParameter(start=min(max(unit, low), high), lower=low, upper=high, logarithmic=True),
    }
    estimate = least_squares(
        lambda at: logarithm(at)[0] - np.log(measured), free, derivatives=derivatives, noise_is_known=False
    )
    rms, modulus = _intervals(estimate, body, longest)
    return ContactFit(
        roughness=replace(roughness, rms=rms.value),
        body=replace(body, modulus=modulus.value),
        rms=rms,
        modulus=modulus,
        load=loads,
        capacitance=measured,
        fitted=np.exp(logarithm(estimate.values)[0]),
        scatter=math.sqrt(estimate.variance),
        stack=stack,
        diagnostics=tuple(declared_diagnostics(known)),
    )


def _points(load: ArrayLike, capacitance: ArrayLike, stack: BlockingStack) -> tuple[Real, Real]:
    """Return loads in rising order and their capacitances, of at least three points, each below that without a gap."""
    loads, measured = (np.asarray(each, dtype=float) for each in (load, capacitance))
    if loads.ndim != 1 or loads.shape != measured.shape or loads.size < FEWEST:
        raise InputError(
            f"load, capacitance: expected two rows of the same length, at least {FEWEST}, not of the shapes {loads.shape} and"
            f" {measured.shape}"
        )
    for name, values, unit in (("load", loads, "N"), ("capacitance", measured, "F")):
        if wrong := [each for each in values.tolist() if not 0 < each < math.inf]:
            raise InputError(
                f"{name}: {wrong[0]:g} {unit} is not finite and above 0; omit the point, or subtract the zero"
            )
    closed = stack.capacitance(0.0)
    if measured.max() >= closed:
        raise InputError(
            f"capacitance: {_shown(measured.max(), 'F')} is not below {_shown(closed, 'F')}, that of {', '.join(stack.blocking)}"
            f" on {_shown(stack.area, 'm2')} without a gap; check contact.area and stack, and subtract the leads"
        )
    order = np.argsort(loads)
    return loads[order], measured[order]


def _stiffness(body: Elastic, rms: float, longest: float) -> float:
    """Return the unit of pressure E* rms/longest [Pa]."""
    return body.modulus / (1 - body.poisson**2) * rms / longest


class _Solved(NamedTuple):
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


def _solved(roughness: SelfAffine, body: Elastic, points: int | None, seed: int) -> _Solved:
    count, period = roughness.points(points), roughness.longest
    heights = roughness.heights((count, count), (period, period), seed=seed)
    unit, step = _stiffness(body, roughness.rms, period), max(1, count**2 // KEPT)

    def gaps(load: float) -> Real:
        loaded = Loaded(
            heights=heights, periods=(period, period), compliance=body.compliance, pressure=load * unit
        )
        found: Real = np.sort(loaded.rest().gap, axis=None)[step // 2 :: step] / roughness.rms
        return found

    return _Solved(np.stack([gaps(load) for load in REDUCED_LOADS.tolist()]))


def _intervals(estimate: LeastSquaresEstimate, body: Elastic, longest: float) -> tuple[Interval, Interval]:
    """Return rms height and modulus with their intervals, or refuse data that do not determine them."""
    why = estimate.why_no_covariance
    if side := estimate.on_bound.get("stiffness"):
        why = f"they agree best with a contact that is {'nearly closed' if side == 'lower' else 'hardly touched'} at every load"
    if why or not estimate.converged:
        raise InputError(
            f"load, capacitance: they do not determine rms height and modulus: {why or 'the search did not end'}; measure over"
            " more loads, or check contact.area, stack, and what was subtracted for the leads"
        )
    rms, stiffness = estimate.values["rms"], estimate.values["stiffness"]
    modulus = stiffness * (1 - body.poisson**2) * longest / rms
    found = (
        estimate.parameter("rms"),
        estimate.derived(modulus, {"rms": -modulus / rms, "stiffness": modulus / stiffness}),
    )
    first, second = (replace(each, method=METHOD).above(0.0) for each in found)
    return first, second


def _shown(value: float, unit: str) -> str:
    return format_quantity(float(value), unit, digits=4)
