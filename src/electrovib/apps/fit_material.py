"""A dispersion fitted to files of measured spectra, as a material ready for a scenario."""

from __future__ import annotations

import contextlib
import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

from electrovib.core.budget import one_thread
from electrovib.core.errors import InputError, gathered, nearest, refuse
from electrovib.core.units import number_in
from electrovib.data.atomic import Form
from electrovib.data.registry import read_recorded
from electrovib.data.spectrum import spectrum_of, split_part
from electrovib.recordings.importing.own_material import SpectrumRecipe, read_sample
from electrovib.recordings.spectra.fitted import (
    InstrumentError,
    error_by_resistor,
    fit_samples,
)
from electrovib.recordings.spectra.fitted_material import FittedMaterial
from electrovib.recordings.spectra.material import forms_of
from electrovib.scenario import Scenario, Source, read_scenario
from electrovib.view.files import check_answer, save_answer

if TYPE_CHECKING:
    from electrovib.recordings.importing.own_material import SampleSpectrum


@dataclass(frozen=True, kw_only=True)
class SpectrumErrors:
    """What is known of the errors of measured spectra.

    Parameters
    ----------
    scatter : mapping of str to float, optional
        File to the relative standard deviation of its rows; of all files or of none. Without it all rows count alike.
    systematic : float, optional
        Relative standard uncertainty of the modulus that is common to all rows, dimensionless: that of the instrument, the area
        and the thickness.
    reference : tuple of file and str or float, optional
        Spectrum of a resistor measured with the same instrument, and its known value [ohm], as ``"51 kohm +- 1 %"`` with its
        tolerance: its deviation, with tolerance and noise, is the systematic error, and a bad calibration is refused. A phase
        without a unit is read as that of the sample. The capacitance in parallel with it is that of the fixture, which is
        subtracted from the samples unless `parallel_capacitance` is given (``0`` subtracts none).
    """

    scatter: Mapping[str, float] = field(default_factory=dict)
    systematic: float | None = None
    reference: tuple[str | Path, str | float] | None = None


@one_thread(with_scipy=True)
def fit_material(
    files: Sequence[str | Path] | str | Path,
    recipe: SpectrumRecipe | None = None,
    *,
    form: str = "auto",
    band: tuple[str | float, str | float] | None = None,
    errors: SpectrumErrors | None = None,
    loss: str = "measured",
    into: Source | None = None,
    layer: str = "stratum_corneum",
    output: str | Path | None = None,
    force: bool = False,
) -> FittedMaterial:
    """Fit a dispersion to measured impedance or permittivity spectra of one material.

    Parameters
    ----------
    files : str or Path, or a sequence of them
        Files that a reader takes; several are fitted together.
    recipe : SpectrumRecipe, optional
        How they are read, where this is not plain: area and thickness of a sample whose impedance was measured, columns.
    form : str
        ``auto``: the form with the smallest AICc among constant, constant phase, Debye, one and two Cole-Cole terms and
        Havriliak-Negami; or one of these, such as ``cole-cole``, ``cole-cole-2``, ``havriliak-negami``, ``prony-4``; ``gabriel``
        for four Cole-Cole terms.
    band : tuple of str or float, optional
        Lowest and highest frequency that is fitted [Hz].
    errors : SpectrumErrors, optional
        Scatter of the rows, and the systematic error of the instrument.
    loss : str
        What is known of the loss: ``measured`` in every file; ``none``, a material without loss, which by the Kramers-Kronig
        relations is without dispersion; or ``unknown``, where the permittivity alone is fitted, and the loss that follows from
        it is stated with its interval. Conduction shows in no permittivity: 0 is then taken, and said.
    into : str, Path, mapping, Scenario or xarray.Dataset, optional
        A scenario, as for `electrovib.load`, into whose layer the material is put; `output` is then this scenario.
    layer : str
        Name of the layer.
    output : str or Path, optional
        What to write: ``.toml``, the material or the scenario with it; ``.html``, a figure, a table; without a suffix a folder
        with all.
    force : bool
        Whether a file that this package did not write may be replaced.

    Returns
    -------
    fitted : FittedMaterial
        Material, parameters with the statistical interval and the systematic error beside each other, history and diagnostics.

    Raises
    ------
    InputError
        For mistakes, for a bad calibration, and for spectra that no form represents; nothing has been written then.
    """
    names = [Path(each) for each in ([files] if isinstance(files, (str, Path)) else files)]
    recipe, known = recipe or SpectrumRecipe(), errors or SpectrumErrors()
    samples: dict[str, SampleSpectrum] = {}
    problems: list[str] = []
    base: Scenario | None = None
    with gathered(problems):
        forms_of(form)
    with gathered(problems):
        base = None if into is None else _with_layer(read_scenario(into), layer)
    error = None
    with gathered(problems):
        error = _error(known, names, recipe)
    fixture = 0.0 if error is None else error.fixture_capacitance
    for path in names:
        with gathered(problems):
            sample = read_sample(path, recipe, fixture_capacitance=fixture)
            name = path.name if path.name not in samples else str(path)
            samples[name] = sample if band is None else _within(sample, band)
    with gathered(problems):
        inputs = [*names, *([] if known.reference is None else [Path(known.reference[0])])]
        _check_output(output, inputs, as_scenario=base is not None, force=force)
    refuse([*problems, *([] if names else ["files: name at least one spectrum"])])
    scatter = {
        Path(file).name if str(file) not in samples else str(file): each
        for file, each in known.scatter.items()
    }
    found = fit_samples(samples, form=form, noise=scatter, error=error, loss=loss)
    found = dataclasses.replace(found, into=base, layer=layer)
    if output is not None:
        save_answer(found, output, force=force)
    return found


