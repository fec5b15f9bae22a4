"""``electrovib fit-material``, ``fit-power-law`` and ``fit-contact``: fits of tables."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from electrovib.apps.cli import options
from electrovib.apps.cli.fit import share_of
from electrovib.apps.cli.import_ import OF_SAMPLE, READING, recipe_of
from electrovib.apps.cli.terminal import answered, say, show_answer
from electrovib.core.deprecation import former_value
from electrovib.core.errors import InputError
from electrovib.core.units import number_in

if TYPE_CHECKING:
    from electrovib.core.arrays import Real
    from electrovib.physics.roughness import ContactSpots
    from electrovib.scenario import Scenario


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
    from electrovib.apps.fit_material import SpectrumErrors, fit_material
    from electrovib.recordings.importing.own_material import SpectrumRecipe
    from electrovib.view.files import written

    entries = recipe_of(
        former_value("recipe", None), set, columns, only=OF_SAMPLE, of="the fit of a material"
    )
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
        say(written(output, lambda: found.document, found.files))


def fit_power_law(
    *,
    files: options.Files,
    x: options.Needed,
    y: options.Needed,
    session: Annotated[str | None, typer.Option("--session-column")] = None,
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

    entries = recipe_of(former_value("recipe", None), set, None, only=READING, of="the fit of a power law")
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
    load: Annotated[list[str], typer.Option()],
    capacitance: options.Text = None,
    roughness: options.Needed,
    body: options.Text = None,
    free: options.Names = None,
    voltage: options.Names = None,
    measured: options.Names = None,
    frequency: options.Text = None,
    draws: Annotated[int | None, options.number("--draws", int)] = None,
    seed: Annotated[int, options.number("--seed", int)] = 0,
    columns: options.Columns = None,
    recipe: options.Text = None,
    set: options.Changes = None,
    output: options.Output = None,
    _style: options.Style = None,
    force: options.Flag = False,
) -> None:
    """Fit a rough contact to its capacitance over the load.

    Or to its impedance at some loads. Report rms height and modulus with their intervals; with --voltage the attraction that
    follows, without a free number.

    Parameters
    ----------
    scenario
        Area and layers of the contact: a TOML file, or a paper's scenario such as bau_2010/sine.
    files
        Tables of measured points; or spectra of impedance, one at each load.
    load : COLUMN|FILE=LOAD
        Column of the load, with a unit where the file states none; of spectra the load of each, z.csv='0.5 N', repeatable.
    capacitance : COLUMN
        Column of the capacitance, likewise; without it the files are spectra.
    roughness : TABLE
        Shape of its spectrum: '{ hurst = 0.8, longest = "1 mm", roll_off = "0.5 mm", shortest = "0.1 mm" }'; or a measured map:
        '{ heights = "map.npy", spacing = "2 um" }', rows of heights in m. Where faces touch, spots = "IdleSpots",
        or { model = "LeakingSpots", resistivity = "100 Mohm m" }, have another field than insulating ones, for --voltage.
    body : TABLE
        What is bent: '{ modulus = "1 MPa", poisson = 0.5 }', which the search begins with, by default; with a film on it
        '{ film = { modulus = "100 MPa" }, thickness = "20 um", below = { modulus = "1 MPa" } }'.
    free : rms,modulus
        What is fitted: both of a spectrum, the modulus of a map; with rms the map is scaled.
    voltage : VOLTAGE,...
        Constant voltages at which the attraction is predicted under the load of the scenario: '100 V,200 V'.
    measured : FORCE,...
        Measured attraction at each voltage, which the prediction is compared with.
    frequency : FREQUENCY
        Of a sine whose root mean square the voltages are, on which leaking spots depend.
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
    from electrovib.recordings.fit.contact_draws import ContactPrediction
    from electrovib.view.files import check_answer, save_answer, written

    entries = recipe_of(recipe, None, columns, only=READING, of="the fit of a contact")
    wanted = _wanted(voltage, measured, frequency)
    (shape, spots), bent = _roughness(roughness), _body(body)
    if spots and not voltage:
        raise InputError("spots belong to a prediction: give --voltage too", path="--roughness")
    if output is not None:
        kind = ContactPrediction if voltage else ContactFit
        check_answer(kind, output, inputs=[Path(each) for each in files], force=force)
    known = options.changed(scenario, set)
    loads, capacitances, omitted = (
        _of_spectra(known, files, load, entries)
        if capacitance is None
        else _of_tables(files, load, capacitance, entries)
    )
    asked = options.given(free=free, points=former_value("points", None), draws=draws, seed=seed)
    found = fit_contact(known, load=loads, capacitance=capacitances, roughness=shape, body=bent, **asked)
    answers: list[ContactFit | ContactPrediction] = [found]
    if voltage:
        answers.append(found.predict(**wanted, spots=spots))
    for each in answers:
        show_answer(each)
    say(*_omitted(omitted))
    if output is not None:
        save_answer(answers[-1], output, force=force)
        say(written(output, lambda: answers[-1].document, answers[-1].files))


