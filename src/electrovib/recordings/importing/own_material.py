"""The permittivity of a sample from a measured spectrum and its geometry, as a material; the instrument's phase error."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from electrovib.core.constants import eps0
from electrovib.core.deprecation import former_value
from electrovib.core.diagnostics import Diagnostic
from electrovib.core.errors import InputError, refuse
from electrovib.core.samples import Samples
from electrovib.core.units import exact_text, format_quantity, number_in
from electrovib.data.registry import read_recorded
from electrovib.data.spectrum import FEWEST, spectrum_of, split_part
from electrovib.physics.kramers_kronig import kramers_kronig_residual
from electrovib.physics.material.tabulated import Tabulated
from electrovib.recordings.fit.least_squares import FreeParameter, LeastSquaresEstimate
from electrovib.recordings.importing.notices import about_parts

if TYPE_CHECKING:
    from collections.abc import Mapping, Sequence

    from numpy.typing import ArrayLike

    from electrovib.core.arrays import Complex, Real

LARGEST_PHASE_OFFSET: Final = math.radians(1.0)
"""Phase at vanishing frequency beyond which a calibration is refused; a resistor has none."""
CERTAIN: Final = 5.0
"""Standard deviations beyond which an offset or a row is no accident."""
LARGEST_RESIDUAL: Final = 0.05
"""Relative root mean square of what a resistor and a capacitor miss beyond which the spectrum is that of something else."""
_NO_SUPPORT: Final = 10.0
"""Difference of the criterion of Akaike beyond which the data leave a causal part no support."""
_WIDEST: Final = math.radians(45.0)
_LEAST_CONDUCTANCE: Final = 1e-15
_LEAST_CAPACITANCE: Final = 1e-18
_FEWEST: Final = 8
_FEWEST_KEPT: Final = 0.8


def fit_parallel_part(frequency: ArrayLike, impedance: ArrayLike) -> ParallelPart:
    """Fit a resistor and a capacitor in parallel to an impedance spectrum, and judge the calibration by it.

    Z = R exp(j phi)/(1 + j w R C): the constant phase phi is the calibration's. A pair of R and C alone
    absorbs part of it with a small residual, and gives a wrong C. Rows far from the others are left out. A
    phase that does not vanish at low frequency is refused.
    """
    grid, data = np.asarray(frequency, dtype=float), np.asarray(impedance, dtype=complex)
    if grid.ndim != 1 or grid.shape != data.shape or grid.size < _FEWEST:
        raise InputError(f"frequency, impedance: expected two rows of the same length, {_FEWEST} or more")
    if not (np.isfinite(grid).all() and (grid > 0).all() and np.isfinite(data).all() and (data != 0).all()):
        raise InputError("frequency, impedance: expected finite numbers, frequencies and moduli above 0")
    found = ParallelPart.of(grid, data)
    problems = []
    if found.has_phase_offset:
        problems.append(
            f"impedance: the phase tends to {math.degrees(found.phase_offset):.3g} degrees at low frequency, where that of a"
            f" resistor vanishes; more than {math.degrees(LARGEST_PHASE_OFFSET):g} degree is a bad calibration, and the"
            f" {found.capacitance:.3g} F found here would be wrong: calibrate with a resistor of the same size and measure again"
        )
    if found.residual > LARGEST_RESIDUAL:
        problems.append(
            f"impedance: a resistor and a capacitor in parallel miss it by {found.residual:.2g} of its modulus, more than"
            f" {LARGEST_RESIDUAL:g}: it is another part"
        )
    refuse(problems)
    return found


@dataclass(frozen=True, kw_only=True)
class ParallelPart:
    """A resistor [ohm] and a capacitor [F, leads included] in parallel, measured with a constant error of the phase [rad].

    By least squares of the relative deviation; `missed` is that of each row, complex. Rows far from the
    others are left out of `kept`.
    """

    frequency: Real
    kept: np.ndarray
    resistance: float
    capacitance: float
    phase_offset: float
    missed: Complex

    @classmethod
    def of(cls, frequency: Real, impedance: Complex) -> ParallelPart:
        """Search the phase; for each phase the best resistor and capacitor are known."""
        from scipy.optimize import minimize_scalar

        kept = np.ones(frequency.size, bool)
        for _ in range(3):

            def squares(phase: float, kept: np.ndarray = kept) -> float:
                return cls._at(frequency, impedance, kept, phase).mean_square

            found = minimize_scalar(
                squares, bounds=(-_WIDEST, _WIDEST), method="bounded", options={"xatol": 1e-8}
            )
            best = cls._at(frequency, impedance, kept, float(found.x))
            size = np.abs(best.missed)
            kept = size <= CERTAIN * max(1.4826 * float(np.median(size[kept])), 1e-6)
            if (kept == best.kept).all():
                break
        return best

    @classmethod
    def _at(cls, frequency: Real, impedance: Complex, kept: np.ndarray, phase: float) -> ParallelPart:
        turned, weight = np.exp(1j * phase) / impedance, np.abs(impedance)
        turns = 2 * math.pi * frequency
        conductance = np.sum((turned.real * weight**2)[kept]) / np.sum((weight**2)[kept])
        capacitance = np.sum((turned.imag * turns * weight**2)[kept]) / np.sum((turns * weight)[kept] ** 2)
        conductance, capacitance = max(conductance, _LEAST_CONDUCTANCE), max(capacitance, _LEAST_CAPACITANCE)
        return cls(
            frequency=frequency, kept=kept,
            resistance=float(1 / conductance), capacitance=float(capacitance), phase_offset=phase,
            missed=(turned - conductance - 1j * turns * capacitance) * weight,
        )  # fmt: skip

    @property
    def mean_square(self) -> float:
        """Mean square of the relative deviation of the rows that are kept."""
        return float(np.mean(np.abs(self.missed[self.kept]) ** 2))

    @property
    def residual(self) -> float:
        """Relative root mean square of the impedance that the part misses, offset included."""
        return math.sqrt(self.mean_square)

    @property
    def estimate(self) -> LeastSquaresEstimate:
        """The parameters with their covariance, by the derivatives of the logarithm of the impedance."""
        turns, missed = 2j * math.pi * self.frequency[self.kept], self.missed[self.kept]
        loaded = 1 + turns * self.resistance * self.capacitance
        slopes = np.stack(
            [1 / (self.resistance * loaded), -turns * self.resistance / loaded, np.full(turns.size, 1j)], 1
        )
        values = {name: getattr(self, name) for name in ("resistance", "capacitance", "phase_offset")}
        found = LeastSquaresEstimate(
            values=values, sum_of_squares=math.nan, count=0, noise_is_known=False, evaluations=0, converged=True
        )  # fmt: skip
        left, slopes = (np.concatenate([each.real, each.imag]) for each in (missed, slopes))
        return found.judged(left, slopes, {name: FreeParameter(start=at) for name, at in values.items()})

    @property
    def has_phase_offset(self) -> bool:
        """Whether the constant phase is larger than a calibration may leave, and no accident."""
        deviation = self.estimate.standard_deviations["phase_offset"]
        return abs(self.phase_offset) > max(LARGEST_PHASE_OFFSET, CERTAIN * deviation)


@dataclass(frozen=True, kw_only=True)
class PhaseOffset:
    """A constant phase error [rad] of an instrument.

    `misfit` is the relative root mean square by which a resistor and a capacitor in parallel, turned by the
    phase, miss the spectrum; `inconsistent` that by which the same rows miss the Kramers-Kronig relations.
    """

    phase: float
    misfit: float
    inconsistent: float

    def sentence(self) -> str:
        """Return what the spectrum shows."""
        return (
            f"the spectrum is that of a resistor and a capacitor in parallel with a constant phase of"
            f" {math.degrees(self.phase):.3g} degrees (misfit {100 * self.misfit:.2g} %), which no resistor or capacitor has;"
            f" causal parts miss it by {100 * self.inconsistent:.2g} %"
        )


def phase_offset(frequency: Real, impedance: Complex) -> PhaseOffset | None:
    r"""Find a constant phase error in the impedance of a part that is a resistor and a capacitor in parallel; None without it.

    Fitted to the admittance by least squares of the relative deviation: :math:`Y = e^{-j\varphi}(1/R +
    j\omega C)`. A modulus that does not depend on the frequency excludes a phase: by the Kramers-Kronig
    relations, a phase of :math:`\varphi` belongs to a modulus proportional to :math:`\omega^{2\varphi/\pi}`.
    A causal part is excluded if the likelihood of the data under it, with the misfit of the Kramers-Kronig
    test, is lower by more than 10 in twice the logarithm. Rows far from the others are omitted; fewer than 8
    rows, and a phase of at most 1 degree or 5 standard deviations, show no error.
    """
    if frequency.size < _FEWEST or np.unique(frequency).size < frequency.size or not np.all(impedance):
        return None
    part = ParallelPart.of(frequency, impedance)
    kept, count = part.kept, int(np.count_nonzero(part.kept))
    if kept.mean() < _FEWEST_KEPT or count < _FEWEST:
        return None
    misfit = math.sqrt(part.mean_square * count / (count - 1.5))  # by three parameters of complex numbers
    if misfit > LARGEST_RESIDUAL or not part.has_phase_offset:
        return None
    chosen, grid = 1 / impedance[kept], frequency[kept]
    try:
        inconsistent = kramers_kronig_residual(grid, chosen.imag / (2 * math.pi * grid * eps0), chosen.real)
    except InputError:
        return None
    if 4 * count * math.log(inconsistent / misfit) <= _NO_SUPPORT:
        return None
    return PhaseOffset(phase=part.phase_offset, misfit=misfit, inconsistent=inconsistent)


@dataclass(frozen=True, kw_only=True)
class ImportedMaterial:
    """A material made of a measured spectrum; the thickness is None if a permittivity was measured and none given."""

    material: Tabulated
    thickness: float | None
    history: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]

    def to_toml(self, layer: str = "stratum_corneum") -> str:
        """Write the material as the table ``stack.<layer>``, to be put into a scenario in place of its layer of this name."""
        lines = [*self.history, *(f"{each.state}: {each.text}" for each in self.diagnostics)]
        content = {"model": "Tabulated", "conductivity": exact_text(self.material.conductivity, "S/m")}
        for name in ("frequency_samples", "permittivity_samples", "loss_samples"):
            content[name] = getattr(self.material, name).values.tolist()
        return layer_toml("A measured material", lines, layer, self.thickness, content)


def layer_toml(what: str, lines: Sequence[str], layer: str, thickness: float | None, material: Any) -> str:
    """Write a material as the table of a layer of a scenario, with lines about it as comments."""
    import tomlkit

    document = tomlkit.document()
    use = f"{what}; put these tables into a scenario in place of its layer of this name."
    for line in (use, *lines):
        document.add(tomlkit.comment(" ".join(line.split())))
    stack, found = tomlkit.table(is_super_table=True), tomlkit.table()
    if thickness is not None:
        found.add("thickness", exact_text(thickness, "m"))
    found.add("material", material)
    stack.add(layer, found)
    document.add("stack", stack)
    return tomlkit.dumps(document)


@dataclass(frozen=True, kw_only=True)
class SpectrumRecipe:
    """How files of spectra are read: the electrodes and the fixture of the sample, and the columns.

    Parameters
    ----------
    area : str or float, optional
        Area of the electrode or contact [m2]; needed for an impedance.
    thickness : str or float, optional
        Thickness of the sample [m]; needed for an impedance.
    series_resistance : str or float
        Resistance of leads, electrodes and gel in series with the sample [ohm], subtracted from the impedance.
    parallel_capacitance : str or float, optional
        Capacitance of the fixture parallel to sample and series resistance [F], subtracted from the admittance first.
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
    """

    area: str | float | None = None
    thickness: str | float | None = None
    series_resistance: str | float = 0.0
    parallel_capacitance: str | float | None = None
    columns: Mapping[str, str] | None = None
    reader: str = ""
    delimiter: str | None = None
    decimal_comma: bool | None = None
    part: str | None = None


def import_material(
    path: str | Path, recipe: SpectrumRecipe | None = None, *, conductivity: str | float = 0.0
) -> ImportedMaterial:
    r"""Import a measured impedance or permittivity spectrum as a material.

    Parameters
    ----------
    path : str or Path
        Any file that a reader takes.
    recipe : SpectrumRecipe, optional
        How it is read, where this is not plain: area and thickness of a sample whose impedance was measured, columns.
    conductivity : str or float
        Conductivity at zero frequency [S/m], which no spectrum determines; between 0 and the bound that a diagnostic states.

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
    known = vars(recipe or SpectrumRecipe())
    sample = read_sample(
        path, SpectrumRecipe(**{name: former_value(name, value) for name, value in known.items()})
    )
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


