"""A material fitted to measured spectra, judged, with its uncertainty and the error of the instrument, ready for a scenario."""

from __future__ import annotations

import cmath
import contextlib
import dataclasses
import functools
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, nearest, refuse
from electrovib.core.units import format_quantity
from electrovib.recordings.importing.own_material import CERTAIN, fit_parallel_part
from electrovib.recordings.interval import EstimatedParameter
from electrovib.recordings.spectra.fitted_material import FittedMaterial
from electrovib.recordings.spectra.material import (
    FORMS,
    OFFERED,
    consistency,
    fit_material,
    forms_of,
    free_parameters,
    shift_of,
    short_name,
    slopes_of,
)

if TYPE_CHECKING:
    from collections.abc import Callable, Iterator, Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real
    from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate
    from electrovib.recordings.importing.own_material import SampleSpectrum
    from electrovib.recordings.spectra.material import MaterialFit


def fit_samples(
    samples: Mapping[str, SampleSpectrum],
    *,
    form: str = "auto",
    noise: Mapping[str, float] | None = None,
    error: InstrumentError | None = None,
    loss: str = "measured",
) -> FittedMaterial:
    """Fit a dispersion to the spectra of one or several samples of the same material, by name of the source.

    The form has the smallest AICc among those that are not refused. `noise` is relative; without it all rows
    count alike. Data that deviate from the Kramers-Kronig relations by more than 10 %, or that the best form
    misses by more than 30 %, are refused; both limits are at least three times the stated noise.
    """
    forms = forms_of("constant" if loss == "none" and form == "auto" else form)
    weights = _noise_of(samples, noise or {})
    frequency = np.concatenate([each.frequency for each in samples.values()])
    permittivity = np.concatenate([each.permittivity for each in samples.values()])
    allowed = 3 * max((noise or {}).values(), default=0.0)
    found = fit_material(frequency, permittivity, forms=forms, noise=weights, loss=loss)
    # with few rows the criterion of Akaike prefers forms of few parameters whatever they miss
    fits = tuple(sorted(found, key=lambda each: _misses(each, allowed)))
    tested = [consistency(each.frequency, each.permittivity) for each in samples.values()]
    consistent = {
        "measured": float(np.max(tested)),
        "none": fits[0].error,  # a material without loss is constant
        "unknown": math.nan,
    }[loss]
    advice = functools.cache(functools.partial(described_by, frequency, permittivity, forms, loss))
    refuse_misfit(fits[0], consistent, allowed, advice)
    deviations = None if error is None else error.deviations(
        fits[0], frequency, permittivity, noise=weights,
        per_farad=np.concatenate([np.full(each.frequency.size, each.per_farad) for each in samples.values()]),
    )  # fmt: skip
    depths = {each.thickness for each in samples.values()}
    return FittedMaterial(
        samples=samples,
        fits=fits,
        origin=", ".join(samples),
        parameters=tuple(_parameters(fits[0], deviations)),
        thickness=depths.pop() if len(depths) == 1 else None,
        history=tuple(history_of(samples, fits, frequency, noise or {}, error)),
        diagnostics=(
            *(each for sample in samples.values() for each in sample.diagnostics),
            *diagnostics_of(fits[0], consistent, noise or {}, advice),
            *([loss_that_follows(fits, frequency, allowed)] if loss == "unknown" else ()),
        ),
    )


def _noise_of(samples: Mapping[str, SampleSpectrum], noise: Mapping[str, float]) -> Real | None:
    if not noise:
        return None
    problems = [
        f"scatter: '{name}' is none of the sources.{nearest(name, samples)}"
        for name in noise
        if name not in samples
    ]
    problems += [f"scatter: state that of '{name}' too, or of none" for name in samples if name not in noise]
    refuse(problems)
    return np.concatenate([np.full(each.frequency.size, noise[name]) for name, each in samples.items()])


def _parameters(best: MaterialFit, deviations: Mapping[str, float] | None) -> Iterator[EstimatedParameter]:
    estimate = best.estimate
    free = free_parameters(best.material, best.loss)
    units = {path: quantity.unit for path, _, quantity in best.material.parameters() if quantity is not None}
    for path, value in estimate.values.items():
        note = estimate.why_no_covariance
        if path in estimate.on_bound:
            note = f"the estimate lies on the {estimate.on_bound[path]} bound of the parameter"
            if path == "conductivity" and estimate.on_bound[path] == "upper":
                note = "the rows allow no more, and the form would take more: it does not describe the lowest frequencies"
        lower, upper = (math.nan, math.nan) if note else _ends(estimate, path, free[path])
        systematic = math.nan if deviations is None else deviations[path]
        yield EstimatedParameter(
            name=path,
            unit=units[path],
            value=value,
            lower=lower,
            upper=upper,
            systematic=systematic,
            note=note,
            low=free[path].lower,
        )
    if best.loss != "measured":
        note = {
            "none": "0 as stated with the loss",
            "unknown": "not measured, because a permittivity does not show it; 0 was taken",
        }[best.loss]
        yield EstimatedParameter(name="conductivity", unit=units["conductivity"], value=0.0, note=note)