def _of_tables(
    files: list[str], load: list[str], capacitance: str, entries: dict[str, Any]
) -> tuple["Real", "Real", int]:
    """Read loads and capacitances from columns of tables, and how many rows lack one."""
    from electrovib.recordings.fit.power_law import read_points

    if len(load) > 1:
        raise InputError("with --capacitance give one column of the tables", path="--load")
    if entries.pop("columns", None):
        raise InputError("belongs to spectra: omit --capacitance, or --column", path="--column")
    loads, capacitances, _, omitted = read_points(
        files, x=load[0], y=capacitance, named=("--load", "--capacitance"), kinds=("N", "F"), **entries
    )
    return loads, capacitances, omitted


def _of_spectra(
    scenario: "Scenario", files: list[str], load: list[str], entries: dict[str, Any]
) -> tuple[list[float], list[float], int]:
    """Read an impedance from each file, and return its load and the capacitance of the contact."""
    from electrovib.data.registry import read_recorded
    from electrovib.data.spectrum import spectrum_of, split_part
    from electrovib.recordings.fit.contact_draws import contact_capacitance

    columns = entries.pop("columns", None)
    _, number = split_part(entries.pop("part", None))
    pairs = [
        options.pair_of(text, "--load", "FILE=LOAD for a spectrum, or --capacitance too") for text in load
    ]
    loads = {name: number_in("N", "--load", value) for name, value in pairs}
    if len(loads) < len(pairs) or set(loads) != set(files):
        raise InputError(f"give the load of each of {', '.join(files)} once", path="--load")
    capacitances = []
    for file in files:
        found = spectrum_of(read_recorded(Path(file), **entries), columns=columns, spectrum=number)
        if found.impedance is None:
            raise InputError("the file holds a permittivity; the contact has an impedance", path=file)
        try:
            each = contact_capacitance(scenario, frequency=found.frequency, impedance=found.impedance)
        except InputError as error:
            raise InputError([problem.within(file) for problem in error.problems]) from None
        capacitances.append(float(each))
    return [loads[file] for file in files], capacitances, 0


def _wanted(voltage: list[str] | None, measured: list[str] | None, frequency: str | None) -> dict[str, Any]:
    """Read the voltages of a prediction, their frequency, and the force that was measured at each."""
    if measured and not voltage:
        raise InputError("is compared with a prediction: give --voltage too", path="--measured")
    if frequency and not voltage:
        raise InputError("belongs to a prediction: give --voltage too", path="--frequency")
    voltages = [number_in("V", "--voltage", each) for each in voltage or ()]
    forces = [number_in("N", "--measured", each) for each in measured or ()]
    if not all(voltages):
        raise InputError("0 V attracts nothing: give voltages other than 0", path="--voltage")
    if forces and len(forces) != len(voltages):
        raise InputError(
            f"{len(forces)} forces for {len(voltages)} voltages: give one for each", path="--measured"
        )
    return {
        "voltage": voltages,
        "measured": forces or None,
        "frequency": number_in("Hz", "--frequency", frequency or 0.0),
    }


def _omitted(rows: int) -> list[str]:
    """Say how many rows of the tables hold no number in a column that is read."""
    return [f"rows without a number, which are omitted: {rows}"] if rows else []


def _roughness(text: str) -> "tuple[Any, ContactSpots | None]":
    """Read a roughness, by default a spectrum with an rms height of 1 um to begin with, and the spots where faces touch."""
    from electrovib.physics.roughness import ContactSpots
    from electrovib.physics.topography import Topography

    table = _table("--roughness", text)
    spots = table.pop("spots", None)
    if "heights" in table:
        table = {"model": "MeasuredHeights", "values": _map(table.pop("heights"))} | table
    elif "model" not in table:
        table = {"model": "SelfAffine", "rms": 1e-6} | table
    shape = _read(Topography, "--roughness", table)
    own = {"model": spots} if isinstance(spots, str) else spots
    return shape, None if own is None else _read(ContactSpots, "--roughness.spots", own)


def _map(file: object) -> "Real":
    """Read rows of heights [m]."""
    import numpy as np

    from electrovib.data.registry import read_recorded

    if not isinstance(file, str):
        raise InputError(
            "expected the name of a file, such as 'map.npy'", path="--roughness.heights", value=str(file)
        )
    return np.column_stack([each.values for each in read_recorded(Path(file)).channels])


def _body(text: str | None) -> Any:
    """Read a body, by default of one material; the search begins with a modulus of 1 MPa unless it states one."""
    from electrovib.physics.half_space import ElasticBody

    table = _table("--body", text) if text else {}
    if "model" not in table:
        is_coated = not table.keys().isdisjoint(("film", "thickness", "below"))
        table = ({"model": "Coated"} if is_coated else {"model": "Elastic", "modulus": 1e6}) | table
    return _read(ElasticBody, "--body", table)


def _table(option: str, text: str) -> dict[str, Any]:
    """Read an inline table."""
    from electrovib.core.tables import read_changes

    found = read_changes([f"table={text}"])["table"]
    if not isinstance(found, dict):
        raise InputError("expected a table { name = value, ... }", path=option, value=text)
    return found


def _read(kind: Any, option: str, table: Any) -> Any:
    """Read the table of a model, and name the option in whose table a value is refused."""
    from electrovib.core.model import read_model

    try:
        return read_model(kind, table)
    except InputError as error:
        raise InputError([problem.within(option) for problem in error.problems]) from None
