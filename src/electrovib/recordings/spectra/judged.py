"""The judgement of a fitted dispersion: what is refused, what is reported, and how it was fitted."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.recordings.spectra.logarithms import slopes_of

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping, Sequence

    from electrovib.core.arrays import Real
    from electrovib.recordings.importing.sample import SampleSpectrum
    from electrovib.recordings.spectra.instrument import InstrumentError
    from electrovib.recordings.spectra.material import MaterialFit

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


def acceptable_first(fits: Sequence[MaterialFit], allowed: float) -> tuple[MaterialFit, ...]:
    """Put the forms that miss the data by more than is accepted behind the others.

    With few rows the criterion of Akaike, by which they are sorted, prefers forms of few parameters whatever
    they miss. The limit is at least the relative deviation `allowed`, which the stated noise explains.
    """
    return tuple(sorted(fits, key=lambda each: _misses(each, allowed)))


def refuse_misfit(best: MaterialFit, consistent: float, allowed: float) -> None:
    """Refuse a spectrum that is not that of a linear, causal material, and a form that misses it."""
    limit = max(REFUSED_INCONSISTENT, allowed)
    if consistent > limit:
        more = "; a loss that was not measured is stated with --loss unknown" if best.loss == "none" else ""
        raise InputError(
            f"the spectrum deviates from the Kramers-Kronig relations by {100 * consistent:.2g} %, more than {100 * limit:.2g} %:"
            " it is not that of a linear, causal material. Calibrate the instrument and measure again, restrict the band with"
            f" --band, or state the noise of the rows with --noise if it is as large{more}"
        )
    if _misses(best, allowed):
        raise InputError(
            f"{best.form}, the best of the forms, misses the spectrum by {100 * best.error:.2g} % rms, more than"
            f" {100 * REFUSED_MISFIT:g} %: take more terms with --form cole-cole-4, or a smaller --band"
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
    told = best.loss == "measured"
    more = f" and the conductivity by {100 * best.conductivity_error:.2g} % rms" if told else ""
    missed = f"it misses the permittivity by {100 * best.permittivity_error:.2g} % rms{more}"
    yield f"{best.form} fitted{'' if told else ' to the permittivity alone'} from {low} to {high}; {missed}"
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


def diagnostics_of(best: MaterialFit, consistent: float, noise: Mapping[str, float]) -> Iterator[Diagnostic]:
    """Judge the Kramers-Kronig relations, a misfit above 5 %, and the conductivity at zero frequency."""
    limit = max(INCONSISTENT, 2 * max(noise.values(), default=0.0))
    if best.loss == "unknown":
        yield Diagnostic(
            "Kramers-Kronig",
            "unknown",
            "without a measured loss the Kramers-Kronig relations are no test of the data",
        )
    elif math.isnan(consistent):
        yield Diagnostic(
            "Kramers-Kronig",
            "unknown",
            "too few or repeated frequencies to test the Kramers-Kronig relations",
        )
    else:
        text = f"the data deviate from the Kramers-Kronig relations by {100 * consistent:.2g} % rms"
        bad = consistent > limit
        more = (
            f", more than {100 * limit:.2g} %: no form of dispersion represents them exactly" if bad else ""
        )
        yield Diagnostic("Kramers-Kronig", "warning" if bad else "ok", f"{text}{more}")
    if best.error > MISFIT:
        yield Diagnostic(
            "misfit",
            "warning",
            f"the form misses the data by {100 * best.error:.2g} % rms, more than {100 * MISFIT:g} %",
        )
    if best.loss == "none":
        yield Diagnostic(
            "loss", "unknown", "the loss was stated to be 0, conduction included; it was not measured"
        )
    if best.loss == "measured":
        yield Diagnostic(
            "conductivity at zero frequency",
            "unknown",
            "the conductivity is that of the form, extrapolated below the lowest frequency measured",
        )


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
    rows = (
        f"{value:.3g} ({lower:.3g} to {upper:.3g}) at {format_quantity(float(place), 'Hz', digits=3)}"
        for value, lower, upper, place in zip(
            -fits[0].material.complex_permittivity(at).imag,
            np.min(ends, axis=0),
            np.max(ends, axis=0),
            at,
            strict=True,
        )
    )
    return Diagnostic(
        "loss",
        "unknown",
        f"the loss was not measured; by the Kramers-Kronig relations the permittivity has, in this form, a loss factor of"
        f" {', '.join(rows)}, in brackets 95 % intervals of all forms that describe it ({', '.join(each.form for each in near)})."
        " Conduction adds to it without a trace in the permittivity: it is a lower bound, and the conductivity is to be measured",
    )


def _losses(fit: MaterialFit, at: Real) -> tuple[Real, Real]:
    """Return both ends of the 95 % interval of the loss factor, from 0 on; a form without covariance leaves it open."""
    value = -fit.material.complex_permittivity(at).imag
    covariance = fit.estimate.covariance
    if not value.any():
        return value, value
    if covariance is None:
        return np.zeros(at.shape), np.full(at.shape, np.inf)
    slopes = slopes_of(
        fit.material, fit.estimate.values, fit.loss, lambda one: -one.complex_permittivity(at).imag / value
    )
    relative = 1.96 * np.sqrt(np.einsum("ij,jk,ik->i", slopes, covariance, slopes))
    return value * np.exp(-relative), value * np.exp(relative)