def _ends(estimate: LeastSquaresEstimate, path: str, free: FreeParameter) -> tuple[float, float]:
    """Return the ends of a 95 % interval within the range, by a factor where the search is logarithmic."""
    value, half = estimate.values[path], estimate.quantile(0.95) * estimate.standard_deviations[path]
    if not free.logarithmic:
        return max(value - half, free.lower), min(value + half, free.upper)
    factor = math.exp(min(half / value, _WIDEST)) if value else math.inf
    return max(value / factor, free.lower), min(value * factor, free.upper)


_WIDEST: Final = 100.0
INCONSISTENT: Final = 0.02
"""Deviation from the Kramers-Kronig relations, relative, beyond which a table is reported as inconsistent."""
REFUSED_INCONSISTENT: Final = 0.1
"""The same, beyond which a table is refused."""
COMPARABLE: Final = 10.0
"""Difference of AICc above which a form describes the data clearly worse."""
MISFIT: Final = 0.05
"""Relative root mean square by which a form misses the data beyond which that is reported."""
REFUSED_MISFIT: Final = 0.3
"""The same, beyond which the form is refused."""


def _misses(fit: MaterialFit, allowed: float) -> bool:
    """Return whether a form misses the data by more than is accepted."""
    return not fit.error <= max(REFUSED_MISFIT, allowed)


def described_by(frequency: Real, permittivity: Complex, tried: Sequence[str], loss: str) -> str:
    """Name a form that describes a spectrum to 5 %, the widest band in which one does, or say that there is none."""
    places = np.log(frequency)
    low, whole = float(places.min()), float(np.ptp(places))
    attempts: list[tuple[float, float, Sequence[str]]] = [
        (low, low + whole, [each for each in FORMS if each not in tried])
    ]
    for share in (0.75, 0.5, 0.25):
        attempts += [(low, low + share * whole, OFFERED), (low + (1 - share) * whole, low + whole, OFFERED)]
    for first, last, forms in attempts:
        part = (places >= first - 1e-9) & (places <= last + 1e-9)
        with contextlib.suppress(InputError):
            for fit in fit_material(frequency[part], permittivity[part], forms=forms, loss=loss):
                if fit.error <= MISFIT:
                    ends = (format_quantity(math.exp(each), "Hz", digits=3) for each in (first, last))
                    band = "" if part.all() else f" --band '{'..'.join(ends)}'"
                    return f"--form {short_name(fit.form)}{band} describes it to {100 * fit.error:.2g} %"
    return (
        "no form describes it to 5 %, nor a quarter of its band: measure again, or take the rows as a table"
    )


def refuse_misfit(best: MaterialFit, consistent: float, allowed: float, advice: Callable[[], str]) -> None:
    """Refuse a spectrum that is not that of a linear, causal material, and a form that misses it."""
    limit = max(REFUSED_INCONSISTENT, allowed)
    if consistent > limit:
        more = "; a loss that was not measured is stated with --loss unknown" if best.loss == "none" else ""
        raise InputError(
            f"the spectrum deviates from the Kramers-Kronig relations by {100 * consistent:.2g} %, more than {100 * limit:.2g} %:"
            " it is not that of a linear, causal material. Calibrate the instrument and measure again, restrict the band with"
            f" --band, or state the scatter of the rows with --scatter if it is as large{more}"
        )
    if _misses(best, allowed):
        raise InputError(
            f"{best.form}, the best of the forms, misses the spectrum by {100 * best.error:.2g} % rms, more than"
            f" {100 * REFUSED_MISFIT:g} %: {advice()}"
        )