@dataclass(frozen=True, kw_only=True)
class SampleSpectrum:
    """The permittivity of a sample over frequency.

    - `frequency`: increasing, above 0 [Hz]; a frequency may occur several times.
    - `permittivity`: relative, eps' - j eps'', conduction included.
    - `thickness`: None if a permittivity was measured and no thickness given.
    - `per_farad`: permittivity of the sample whose capacitance is one farad; 0 if a permittivity was
      measured.
    """

    frequency: Real
    permittivity: Complex
    thickness: float | None
    history: tuple[str, ...]
    diagnostics: tuple[Diagnostic, ...]
    per_farad: float = 0.0


def read_sample(
    path: str | Path, recipe: SpectrumRecipe, *, fixture_capacitance: float = 0.0
) -> SampleSpectrum:
    """Read the permittivity of a sample from a measured impedance or permittivity spectrum.

    `fixture_capacitance` [F], as a reference measured in the fixture shows it, is subtracted from an
    admittance like `parallel_capacitance`. An impedance that shows that the instrument is badly calibrated is
    refused.
    """
    place, area, thickness = Path(path), recipe.area, recipe.thickness
    table, number = split_part(recipe.part)
    recorded = read_recorded(
        place,
        part=table,
        reader=recipe.reader,
        delimiter=recipe.delimiter,
        decimal_comma=recipe.decimal_comma,
    )
    spectrum = spectrum_of(recorded, columns=recipe.columns, spectrum=number)
    if (count := np.unique(spectrum.frequency).size) < FEWEST:
        raise InputError(
            f"the spectrum has {count} frequencies; a material needs {FEWEST} or more", path=place
        )
    depth = None if thickness is None else number_of("thickness", thickness, "m", above=True)
    history = [f"spectrum of {place.name}: {spectrum.read_as}"]
    resistance = number_of("series_resistance", recipe.series_resistance, "ohm")
    capacitance = number_of("parallel_capacitance", recipe.parallel_capacitance or 0.0, "F")
    per_farad, permittivity = 0.0, spectrum.permittivity
    if spectrum.impedance is not None:
        if offset := phase_offset(spectrum.frequency, spectrum.impedance):
            raise InputError(
                f"badly calibrated: {offset.sentence()}. Calibrate the instrument with a resistor of the same size and measure"
                " again",
                path=place,
            )
        surface, depth = _dimensions(area, depth)
        history.append(
            f"area {format_quantity(surface, 'm2')}, thickness {format_quantity(depth, 'm')}, without fringe field"
        )
        per_farad, turns = depth / (eps0 * surface), 2j * np.pi * spectrum.frequency
        impedance = spectrum.impedance / (surface if spectrum.times_area else 1.0)
        if parallel := capacitance + fixture_capacitance:
            history.append(f"fixture of {format_quantity(parallel, 'F', digits=4)} in parallel subtracted")
        if resistance:
            history.append(f"{format_quantity(resistance, 'ohm')} in series subtracted")
        if fixture_capacitance:
            source = "measured in parallel with the reference resistor (--set parallel_capacitance=... states another one)"
            history.append(f"the capacitance of the fixture was {source}")
        sample = 1 / (1 / impedance - turns * parallel) - resistance
        permittivity = np.asarray(per_farad / (turns * sample))
    else:
        given = {"area": area, "series_resistance": resistance, "parallel_capacitance": capacitance}
        if surplus := [name for name, stated in given.items() if stated]:
            raise InputError(f"{surplus[0]}: the file holds a permittivity, which needs none; omit it")
    assert permittivity is not None
    return SampleSpectrum(
        frequency=spectrum.frequency,
        permittivity=permittivity,
        thickness=depth,
        history=tuple(history),
        diagnostics=tuple(about_parts(recorded, spectrum)),
        per_farad=per_farad,
    )


def _dimensions(area: str | float | None, depth: float | None) -> tuple[float, float]:
    missing = [name for name, value in (("area", area), ("thickness", depth)) if value is None]
    if missing or area is None or depth is None:
        raise InputError(
            f"{name}: an impedance becomes a permittivity by area and thickness of the sample; state it, such as"
            f" {name} = '{'1 cm2' if name == 'area' else '200 um'}' (--{name})"
            for name in missing
        )
    return number_of("area", area, "m2", above=True), depth


def number_of(name: str, value: str | float, unit: str, *, above: bool = False) -> float:
    """Read a number of 0 or more, or `above` 0, as text with a unit or in SI."""
    found = number_in(unit, name, value)
    if not math.isfinite(found) or found < 0 or (above and not found):
        raise InputError(f"{name} = {value}: expected {'more than 0' if above else '0 or more'}, in {unit}")
    return found
