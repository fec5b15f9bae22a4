"""``electrovib fit-material``, ``fit-power-law`` and ``fit-contact``: fits of tables."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.fit import share_of
from electrovib.apps.cli.import_ import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.terminal import answered, say, show_answer
from electrovib.core.errors import InputError
from electrovib.core.units import number_in

if TYPE_CHECKING:
    from electrovib.physics.half_space import Elastic
    from electrovib.physics.topography import SelfAffine


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
    from electrovib.view.files import written

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
    found = fit_material(files, SpectrumRecipe(**entries), errors=errors, **asked)
    show_answer(found)
    if output:
        say(written(output, lambda: found.document))


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

    entries = recipe_of(recipe, set, None, only=READING, of="the fit of a power law")
    entries.pop("columns", None)

    omitted = 0

    def fitted(**asked: Any) -> PowerLawFit:
        nonlocal omitted
        along, values, sessions, omitted = read_points(**asked, **entries)
        return fit_power_law(along, values, session=sessions)

    asked = options.given(files=files, x=x, y=y, session=session, output=output, force=force)
    answered(PowerLawFit, fitted, "fitting", asked)
    say(*_omitted(omitted))


def fit_contact(
    *,
    scenario: options.Scenario,
    files: options.Files,
    load: options.Needed,
    capacitance: options.Needed,
    roughness: options.Needed,
    body: options.Text = None,
    voltage: options.Names = None,
    measured: options.Names = None,
    points: Annotated[int | None, options.number("--points", int)] = None,
    draws: Annotated[int, options.number("--draws", int)] = 4,
    seed: Annotated[int, options.number("--seed", int)] = 0,
    recipe: options.Text = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    _models: options.Models = None,
    force: options.Flag = False,
) -> None:
    """Fit a rough contact to its capacitance over the load.

    Report rms height and modulus with their intervals; with --voltage the attraction that follows, without a free number.

    Parameters
    ----------
    scenario
        Area and layers of the contact: a TOML file, or a paper's scenario such as bau_2010/sine.
    files
        Tables of measured points.
    load : COLUMN
        Column of the load, with a unit where the file states none.
    capacitance : COLUMN
        Column of the capacitance, likewise.
    roughness : TABLE
        Shape of its spectrum: '{ hurst = 0.8, longest = "1 mm", roll_off = "0.5 mm", shortest = "0.1 mm" }'.
    body : TABLE
        What is bent: '{ modulus = "1 MPa", poisson = 0.5 }', which the search begins with, by default.
    voltage : VOLTAGE,...
        Constant voltages at which the attraction is predicted under the load of the scenario: '100 V,200 V'.
    measured : FORCE,...
        Measured attraction at each voltage, which the prediction is compared with.
    points : N
        Points along a side of the grid.
    draws : N
        Draws of the random phases of the roughness.
    seed : N
        Of the first draw.
    recipe : FILE.toml
        Recipe by which the tables are read.
    output : PLACE
        The contact, or with --voltage the prediction: a table (.csv), a page (.html), a figure, or a folder with all.

    Examples
    --------
    electrovib fit-contact pad.toml meter.csv --load 'load (N)' --capacitance 'C (pF)' --roughness '{ hurst = 0.8, ... }'
    """
    from electrovib.recordings.fit.contact import ContactFit, fit_contact
    from electrovib.recordings.fit.contact_prediction import ContactPrediction
    from electrovib.recordings.fit.power_law import read_points
    from electrovib.view.files import check_answer, save_answer, written

    entries = recipe_of(recipe, None, None, only=READING, of="the fit of a contact")
    entries.pop("columns", None)
    wanted = _wanted(voltage, measured)
    shape, bent = _roughness(roughness), _body(body)
    if output is not None:
        kind = ContactPrediction if voltage else ContactFit
        check_answer(kind, output, inputs=[Path(each) for each in files], force=force)
    loads, capacitances, _, omitted = read_points(
        files, x=load, y=capacitance, named=("--load", "--capacitance"), kinds=("N", "F"), **entries
    )
    found = fit_contact(
        options.changed(scenario, set),
        load=loads,
        capacitance=capacitances,
        roughness=shape,
        body=bent,
        points=points,
        draws=draws,
        seed=seed,
    )
    answers: list[ContactFit | ContactPrediction] = [found]
    if voltage:
        answers.append(found.predict(**wanted))
    for each in answers:
        show_answer(each)
    say(*_omitted(omitted))
    if output is not None:
        save_answer(answers[-1], output, force=force)
        say(written(output, lambda: answers[-1].document))


def _wanted(voltage: list[str] | None, measured: list[str] | None) -> dict[str, Any]:
    """Read the voltages of a prediction, and the force that was measured at each."""
    if measured and not voltage:
        raise InputError("is compared with a prediction: give --voltage too", path="--measured")
    voltages = [number_in("V", "--voltage", each) for each in voltage or ()]
    forces = [number_in("N", "--measured", each) for each in measured or ()]
    if not all(voltages):
        raise InputError("0 V attracts nothing: give voltages other than 0", path="--voltage")
    if forces and len(forces) != len(voltages):
        raise InputError(
            f"{len(forces)} forces for {len(voltages)} voltages: give one for each", path="--measured"
        )
    return {"voltage": voltages, "measured": forces or None}


def _omitted(rows: int) -> list[str]:
    """Say how many rows of the tables hold no number in a column that is read."""
    return [f"rows without a number, which are omitted: {rows}"] if rows else []


def _roughness(text: str) -> "SelfAffine":
    """Read the shape of a spectrum; the search begins with an rms height of 1 um unless it states one."""
    from electrovib.physics.topography import SelfAffine

    needed = ("hurst", "longest", "roll_off", "shortest")
    found = _table("--roughness", text, ("rms", *needed))
    if missing := [name for name in needed if name not in found]:
        raise InputError(f"without {', '.join(missing)}", path="--roughness", value=text)
    with _of_option("--roughness"):
        return SelfAffine(**{"rms": 1e-6} | found)


def _body(text: str | None) -> "Elastic":
    """Read a body; the search begins with a modulus of 1 MPa unless it states one."""
    from electrovib.physics.half_space import Elastic

    found = _table("--body", text, ("modulus", "poisson")) if text else {}
    with _of_option("--body"):
        return Elastic(**{"modulus": 1e6} | found)


@contextmanager
def _of_option(option: str) -> Iterator[None]:
    """Name the option in whose table a value is refused."""
    try:
        yield
    except InputError as error:
        raise InputError([problem.within(option) for problem in error.problems]) from None


def _table(option: str, text: str, known: tuple[str, ...]) -> dict[str, Any]:
    """Read an inline table with some of the known keys."""
    from electrovib.core.errors import nearest
    from electrovib.core.tables import read_changes

    found = read_changes([f"table={text}"])["table"]
    if not isinstance(found, dict):
        raise InputError(f"expected a table {{ {', '.join(known)} }}", path=option, value=text)
    if wrong := [name for name in found if name not in known]:
        raise InputError(f"{wrong[0]} is none of {', '.join(known)}.{nearest(wrong[0], known)}", path=option)
    return found