def history_of(
    samples: Mapping[str, SampleSpectrum],
    fits: Sequence[MaterialFit],
    frequency: Real,
    noise: Mapping[str, float],
    error: InstrumentError | None,
) -> Iterator[str]:
    """State how a material was fitted, in one sentence for each step."""
    best = fits[0]
    for name, each in samples.items():
        weight = f"; noise {100 * noise[name]:.3g} % as stated" if noise else ""
        yield f"{'; '.join(each.history)}; {each.frequency.size} rows{weight}"
    low, high = (format_quantity(float(end), "Hz", digits=4) for end in (frequency.min(), frequency.max()))
    measured_loss = best.loss == "measured"
    more = f" and the conductivity by {100 * best.conductivity_error:.2g} % rms" if measured_loss else ""
    missed = f"it misses the permittivity by {100 * best.permittivity_error:.2g} % rms{more}"
    yield f"{best.form} fitted{'' if measured_loss else ' to the permittivity alone'} from {low} to {high}; {missed}"
    if len(fits) > 1:
        others = {each.form: each.estimate.aicc - best.estimate.aicc for each in fits[1:]}
        ranks = ", ".join(f"{form} {apart:.3g}" for form, apart in others.items() if apart >= 0)
        yield f"form chosen by AICc; above the chosen one lie {ranks or 'no others'}"
        if omitted := [form for form, apart in others.items() if apart < 0]:
            limit = f"{100 * REFUSED_MISFIT:g} % rms, or than the noise explains"
            yield f"omitted in spite of a lower AICc, because they miss the data by more than {limit}: {', '.join(omitted)}"
    if best.outliers.any():
        rows = ", ".join(format_quantity(float(each), "Hz", digits=4) for each in frequency[best.outliers])
        yield f"left out as outliers: {rows}"
    if error is not None:
        yield (
            f"systematic error of the instrument: modulus {100 * error.gain:.2g} %, phase {math.degrees(error.phase):.2g} degrees"
            f" ({error.words or 'as declared'})"
        )


def diagnostics_of(
    best: MaterialFit, consistent: float, noise: Mapping[str, float], advice: Callable[[], str]
) -> Iterator[Diagnostic]:
    """Judge the Kramers-Kronig relations, a misfit above 5 %, and the conductivity at zero frequency."""
    limit = max(INCONSISTENT, 2 * max(noise.values(), default=0.0))
    state, text = "unknown", "without a measured loss the Kramers-Kronig relations are no test of the data"
    if best.loss != "unknown" and math.isnan(consistent):
        text = "too few or repeated frequencies to test the Kramers-Kronig relations"
    elif best.loss != "unknown":
        state = "ok"
        text = f"the data deviate from the Kramers-Kronig relations by {100 * consistent:.2g} % rms"
        if consistent > limit:
            state = "warning"
            text += f", more than {100 * limit:.2g} %: no form of dispersion represents them exactly"
    yield Diagnostic("Kramers-Kronig", state, text)
    if best.error > MISFIT:
        missed = f"{100 * best.error:.2g} % rms, more than {100 * MISFIT:g} %"
        yield Diagnostic("misfit", "warning", f"the form misses the data by {missed}: {advice()}")
    if best.loss == "none":
        text = "the loss was stated to be 0, conduction included; it was not measured"
        yield Diagnostic("loss", "unknown", text)
    if best.loss == "measured":
        text = "the conductivity is that of the form, extrapolated below the lowest frequency measured"
        yield Diagnostic("conductivity at zero frequency", "unknown", text)


def loss_that_follows(fits: Sequence[MaterialFit], frequency: Real, allowed: float) -> Diagnostic:
    """State the loss factor that follows from a permittivity by all acceptable forms within 10 of the best AICc."""
    low, high = float(frequency.min()), float(frequency.max())
    at = np.array([low, math.sqrt(low * high), high])
    near = [
        each
        for each in fits
        if each is fits[0]
        or (each.estimate.aicc < fits[0].estimate.aicc + COMPARABLE and not _misses(each, allowed))
    ]
    ends = [interval for each in near for interval in _losses(each, at)]
    losses = -fits[0].material.complex_permittivity(at).imag
    rows = (
        f"{value:.3g} ({lower:.3g} to {upper:.3g}) at {format_quantity(float(place), 'Hz', digits=3)}"
        for value, lower, upper, place in np.transpose(
            [losses, np.min(ends, axis=0), np.max(ends, axis=0), at]
        )
    )
    text = (
        f"the loss was not measured; by the Kramers-Kronig relations the permittivity has, in this form, a loss factor of"
        f" {', '.join(rows)}, in brackets 95 % intervals of all forms that describe it ({', '.join(each.form for each in near)})."
        " Conduction adds to it without a trace in the permittivity: it is a lower bound, and the conductivity is to be measured"
    )
    return Diagnostic("loss", "unknown", text)


