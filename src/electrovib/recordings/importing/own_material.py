"""A measured spectrum as a material, with the geometry that belongs to it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError
from electrovib.core.samples import Samples
from electrovib.core.units import exact_text, format_quantity
from electrovib.physics.tabulated import Tabulated
from electrovib.recordings.importing.sample import number_of, read_sample

if TYPE_CHECKING:
    from collections.abc import Mapping

    from electrovib.recordings.importing.sample import SampleSpectrum


@dataclass(frozen=True, kw_only=True)
class ImportedMaterial:
    """A material made of a measured spectrum; the thickness is None if a permittivity was measured and none given."""

    material: Tabulated
    thickness: float | None
    history: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    def to_toml(self, layer: str = "stratum_corneum") -> str:
        """Write the material as the table ``stack.<layer>``, to be put into a scenario in place of its layer of this name."""
        import tomlkit

        document = tomlkit.document()
        lines = [
            "A measured material; put these tables into a scenario in place of its layer of this name.",
            *self.history,
            *(f"{each.state}: {each.text}" for each in self.diagnostics),
        ]
        for line in lines:
            document.add(tomlkit.comment(line))
        stack, found = tomlkit.table(is_super_table=True), tomlkit.table()
        if self.thickness is not None:
            found.add("thickness", exact_text(self.thickness, "m"))
        content = tomlkit.table()
        content.add("model", "Tabulated")
        content.add("conductivity", exact_text(self.material.conductivity, "S/m"))
        for name in ("frequency_samples", "permittivity_samples", "loss_samples"):
            content.add(name, [float(value) for value in getattr(self.material, name).values])
        found.add("material", content)
        stack.add(layer, found)
        document.add("stack", stack)
        return tomlkit.dumps(document)


def import_material(
    path: str | Path,
    *,
    area: str | float | None = None,
    thickness: str | float | None = None,
    series_resistance: str | float = 0.0,
    parallel_capacitance: str | float = 0.0,
    conductivity: str | float = 0.0,
    columns: Mapping[str, str] | None = None,
    reader: str = "",
    delimiter: str | None = None,
    decimal_comma: bool | None = None,
    part: str | None = None,
) -> ImportedMaterial:
    r"""Import a measured impedance or permittivity spectrum as a material.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes.
    area : str or float, optional
        Area of the electrode or contact [m2]; needed for an impedance.
    thickness : str or float, optional
        Thickness of the sample [m]; needed for an impedance.
    series_resistance : str or float
        Resistance of leads, electrodes and gel in series with the sample [ohm], subtracted from the impedance.
    parallel_capacitance : str or float
        Capacitance of the fixture parallel to sample and series resistance [F], subtracted from the admittance first.
    conductivity : str or float
        Conductivity at zero frequency [S/m], which no spectrum determines; between 0 and the bound that a diagnostic states.
    columns : mapping of str to str, optional
        As for `electrovib.data.spectrum.spectrum_of`.
    reader : str
        Name of the reader; found from the first bytes if empty.
    delimiter : str, optional
        Of text: one character; found if not given.
    decimal_comma : bool, optional
        Of text: whether decimals are written with a comma; found if not given.
    part : str, optional
        Sheet of a spreadsheet, table of a Gamry file, or array whose length is chosen where a file holds several.

    Returns
    -------
    ImportedMaterial
        Material with its history and diagnostics.

    Raises
    ------
    InputError
        If the file holds no spectrum, a dimension is missing, or what remains is no passive dielectric.

    Notes
    -----
    The permittivity of a homogeneous sample of thickness d and area A, without fringe field, is
    :math:`\varepsilon^* = d / (j \omega \varepsilon_0 A Z)`.
    """
    sample = read_sample(
        path, area=area, thickness=thickness, series_resistance=series_resistance,
        parallel_capacitance=parallel_capacitance, columns=columns, reader=reader, delimiter=delimiter,
        decimal_comma=decimal_comma, part=part,
    )  # fmt: skip
    history, diagnostics = list(sample.history), list(sample.diagnostics)
    if not sample.permittivity.imag.any():
        words = "the table states a permittivity without loss: the loss is assumed to be 0"
        diagnostics.append(Diagnostic("loss", "unknown", words))
    material = _tabulated(sample, number_of("conductivity", conductivity, "S/m"), history)
    low, high = material.conduction_bounds()
    diagnostics.append(
        Diagnostic(
            "conductivity at zero frequency", "unknown",
            f"taken as {format_quantity(material.conductivity, 'S/m', digits=4)}; the table allows"
            f" {format_quantity(low, 'S/m')} to {format_quantity(high, 'S/m', digits=4)}",
        )
    )  # fmt: skip
    diagnostics += [each for each in material.diagnostics(Path(path).stem) if each.name == "measured table"]
    return ImportedMaterial(
        material=material, thickness=sample.thickness, history=tuple(history), diagnostics=tuple(diagnostics)
    )


def _tabulated(spectrum: SampleSpectrum, conductivity: float, history: list[str]) -> Tabulated:
    """Make the table; rows of one frequency are averaged, rows that no passive dielectric has are refused."""
    frequency, place = np.unique(spectrum.frequency, return_inverse=True)
    counts = np.bincount(place)
    if frequency.size < spectrum.frequency.size:
        history.append(f"{spectrum.frequency.size - frequency.size} repeated frequencies averaged")
    real = np.bincount(place, spectrum.permittivity.real) / counts
    loss = np.bincount(place, -spectrum.permittivity.imag) / counts
    bad = ~((real > 0) & (loss >= 0))
    if bad.any():
        first = int(np.argmax(bad))
        raise InputError(
            f"the spectrum: {int(bad.sum())} of {bad.size} rows are those of no passive dielectric, the first at"
            f" {format_quantity(float(frequency[first]), 'Hz', digits=4)} with eps' = {real[first]:.4g} and eps'' ="
            f" {loss[first]:.4g}. An inductive or badly calibrated instrument, or too large a series resistance or parallel"
            " capacitance, does this; crop the file to the rows that hold."
        )
    return Tabulated(
        conductivity=conductivity,
        frequency_samples=Samples(frequency),
        permittivity_samples=Samples(real),
        loss_samples=Samples(loss),
    )
