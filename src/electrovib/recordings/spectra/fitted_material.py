"""The material that was fitted to measured spectra as an answer: its parameters with both uncertainties, figures and a file."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from electrovib.core.answer import Answer, Curve, Document, Panel, Table
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.units import format_quantity
from electrovib.data.atomic import Form, unsigned
from electrovib.recordings.importing.own_material import layer_toml
from electrovib.recordings.interval import NORMAL, EstimatedParameter
from electrovib.scenario.toml import model_table

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.core.arrays import Complex, Real
    from electrovib.recordings.importing.own_material import SampleSpectrum
    from electrovib.recordings.spectra.material import MaterialFit
    from electrovib.scenario import Scenario

_DRAWN: Final = 200
"""Frequencies of the curve of a form."""


def both_uncertainties(parameter: EstimatedParameter) -> str:
    """Write the statistical interval of a parameter, and the systematic error of the instrument."""
    _, ends = parameter.texts(parameter.unit, digits=4)
    text = f"statistical 95 % interval {ends}" if ends else f"no statistical interval: {parameter.note}"
    return f"{text}; systematic error of the instrument {systematic_error(parameter)}"


def systematic_error(parameter: EstimatedParameter) -> str:
    """Write the error that the instrument makes in a parameter, in 95 % of all cases at most."""
    if math.isnan(parameter.systematic):
        return "not stated"
    return f"+- {format_quantity(NORMAL * parameter.systematic, parameter.unit, digits=2)}"


@dataclass(frozen=True, kw_only=True, repr=False)
class FittedMaterial(Answer):
    """A dispersion fitted to measured spectra, the chosen form first, with the thickness that is common to all samples.

    Its file ``material.toml`` is the `layer` alone, or the scenario `into` with it.
    """

    FILES: ClassVar = {"material.toml": None}
    samples: Mapping[str, SampleSpectrum]
    fits: tuple[MaterialFit, ...]
    origin: str
    parameters: tuple[EstimatedParameter, ...]
    thickness: float | None
    history: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]
    into: Scenario | None = None
    layer: str = "stratum_corneum"

    @property
    def files(self) -> Mapping[str, str | None]:
        """The scenario with the material, which is replaced if it was written by the package, or the material."""
        return self.FILES if self.into is None else {"material.toml": Form.SCENARIO}

    def content(self, name: str) -> str:
        """Write the material as TOML, or the scenario with it."""
        del name
        if self.into is None:
            return self.to_toml(self.layer)
        changed = self.into.replace(self.changes(self.layer))
        changed = changed.model_copy(update={"sources": changed.sources | self.sources(self.layer)})
        return f"# {unsigned(Form.SCENARIO)}\n{changed.to_toml()}"

    @property
    def document(self) -> Document:
        """How it was fitted, each parameter with both uncertainties, and the form over the measured rows."""
        rows = [
            (
                each.name,
                format_quantity(each.value, each.unit, digits=4),
                systematic_error(each),
                ends or f"none: {each.note}",
            )
            for each in self.parameters
            for _, ends in [each.texts(each.unit, digits=4)]
        ]
        headings = ("parameter", "value", "error of the instrument (95 %)", "statistical 95 % interval")
        return Document(
            title=f"Material fitted to {self.origin}: {self.form}",
            sentences=self.history,
            numbers=[Table("", headings, tuple(rows))],
            diagnostics=self.diagnostics,
            figures=self._panels(),
            remarks=reasons(self.diagnostics),
        )

    def _panels(self) -> list[Panel]:
        """Draw permittivity and, where it was measured, conductivity."""

        def conductivity(frequency: Real, permittivity: Complex) -> Real:
            return np.asarray(-permittivity.imag * 2 * math.pi * frequency * eps0)

        parts: list[tuple[str, str, Callable[[Real, Complex], Real]]] = [
            ("relative permittivity", "", lambda _, permittivity: permittivity.real)
        ]
        if self.fits[0].loss == "measured":
            parts.append(("conductivity", "S/m", conductivity))
        every = np.concatenate([each.frequency for each in self.samples.values()])
        grid = np.geomspace(every.min(), every.max(), _DRAWN)
        fitted = self.material.complex_permittivity(grid)
        return [
            Panel(
                id=title.split()[-1],
                title=title.capitalize(),
                caption=f"Measured rows and {self.form}.",
                x=("frequency", "Hz"),
                y=(title, unit),
                log_x=True,
                log_y=True,
                curves=(
                    *(
                        Curve(
                            label=name,
                            x=each.frequency,
                            y=of(each.frequency, each.permittivity),
                            kind="points",
                        )
                        for name, each in self.samples.items()
                    ),
                    Curve(label=self.form, x=grid, y=of(grid, fitted), look=len(self.samples)),
                ),
            )
            for title, unit, of in parts
        ]

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
            f"stack.{layer}.material.{each.name}": f"{self.form} fitted to {self.origin}; {both_uncertainties(each)}"
            for each in self.parameters
        }

    def to_toml(self, layer: str = "stratum_corneum") -> str:
        """Write the material as the table ``stack.<layer>`` of a scenario, with origin and errors as comments."""
        lines = [
            *self.history,
            *(f"{each.name}: {both_uncertainties(each)}" for each in self.parameters),
            *(f"{each.state}: {each.text}" for each in self.diagnostics),
        ]
        content = model_table(self.material)
        return layer_toml("A material fitted to measured data", lines, layer, self.thickness, content)