def _losses(fit: MaterialFit, at: Real) -> tuple[Real, Real]:
    """Return both ends of the 95 % interval of the loss factor, from 0 on; a form without covariance leaves it open."""
    value = -fit.material.complex_permittivity(at).imag
    covariance = fit.estimate.covariance
    if not value.any():
        return value, value
    if covariance is None:
        return np.zeros(at.shape), np.full(at.shape, np.inf)
    free = free_parameters(fit.material, fit.loss)
    slopes = slopes_of(
        fit.material, fit.estimate.values, free, lambda one: -one.complex_permittivity(at).imag / value
    )
    relative = 1.96 * np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    return value * np.exp(-relative), value * np.exp(relative)


@dataclass(frozen=True, kw_only=True)
class InstrumentError:
    """The systematic error of an impedance, common to all frequencies, as standard uncertainties.

    - `gain`: of the modulus over the modulus; that of area and thickness may be part of it.
    - `phase`: of the phase [rad].
    - `fixture_capacitance`: capacitance in parallel with the known resistor, that of fixture and leads [F]; 0
      where it is not measured, or less than 5 standard deviations.
    - `fixture_uncertainty`: of the capacitance of fixture and leads at the sample [F].
    - `words`: where they are from.
    """

    gain: float = 0.0
    phase: float = 0.0
    fixture_capacitance: float = 0.0
    fixture_uncertainty: float = 0.0
    words: str = ""

    def __post_init__(self) -> None:
        problems = [
            f"systematic {name} = {value}: expected 0 or more, and less than 1"
            for name, value in (("gain", self.gain), ("phase", self.phase))
            if not (math.isfinite(value) and 0 <= value < 1)
        ]
        refuse(problems)

    def without_fixture(self) -> InstrumentError:
        """Return it for a sample whose fixture is known otherwise."""
        return dataclasses.replace(self, fixture_capacitance=0.0, fixture_uncertainty=0.0)

    def deviations(
        self,
        fit: MaterialFit,
        frequency: Real,
        permittivity: Complex,
        *,
        noise: ArrayLike | None,
        per_farad: ArrayLike = 0.0,
    ) -> dict[str, float]:
        """Return the standard deviation of each parameter of a material by the error of the instrument, by its path.

        It is the root of the sum of squares of those by the modulus, the phase and the fixture, each by the
        derivative of the estimate; it does not average out with more data. `per_farad` is the permittivity
        that one farad of the fixture makes at each row, 0 where a permittivity was measured.
        """
        found = dict.fromkeys(fit.estimate.values, 0.0)
        fixture = 1 + self.fixture_uncertainty * np.asarray(per_farad) / permittivity
        for factor in (cmath.exp(self.gain), cmath.exp(1j * self.phase), fixture):
            if np.any(factor != 1):
                shift = shift_of(fit, frequency, permittivity, factor=factor, noise=noise)
                found = {path: math.hypot(value, shift[path]) for path, value in found.items()}
        return found


def error_by_resistor(
    frequency: ArrayLike, impedance: ArrayLike, *, resistance: float, tolerance: float = 0.0
) -> InstrumentError:
    """Measure the systematic error of an instrument with a resistor of known value, at 8 or more frequencies.

    The known value is equally likely everywhere within its relative `tolerance`. The error is the relative
    deviation of the measured resistance, the phase at vanishing frequency, and the capacitance in parallel.
    The sample lies elsewhere in the fixture, with leads of its own: that capacitance is taken as uncertain by
    as much as itself.
    """
    if not (math.isfinite(resistance) and resistance > 0):
        raise InputError(f"resistance = {resistance}: expected more than 0 ohm")
    if not 0 <= tolerance < 1:
        raise InputError(f"tolerance = {tolerance}: expected 0 or more, and less than 1")
    found = fit_parallel_part(frequency, impedance)
    own = found.estimate.standard_deviations
    phase = abs(found.estimate.values["phase_offset"])
    certain = found.capacitance > CERTAIN * own["capacitance"]
    known = (
        f" known to {100 * tolerance:.3g} %"
        if tolerance
        else " whose tolerance is not stated and not counted"
    )
    return InstrumentError(
        gain=math.hypot(
            found.resistance / resistance - 1, own["resistance"] / resistance, tolerance / math.sqrt(3)
        ),
        phase=math.hypot(phase, own["phase_offset"]),
        fixture_capacitance=found.capacitance if certain else 0.0,
        fixture_uncertainty=math.hypot(found.capacitance, own["capacitance"]),
        words=f"a resistor of {resistance:.6g} ohm{known} measured as {found.resistance:.6g} ohm, with a phase offset of"
        f" {math.degrees(phase):.2g} degrees and {found.capacitance:.3g} F in parallel",
    )