def _with_layer(scenario: Scenario, layer: str) -> Scenario:
    if layer not in scenario.stack.layers:
        meant = nearest(layer, scenario.stack.layers)
        raise InputError(f"layer = '{layer}': the scenario has no such layer.{meant}")
    return scenario


def _within(sample: SampleSpectrum, band: tuple[str | float, str | float]) -> SampleSpectrum:
    """Keep the rows within a band, ends included."""
    low, high = (number_in("Hz", "band", each) for each in band)
    kept = (sample.frequency >= low * (1 - 1e-9)) & (sample.frequency <= high * (1 + 1e-9))
    if kept.sum() < 4:
        raise InputError(
            f"band = {low:g} Hz to {high:g} Hz: {kept.sum()} rows are within it; a fit needs 4 or more"
        )
    return dataclasses.replace(
        sample, frequency=sample.frequency[kept], permittivity=sample.permittivity[kept]
    )


def _error(known: SpectrumErrors, names: Sequence[Path], recipe: SpectrumRecipe) -> InstrumentError | None:
    """Return the systematic error, as declared and as measured with a resistor, the larger modulus of both."""
    systematic = known.systematic
    declared = None if systematic is None else InstrumentError(gain=systematic, words="as declared")
    if known.reference is None:
        return declared
    path, value = known.reference
    options = {name: getattr(recipe, name) for name in ("reader", "delimiter", "decimal_comma")}
    columns, fixture = recipe.columns, recipe.parallel_capacitance
    units = (_phase_unit(name, columns, recipe.part, options) for name in names)
    spectrum = spectrum_of(
        read_recorded(Path(path), **options), columns=columns, phase_unit=next(filter(None, units), "")
    )
    if spectrum.impedance is None:
        raise InputError("reference: the file holds a permittivity; a resistor has an impedance", path=path)
    try:
        resistance, tolerance = _known(value)
        found = error_by_resistor(
            spectrum.frequency, spectrum.impedance, resistance=resistance, tolerance=tolerance
        )
    except InputError as error:
        raise InputError(f"{Path(path).name}: {each}" for each in error.problems) from None
    found = found if fixture is None else found.without_fixture()
    if declared is None or declared.gain <= found.gain:
        return found
    return dataclasses.replace(found, gain=declared.gain, words=f"modulus as declared; {found.words}")


def _phase_unit(
    name: Path, columns: Mapping[str, str] | None, part: str | None, options: Mapping[str, Any]
) -> str:
    """Return the unit of the phase of a sample; empty where it has none or cannot be read, which is said elsewhere."""
    with contextlib.suppress(InputError):
        table, number = split_part(part)
        recorded = read_recorded(name, part=table, **options)
        return spectrum_of(recorded, columns=columns, spectrum=number).phase_unit
    return ""


def _known(value: str | float) -> tuple[float, float]:
    """Read the value of a resistor [ohm] and the limit of its relative deviation, 0 if it is not stated."""
    text, sign, share = str(value).replace("\N{PLUS-MINUS SIGN}", "+-").partition("+-")
    resistance = number_in("ohm", "reference", text if isinstance(value, str) else value)
    if not sign:
        return resistance, 0.0
    if share.strip().endswith("%"):
        return resistance, number_in("1", "reference", share.strip().removesuffix("%")) / 100
    return resistance, number_in("ohm", "reference", share) / resistance


def _check_output(
    output: str | Path | None, inputs: Sequence[Path], *, as_scenario: bool, force: bool
) -> None:
    """Check, before the fit, that its result can be written."""
    if output is not None:
        form = {"material.toml": Form.SCENARIO} if as_scenario else {}
        check_answer(FittedMaterial, output, more=form, inputs=inputs, force=force)
