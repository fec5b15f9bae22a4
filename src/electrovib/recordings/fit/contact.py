"""Roughness and modulus of a contact from its capacitance over the load, so that its forces are predicted.

Without attraction a rough contact on a homogeneous body has no scale of its own: its gaps over the rms height follow from the
pressure over E* rms/longest, E* = E/(1 - nu^2). One table of contacts under `REDUCED_LOADS`, solved once, therefore serves every
rms height and modulus.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.half_space import Elastic
from electrovib.physics.limits import held_voltages
from electrovib.physics.topography import SelfAffine
from electrovib.recordings.fit.contact_prediction import ContactPrediction, FittedDraw
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.interval import Interval, student
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.solve.diagnostics.judge import declared_diagnostics
from electrovib.solve.equilibrium.of_scenario import closed_diagnostics
from electrovib.solve.rough_contact import Loaded, refuse_beyond_budget
from electrovib.solve.stack.blocking import BlockingStack, uniform_stack

REDUCED_LOADS: Final = np.geomspace(1e-4, 1e2, 31)
"""Pressures over E* rms/longest: from a few summits that touch to a contact that is nearly closed."""
KEPT: Final = 1 << 16
"""Gaps that are kept of each contact, in order of size."""
FEWEST: Final = 3
MOST_DRAWS: Final = 32
METHOD: Final = "Student's t over the scatter of the capacitances"


@dataclass(frozen=True, kw_only=True, repr=False)
class ContactFit(Answer):
    """Roughness and body of a contact, whose capacitances over the load agree best with measured ones.

    Parameters
    ----------
    draws : tuple of FittedDraw
        Of each draw of the phases its ``seed``, the ``roughness``, the declared spectrum with the fitted rms height, and the
        ``body``, the fitted modulus with the declared Poisson's ratio. All agree with the capacitances; forces are predicted
        with each.
    rms, modulus : Interval
        Rms height [m] and Young's modulus [Pa], with 95 % intervals; of several draws the geometric mean.
    load, capacitance, fitted : ndarray, shape (n,)
        Loads [N] in rising order, measured and fitted capacitances [F], the latter of the first draw.
    scatter : float
        Standard deviation of the logarithm of measured over fitted capacitances [1], of the first draw.
    scenario : Scenario
        Area and layers of the capacitance.
    points : int or None
        Points along a side of the grid, None for as few as the shortest wave takes.
    diagnostics : tuple of Diagnostic
        Of what the scenario declares.
    """

    FILES: ClassVar = {"contact.csv": Form.TABLE}
    draws: tuple[FittedDraw, ...]
    rms: Interval
    modulus: Interval
    load: Real
    capacitance: Real
    fitted: Real
    scatter: float
    scenario: Scenario
    points: int | None
    diagnostics: tuple[Diagnostic, ...]

    @property
    def roughness(self) -> SelfAffine:
        """Roughness of the first draw."""
        return self.draws[0].roughness

    @property
    def body(self) -> Elastic:
        """Body of the first draw."""
        return self.draws[0].body

    def predict(
        self, *, voltage: ArrayLike, load: float | None = None, measured: ArrayLike | None = None
    ) -> ContactPrediction:
        """Predict the attraction over voltage, with every draw of the phases and without a free number.

        Parameters
        ----------
        voltage : array_like, shape (n,)
            Constant voltages [V] that the contact goes through in this order, not 0; for a fast sine the root mean square.
        load : float, optional
            Load [N] above 0; that of the scenario if absent.
        measured : array_like, shape (n,), optional
            Measured attraction at each voltage [N], with which the prediction is compared.

        Returns
        -------
        ContactPrediction
            The force at each voltage by each draw, and how far it is from the measured one.

        Raises
        ------
        InputError
            If a voltage is 0 or beyond 1 MV, a measured force is not above 0, or the contacts are beyond the budget.
        ElectrovibError
            If a contact does not come to rest, which the message explains.

        Notes
        -----
        Each draw is solved as `electrovib.rough_contact` does, on one grid. Limits are not judged before the force is predicted,
        as nothing is played; films, air and declared limits are in the diagnostics.
        """
        changes = {} if load is None else {"load.normal_force": load}
        known = self.scenario.replace(changes)
        stack = uniform_stack(known)
        voltages = held_voltages(voltage)
        seen = None if measured is None else np.atleast_1d(np.asarray(measured, dtype=float))
        _check_prediction(stack, voltages, seen)
        count = self.roughness.points(self.points)
        refuse_beyond_budget(count, len(self.draws) * voltages.size, kept=voltages.size)
        found = [each.attractions(stack, voltages.tolist(), count) for each in self.draws]
        return ContactPrediction(
            stack=stack,
            voltage=voltages,
            forces=stack.area * np.array([pulls for pulls, _ in found]),
            measured=seen,
            diagnostics=closed_diagnostics(
                known,
                stack,
                voltage=float(np.abs(voltages).max()),
                widest=max(widest for _, widest in found),
            ),
        )

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
                "the intervals are those of the declared body and spectrum; loads of one run that err together make them wider",
                "the phases of the roughness are not known. "
                + (
                    f"The intervals include what {len(self.draws)} draws of them differ by"
                    if len(self.draws) > 1
                    else "The intervals are those of one draw of them, and others give other numbers: ask for more draws"
                ),
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
    draws: int = 4,
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
    draws : int, optional
        Draws of the random phases of the roughness, at most 32, each with a fit of its own: the intervals include what they
        differ by. With one they are too narrow.
    seed : int, optional
        Of the phases of the first draw; the others have the seeds that follow.

    Returns
    -------
    ContactFit
        The intervals of both numbers; roughness and body of each draw, which `rough_contact` takes; and `predict`, the force at
        other voltages.

    Raises
    ------
    InputError
        If a capacitance is above that of the layers alone, the data do not determine both numbers, the contacts are beyond the
        budget, or the scenario is one that `rough_contact` refuses.

    Notes
    -----
    Least squares of the logarithms, so that errors are taken as proportional to the capacitance. The capacitance is
    eps0 A mean(1/(g + K)) with the local gap g and the electrical thickness K of the layers. Gaps of 31 contacts are
    interpolated over the logarithm of the load, to 2 % of both numbers. Forces predicted from the contact depend on the
    ratios of the wavelengths alone. Between draws the variance of a logarithm is s^2 (1 + 1/n), as the real contact is one draw
    more, to which that of the noise is added; Student's t has the degrees of freedom of Welch and Satterthwaite.

    Examples
    --------
    >>> rough = ev.SelfAffine(rms=2e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    >>> found = ev.fit_contact(
    ...     "bau_2010/sine", roughness=rough, body=ev.Elastic(modulus=1e6), load=[0.1, 0.3, 1.0, 3.0],
    ...     capacitance=[255e-12, 280e-12, 330e-12, 420e-12],
    ... )
    >>> found.predict(voltage=[25.0, 50.0]).forces.shape
    (4, 2)
    """
    known = read_scenario(scenario)
    stack = uniform_stack(known)
    loads, measured = _points(load, capacitance, stack)
    if not 1 <= draws <= MOST_DRAWS:
        raise InputError(f"draws = {draws}: expected 1 to {MOST_DRAWS}, for instance 4")
    refuse_beyond_budget(roughness.points(points), draws * REDUCED_LOADS.size)
    estimates, fitted, found = [], [], []
    for each in range(seed, seed + draws):
        estimate, values = _estimate(
            loads, measured, stack, _solved(roughness, body, points, each), roughness, body
        )
        rms, modulus = _intervals(estimate, body, roughness.longest)
        found.append(
            FittedDraw(each, roughness.replace({"rms": rms.value}), body.replace({"modulus": modulus.value}))
        )
        estimates.append((estimate, rms, modulus))
        fitted.append(values)
    freedom = loads.size - 2
    return ContactFit(
        draws=tuple(found),
        rms=_over_draws([rms for _, rms, _ in estimates], freedom),
        modulus=_over_draws([modulus for *_, modulus in estimates], freedom),
        load=loads,
        capacitance=measured,
        fitted=fitted[0],
        scatter=math.sqrt(estimates[0][0].variance),
        scenario=known,
        points=points,
        diagnostics=tuple(declared_diagnostics(known)),
    )


