"""A contact known by its capacitance: from its impedance, searched over the load, and the force over voltage that it predicts.

Without attraction a rough contact has no scale of its own: its gaps over the rms height follow from the pressure over that which
bends the longest wave by the rms height. One table of contacts under `REDUCED_LOADS`, solved once, therefore serves every rms
height, and every modulus of a body whose parts keep the ratio of theirs.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import ClassVar, Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.arrays import Complex, Real
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, csv_text
from electrovib.physics.half_space import Coated, Elastic
from electrovib.physics.topography import MeasuredHeights, SelfAffine
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate, least_squares
from electrovib.recordings.interval import Interval, student
from electrovib.scenario import Source, read_scenario
from electrovib.solve.rough_contact import Loaded, follow_voltages, words_of_spots
from electrovib.solve.stack.blocking import BlockingStack, uniform_stack

MISSED: Final = 0.1
"""Relative root mean square of the impedance that layers and gap miss, beyond which they are not what was measured."""


def contact_capacitance(scenario: Source, *, frequency: ArrayLike, impedance: Complex) -> Real:
    """Find the capacitance of film and gap from impedances over frequency, such as one spectrum at each of some loads.

    Parameters
    ----------
    scenario : str, Path, mapping, Scenario or xarray.Dataset
        As for `rough_contact`: the layers in series with the gap, such as film and skin, the area, and the resistances of
        amplifier and return path. The thickness of the gap has no effect.
    frequency : array_like, shape (n,)
        Frequencies [Hz], above 0.
    impedance : ndarray, shape (loads, n) or (n,), complex
        Impedance of the whole series at each [ohm], that of the leads subtracted: real part R, imaginary part below 0 for a
        capacitor.

    Returns
    -------
    capacitance : ndarray, shape (loads,) or ()
        Capacitance of gap and blocking layers [F], which `fit_contact` takes.

    Raises
    ------
    InputError
        If the impedance leaves nothing for a gap, misses layers and gap by more than 10 %, or the scenario is one that
        `rough_contact` refuses.

    Notes
    -----
    Z = R + sum of T/(j w eps0 eps* A) over the layers + G/(j w eps0 eps_gap A). The gap G of plates is fitted to all frequencies
    by least squares of the deviation over the modulus; the capacitance is eps0 eps_gap A/(G + K) with the electrical thickness
    K of the layers that block. So a film may have a loss and a skin its dispersion. Skin is in series with the whole contact,
    which holds while its impedance is small beside that of the gap.

    Examples
    --------
    >>> pad = ev.run("bau_2010/sine", set={"stack.gap.thickness": "2 um"})
    >>> f"{ev.contact_capacitance(pad, frequency=pad.frequency, impedance=pad.impedance):.4g}"
    '3.924e-10'
    """
    known = read_scenario(scenario)
    stack, gap = uniform_stack(known), known.stack.gap_name
    grid, measured = _spectra(frequency, impedance)
    series = known.circuit.element().impedance(grid)
    for name, layer in known.stack.layers.items():
        series = series + (0.0 if name == gap else layer.impedance(grid) / stack.area)
    of_gap = 1 / (2j * math.pi * grid * eps0 * stack.filling * stack.area)
    weight = 1 / np.abs(measured)
    left = measured - series
    width = np.sum((left * of_gap.conj()).real * weight**2, -1) / np.sum(np.abs(of_gap * weight) ** 2, -1)
    missed = np.sqrt(np.mean(np.abs((left - width[..., None] * of_gap) * weight) ** 2, -1))
    for at, (each, error) in enumerate(zip(np.atleast_1d(width), np.atleast_1d(missed), strict=True)):
        if error > MISSED:
            raise InputError(
                f"impedance[{at}]: layers and a gap miss it by {100 * error:.2g} % of its modulus, more than {100 * MISSED:g} %;"
                " check stack, circuit and contact.area, or omit frequencies at which leads or skin count more than the gap"
            )
        if not each > 0:
            raise InputError(
                f"impedance[{at}]: its gap would be {format_quantity(float(each), 'm')}: the layers alone have a larger"
                " impedance; check stack and contact.area, and subtract the leads"
            )
    return np.asarray(eps0 * stack.filling * stack.area / (width + stack.electrical_thickness))


def _spectra(frequency: ArrayLike, impedance: Complex) -> tuple[Real, Complex]:
    """Return frequencies and impedances that have a size each, or refuse them."""
    grid, measured = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or measured.ndim not in (1, 2) or measured.shape[-1:] != grid.shape or not grid.size:
        raise InputError(
            f"frequency, impedance: expected a row of frequencies, and an impedance at each in a row for each load, not of the"
            f" shapes {grid.shape} and {measured.shape}"
        )
    if not (np.isfinite(grid).all() and (grid > 0).all()):
        raise InputError("frequency: expected finite numbers above 0 Hz")
    if not (np.isfinite(measured).all() and (measured != 0).all()):
        raise InputError("impedance: expected finite numbers other than 0 ohm; omit frequencies without one")
    return grid, measured


REDUCED_LOADS: Final = np.geomspace(1e-4, 1e2, 31)
"""Pressures over `_stiffness`: from a few summits that touch to a contact that is nearly closed."""
KEPT: Final = 1 << 16
"""Gaps that are kept of each contact, in order of size."""
METHOD: Final = "Student's t over the scatter of the capacitances"
FREE: Final = ("rms", "modulus")
"""What can be fitted."""


def _inverse(gaps: Real, at: Real, reach: float) -> tuple[Real, Real, Real]:
    """Logarithm of mean(1/(gap + reach)) at logarithms of the load, its derivatives after `at` and `reach`."""
    from scipy.interpolate import CubicSpline

    near = 1 / (gaps + reach)
    mean = near.mean(1)
    value, slope = (
        CubicSpline(np.log(REDUCED_LOADS), each) for each in (np.log(mean), -(near**2).mean(1) / mean)
    )
    return value(at), value(at, 1), slope(at)


def solved(
    roughness: SelfAffine | MeasuredHeights, body: Elastic | Coated, shape: tuple[int, int], seed: int
) -> Real:
    """Solve the contact under each of `REDUCED_LOADS`, on a grid of a shape, with one draw of the phases."""
    periods, rms = roughness.periods, roughness.rms
    heights = roughness.heights(shape, periods, seed=seed)
    unit, step = _stiffness(body, roughness), max(1, heights.size // KEPT)

    def gaps(load: float) -> Real:
        loaded = Loaded(heights=heights, periods=periods, compliance=body.compliance, pressure=load * unit)
        found: Real = np.sort(loaded.rest().gap, axis=None)[step // 2 :: step] / rms
        return found

    return np.stack([gaps(load) for load in REDUCED_LOADS.tolist()])


def best_contact(
    loads: Real,
    measured: Real,
    stack: BlockingStack,
    table: Real,
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
        value, *slopes = _inverse(table, np.log(pressure / stiff), stack.electrical_thickness / rms)
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


class FittedDraw(NamedTuple):
    """One draw of the phases, or a measured map, with the roughness and the body that agree best with the capacitances."""

    seed: int
    roughness: SelfAffine | MeasuredHeights
    body: Elastic | Coated

    def attractions(
        self, stack: BlockingStack, voltages: Sequence[float], shape: tuple[int, int], share: float
    ) -> tuple[list[float], float]:
        """Return the attraction [Pa] at each voltage [V] in this order, and the widest gap [m].

        On a grid of the shape, spots having that share of the field of insulating ones.
        """
        periods = self.roughness.periods
        loaded = Loaded(
            heights=self.roughness.heights(shape, periods, seed=self.seed),
            periods=periods,
            compliance=self.body.compliance,
            pressure=stack.pressure,
        )
        rests = follow_voltages(loaded, voltages, electrical_thickness=stack.electrical_thickness)
        pulls = [rest.with_field_share(share).mean_attraction for rest in rests]
        return pulls, max(float(rest.gap.max()) for rest in rests)


@dataclass(frozen=True, kw_only=True, repr=False)
class ContactPrediction(Answer):
    """Attraction of a contact that was fitted to its capacitance, at voltages that the fit has not seen.

    Parameters
    ----------
    stack : BlockingStack
        Load, area and layers under which the force is predicted.
    voltage : ndarray, shape (n,)
        Voltages [V] in the order in which the contact goes through them.
    forces : ndarray, shape (draws, n)
        Attraction [N] by each draw of the phases of the roughness.
    measured : ndarray, shape (n,), or None
        Measured attraction at each voltage [N].
    field_share : float
        Field where faces touch, over that of insulating spots [1].
    diagnostics : tuple of Diagnostic
        Of what the scenario declares, and of films, air and limits where the faces touch.
    """

    FILES: ClassVar = {"prediction.csv": Form.TABLE}
    stack: BlockingStack
    voltage: Real
    forces: Real
    measured: Real | None
    field_share: float
    diagnostics: tuple[Diagnostic, ...]

    @property
    def force(self) -> Real:
        """Geometric mean of the attraction over the draws, at each voltage [N]; 0 where there is none."""
        with np.errstate(divide="ignore"):
            return np.asarray(np.exp(np.log(self.forces).mean(axis=0)))

    @property
    def typical_factor(self) -> float:
        """Factor between predicted and measured forces: exp of the root mean square of ln(predicted/measured); NaN without."""
        if self.measured is None:
            return math.nan
        return float(np.exp(np.sqrt(np.mean(np.log(self.force / self.measured) ** 2))))

    @property
    def slopes(self) -> tuple[float, float]:
        """Exponents of the voltage in the predicted and the measured force, by a straight line through the logarithms."""
        return self._slope(self.force), self._slope(self.measured)

    def _slope(self, force: Real | None) -> float:
        size = np.abs(self.voltage)
        if force is None or np.unique(size).size < 2:
            return math.nan
        return float(np.polyfit(np.log(size), np.log(force), 1)[0])

    @property
    def document(self) -> Document:
        """How far prediction and measurement agree, and a row for each voltage."""
        lowest, highest = self.forces.min(axis=0), self.forces.max(axis=0)
        numbers = [self.voltage, self.force, lowest, highest]
        headings = ["voltage", "force", "least of the draws", "largest of the draws"]
        rows = [
            [shown(each, unit) for each, unit in zip(row, "VNNN", strict=True)]
            for row in zip(*numbers, strict=True)
        ]
        if self.measured is not None:
            headings += ["measured", "predicted over measured"]
            for row, seen, own in zip(rows, self.measured.tolist(), self.force.tolist(), strict=True):
                row += [shown(seen, "N"), f"{own / seen:.3f}"]
        return Document(
            title="Force predicted from the capacitance",
            sentences=[self._at_most(), *self._compared(), *words_of_spots(self.field_share)],
            numbers=[Table("", tuple(headings), tuple(map(tuple, rows)))],
            diagnostics=self.diagnostics,
            figures=[self._figure()],
            remarks=[
                "no number of the prediction is free. It is the attraction under a constant voltage across the layers, with their"
                " permittivities at the lowest frequency of the scenario; a force along the plate is this times a coefficient of"
                " friction",
                *self._draws(),
                *reasons(self.diagnostics),
            ],
        )

    def content(self, name: str) -> str:
        """Write voltages, attraction per area, predicted forces of each draw and measured ones as CSV, in SI."""
        del name
        columns = {"voltage": self.voltage, "force": self.force, "attraction": self.force / self.stack.area}
        columns |= {f"draw {number}": each for number, each in enumerate(self.forces, 1)}
        if self.measured is not None:
            columns["measured"] = self.measured
        return csv_text(
            tuple(columns), np.column_stack(list(columns.values())).tolist(), remarks=self.document.sentences
        )

    def _draws(self) -> list[str]:
        alone = len(self.forces) == 1
        return (
            []
            if alone
            else ["the draws differ in the random phases of the roughness alone, which no capacitance tells"]
        )

    def _at_most(self) -> str:
        at = int(np.argmax(np.abs(self.voltage)))
        ends = (shown(end, "N") for end in (self.forces[:, at].min(), self.forces[:, at].max()))
        count = len(self.forces)
        over = f"{' to '.join(ends)} over {count} draws of the phases" if count > 1 else "of one surface"
        return (
            f"at {shown(self.voltage[at], 'V')} under a load of {shown(self.stack.pressure, 'Pa')} the attraction is"
            f" {shown(self.force[at], 'N')}, {over}"
        )

    def _compared(self) -> list[str]:
        if self.measured is None:
            return []
        said = f"predicted and measured forces differ by a typical factor of {self.typical_factor:.3g}"
        own, seen = self.slopes
        if math.isfinite(own):
            said += f"; the force grows with the power {own:.3g} of the voltage, measured {seen:.3g}"
        return [said]

    def _figure(self) -> Panel:
        low, high = self.forces.min(axis=0), self.forces.max(axis=0)
        curves = [Curve(label="predicted", x=self.voltage, y=self.force, kind="bold", look=0)]
        if len(self.forces) > 1:
            band = Curve(label="draws", x=self.voltage, y=low, upper=high, kind="band", look=0)
            curves = [band, replace(curves[0], label="predicted, with the range of draws")]
        if self.measured is not None:
            curves.append(Curve(label="measured", x=self.voltage, y=self.measured, kind="points", look=1))
        return Panel(
            id="force", title="Force over voltage", x=("voltage", "V"), y=("force", "N"), curves=tuple(curves),
            caption="Predicted from the capacitance over the load, with each draw of the phases.",
        )  # fmt: skip


def shown(value: float, unit: str) -> str:
    """Write a number with its unit and four digits."""
    return format_quantity(float(value), unit, digits=4)
