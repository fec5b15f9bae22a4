"""``electrovib fit-material`` and ``fit-power-law``: fits of tables, without a scenario."""

from pathlib import Path
from typing import Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.fit import share_of
from electrovib.apps.cli.import_ import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.terminal import say, show_answer
from electrovib.core.errors import InputError


def fit_material(
    *,
    files: options.Files,
    form: options.Text = "auto",
    band: options.Text = None,
    scatter: options.Texts = None,
    systematic: Annotated[float | None, options.number("--systematic")] = None,
    reference: options.Text = None,
    loss: options.Text = "measured",
    columns: options.Columns = None,
    recipe: options.Text = None,
    set: options.Changes = None,
    into: options.Text = None,
    layer: options.Text = None,
    output: options.Output = None,
    _style: options.Style = None,
    force: options.Flag = False,
) -> None:
    """Fit a dispersion to the spectra of a material.

    Report each parameter with its statistical interval and its systematic error.

    Parameters
    ----------
    files
        Spectra of impedance or permittivity of one material.
    form : FORM
        auto (by AICc), constant, constant-phase, debye, cole-cole, cole-cole-2, havriliak-negami, prony-4, gabriel ...
    band : LOW..HIGH
        Frequencies to fit: '100 Hz..100 kHz'.
    scatter : FILE=SHARE
        Relative standard deviation of the rows of a file, z.csv='1 %', of all files or of none; repeatable.
    systematic : SHARE
        Relative standard uncertainty of the modulus, common to all rows, '1 %'.
    reference : FILE=VALUE
        Spectrum of a known resistor, r.csv='51 kohm +- 1 %': gives systematic error and fixture; a bad one is refused.
    loss : measured|none|unknown
        Of permittivity without loss: a material without any, or the permittivity alone is fitted.
    set : KEY=VALUE
        Entry of the recipe: area='1 cm2', thickness='200 um', series_resistance='1 kohm', parallel_capacitance='2 pF' of the
        fixture, part, reader, delimiter, decimal_comma; repeatable.
    into : SCENARIO
        Scenario into which the material is put, as which it is written.
    output : PLACE
        The material, or the scenario with it, as .toml; a page (.html), a figure, or a folder with all.

    Examples
    --------
    electrovib fit-material z.csv --set area='1 cm2' --set thickness='200 um' -o my_skin.toml
    """
    from electrovib.apps.fit_material import SpectrumErrors, SpectrumRecipe, fit_material

    entries = recipe_of(recipe, set, columns, only=OF_SAMPLE, of="the fit of a material")
    asked = options.given(form=form, loss=loss, into=into, layer=layer, output=output, force=force)
    shares = dict(options.pair_of(text, "--scatter", "FILE=SHARE") for text in scatter or ())
    known: dict[str, Any] = {
        "scatter": {name: share_of(value, "--scatter") for name, value in shares.items()},
        "systematic": systematic,
    }
    if reference:
        known["reference"] = options.pair_of(reference, "--reference", "FILE=VALUE")
    if band:
        low, dots, high = (part.strip() for part in band.partition(".."))
        if not dots:
            raise InputError(f"--band {band}: expected LOW..HIGH, such as '100 Hz..100 kHz'")
        asked["band"] = low, high
    errors = SpectrumErrors(**known)
    show_answer(fit_material(files, SpectrumRecipe(**entries), errors=errors, **asked))
    if output:
        say(f"written: {output}")


def fit_power_law(
    *,
    files: options.Files,
    x: options.Needed,
    y: options.Needed,
    session: Annotated[str | None, typer.Option("--session-column")] = None,
    recipe: options.Text = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    force: options.Flag = False,
) -> None:
    """Fit a power law, such as that of force over voltage.

    Report the exponent with its interval, and its scatter between sessions.

    Parameters
    ----------
    files
        Tables of measured points.
    x : COLUMN
        Column of the voltage, or what else y is a power of, with a unit where the file states none.
    y : COLUMN
        Column of the force, or of another quantity, likewise.
    session : COLUMN
        Column with the number of the session of each point; by default each file is one.
    set : KEY=VALUE
        Entry of the recipe: part, reader, delimiter, decimal_comma; repeatable.
    output : PLACE
        A table (.csv), a page (.html), a figure, or a folder with all.

    Examples
    --------
    electrovib fit-power-law monday.csv tuesday.csv --x 'voltage (V)' --y 'force (mN)' -o law.csv
    """
    from electrovib.recordings.fit.power_law import PowerLawFit, fit_power_law, read_points
    from electrovib.view.files import check_answer, save_answer

    entries = recipe_of(recipe, set, None, only=READING, of="the fit of a power law")
    entries.pop("columns", None)
    if output is not None:
        check_answer(PowerLawFit, output, inputs=[Path(each) for each in files], force=force)
    along, values, sessions = read_points(files, **options.given(x=x, y=y, session=session), **entries)
    law = fit_power_law(along, values, session=sessions)
    if output is not None:
        save_answer(law, output, force=force)
    show_answer(law)
    if output:
        say(f"written: {output}")
