"""A material fitted to measured spectra, with its origin and both of its uncertainties, ready for a scenario."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, nearest
from electrovib.core.units import exact_text, format_quantity
from electrovib.recordings.spectra.form_names import forms_of
from electrovib.recordings.spectra.judged import (
    acceptable_first,
    diagnostics_of,
    history_of,
    loss_that_follows,
    refuse_misfit,
)
from electrovib.recordings.spectra.linear_test import consistency
from electrovib.recordings.spectra.material import fit_material

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from electrovib.core.arrays import Real
    from electrovib.core.model import Model
    from electrovib.recordings.importing.sample import SampleSpectrum
    from electrovib.recordings.spectra.instrument import InstrumentError
    from electrovib.recordings.spectra.material import MaterialFit


@dataclass(frozen=True, kw_only=True)
class MaterialParameter:
    """One parameter of a fitted material, by its dotted path within it.

    The interval is statistical, 95 %, NaN where there is none, for which `note` gives the reason.
    `systematic` is the standard deviation by the error of the instrument; NaN where that is not stated.
    """

    path: str
    unit: str
    value: float
    lower: float
    upper: float
    systematic: float
    note: str

    @property
    def sentence(self) -> str:
        """Both uncertainties in words."""
        if self.note:
            text = f"no statistical interval: {self.note}"
        else:
            ends = (format_quantity(end, self.unit, digits=4) for end in (self.lower, self.upper))
            text = f"statistical 95 % interval {' to '.join(ends)}"
        if math.isnan(self.systematic):
            return f"{text}; systematic error of the instrument not stated"
        half = format_quantity(1.96 * self.systematic, self.unit, digits=2)
        return f"{text}; systematic error of the instrument +- {half} (95 %)"


@dataclass(frozen=True, kw_only=True)
class FittedMaterial:
    """A dispersion fitted to measured spectra, the chosen form first, with the thickness that is common to all samples."""

    fits: tuple[MaterialFit, ...]
    origin: str
    parameters: tuple[MaterialParameter, ...]
    thickness: float | None
    history: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    @property
    def material(self) -> Any:
        """The material, ready for a layer of a scenario."""
        return self.fits[0].material

    @property
    def form(self) -> str:
        """Name of the chosen form."""
        return self.fits[0].form

    def changes(self, layer: str = "stratum_corneum") -> dict[str, Any]:
        """Return the changes that put the material into a layer of a scenario, for `Scenario.replace`."""
        found: dict[str, Any] = {f"stack.{layer}.material": self.material}
        if self.thickness is not None:
            found[f"stack.{layer}.thickness"] = self.thickness
        return found

    def sources(self, layer: str = "stratum_corneum") -> dict[str, str]:
        """Return the origin of each parameter, by its path in a scenario."""
        return {
            f"stack.{layer}.material.{each.path}": f"{self.form} fitted to {self.origin}; {each.sentence}"
            for each in self.parameters
        }

    def to_toml(self, layer: str = "stratum_corneum") -> str:
        """Write the material as the table ``stack.<layer>`` of a scenario, with origin and errors as comments."""
        import tomlkit

        document = tomlkit.document()
        lines = [
            "A material fitted to measured data; put these tables into a scenario in place of its layer of this name.",
            *self.history,
            *(f"{each.path}: {each.sentence}" for each in self.parameters),
            *(f"{each.state}: {each.text}" for each in self.diagnostics),
        ]
        for line in lines:
            document.add(tomlkit.comment(" ".join(line.split())))
        stack, found = tomlkit.table(is_super_table=True), tomlkit.table()
        if self.thickness is not None:
            found.add("thickness", exact_text(self.thickness, "m"))
        found.add("material", tomlkit.item(_table_of(self.material)))
        stack.add(layer, found)
        document.add("stack", stack)
        return tomlkit.dumps(document)


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
    fits = acceptable_first(
        fit_material(frequency, permittivity, forms=forms, noise=weights, loss=loss), allowed
    )
    tested = [consistency(each.frequency, each.permittivity) for each in samples.values()]
    consistent = {
        "measured": float(np.max(tested)),
        "none": fits[0].error,  # a material without loss is constant
        "unknown": math.nan,
    }[loss]
    refuse_misfit(fits[0], consistent, allowed)
    deviations = None if error is None else error.deviations(
        fits[0], frequency, permittivity, noise=weights,
        per_farad=np.concatenate([np.full(each.frequency.size, each.per_farad) for each in samples.values()]),
    )  # fmt: skip
    depths = {each.thickness for each in samples.values()}
    return FittedMaterial(
        fits=fits,
        origin=", ".join(samples),
        parameters=tuple(_parameters(fits[0], deviations)),
        thickness=depths.pop() if len(depths) == 1 else None,
        history=tuple(history_of(samples, fits, frequency, noise or {}, error)),
        diagnostics=(
            *(each for sample in samples.values() for each in sample.diagnostics),
            *diagnostics_of(fits[0], consistent, noise or {}),
            *([loss_that_follows(fits, frequency, allowed)] if loss == "unknown" else ()),
        ),
    )


def _noise_of(samples: Mapping[str, SampleSpectrum], noise: Mapping[str, float]) -> Real | None:
    if not noise:
        return None
    problems = [
        f"noise: '{name}' is none of the sources.{nearest(name, samples)}"
        for name in noise
        if name not in samples
    ]
    problems += [f"noise: state that of '{name}' too, or of none" for name in samples if name not in noise]
    if problems:
        raise InputError(problems)
    return np.concatenate([np.full(each.frequency.size, noise[name]) for name, each in samples.items()])


def _parameters(best: MaterialFit, deviations: Mapping[str, float] | None) -> Iterator[MaterialParameter]:
    estimate = best.estimate
    units = {path: quantity.unit for path, _, quantity in best.material.parameters() if quantity is not None}
    for path, value in estimate.values.items():
        note = estimate.why_no_covariance
        if path in estimate.on_bound:
            note = f"the estimate lies on the {estimate.on_bound[path]} bound of the parameter"
        lower, upper = (math.nan, math.nan) if note else estimate.interval(path)
        yield MaterialParameter(
            path=path,
            unit=units[path],
            value=value,
            lower=lower,
            upper=upper,
            systematic=math.nan if deviations is None else deviations[path],
            note=note,
        )
    if best.loss != "measured":
        yield MaterialParameter(
            path="conductivity",
            unit=units["conductivity"],
            value=0.0,
            lower=math.nan,
            upper=math.nan,
            systematic=math.nan,
            note="0 as stated with the loss"
            if best.loss == "none"
            else "not measured, because a permittivity does not show it; 0 was taken",
        )


def _table_of(model: Model) -> dict[str, Any]:
    """Return a material as plain tables, each number with its unit where it reads back exactly."""
    found: dict[str, Any] = {"model": type(model).__name__} if model.is_member else {}
    quantities = {path: quantity for path, _, quantity in model.parameters()}
    for name, value in model:
        if value is None:
            continue
        if isinstance(value, tuple):
            found[name] = [_table_of(item) for item in value]
        elif isinstance(value, float) and (quantity := quantities.get(name)) is not None:
            found[name] = exact_text(value, quantity.unit)
        else:
            found[name] = value
    return found