def _estimate(
    loads: Real, measured: Real, stack: BlockingStack, table: _Solved, roughness: SelfAffine, body: Elastic
) -> tuple[LeastSquaresEstimate, Real]:
    """Return rms height and stiffness that agree best with the capacitances for one draw, and the fitted capacitances [F]."""
    pressure, scale = loads / stack.area, eps0 * stack.filling * stack.area

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
    unit = _stiffness(body, roughness.rms, roughness.longest)
    free = {
        "rms": FreeParameter(start=roughness.rms, logarithmic=True),
        "stiffness": FreeParameter(start=min(max(unit, low), high), lower=low, upper=high, logarithmic=True),
    }
    estimate = least_squares(
        lambda at: logarithm(at)[0] - np.log(measured), free, derivatives=derivatives, noise_is_known=False
    )
    return estimate, np.exp(logarithm(estimate.values)[0])


def _over_draws(each: Sequence[Interval], freedom: int) -> Interval:
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


def _check_prediction(stack: BlockingStack, voltages: Real, measured: Real | None) -> None:
    """Refuse voltages and measured forces that have no logarithm, and a contact without a load."""
    if not stack.pressure > 0:
        raise InputError(
            "load.normal_force = 0: a rough contact rests under a load; give for instance load=0.5"
        )
    if not voltages.all():
        raise InputError(
            f"voltage = {voltages.tolist()}: 0 V attracts nothing; expected voltages other than 0"
        )
    if measured is not None and (measured.shape != voltages.shape or not (measured > 0).all()):
        raise InputError(
            f"measured = {measured.tolist()}: expected a force above 0 for each of the {voltages.size} voltages; omit voltages"
            " without one"
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
