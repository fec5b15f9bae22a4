"""The command that fits a rough contact to a capacitance prints what the functions return."""

import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.physics.roughness import LeakingSpots

SINE = "bau_2010/sine"
LOADS, CAPACITANCES = [0.1, 0.3, 1.0, 3.0], [255.0, 280.0, 330.0, 420.0]
TABLE = '{ hurst = 0.8, longest = "1 mm", roll_off = "0.25 mm", shortest = "0.25 mm" }'
COLUMNS = "--load 'load (N)' --capacitance 'C (pF)'"


@pytest.fixture
def asked(here):
    rows = "".join(f"{load},{value}\n" for load, value in zip(LOADS, CAPACITANCES, strict=True))
    (here / "c.csv").write_text(f"load (N),C (pF)\n{rows}")
    return f"fit-contact {SINE} c.csv {COLUMNS} --roughness '{TABLE}' --draws 2"


def fitted(changes, **body):
    rough = ev.SelfAffine(rms=1e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    return ev.fit_contact(
        ev.load(SINE, changes=changes),
        load=LOADS,
        capacitance=1e-12 * np.array(CAPACITANCES),
        roughness=rough,
        body=ev.Elastic(**{"modulus": 1e6} | body),
        draws=2,
        seed=3,
    )


def test_what_is_printed_and_written_is_what_the_functions_return_and_the_force_law_of_a_run(
    here, asked, said, table
):
    """Of a constant voltage between those of the table, across film and gap."""
    out = said(
        f"{asked} --seed 3 --set load.normal_force='0.2 N' --body '{{ poisson = 0.3 }}' --voltage '20 V,30 V,40 V'"
        " --measured 30mN,70mN,130mN -o out.csv"
    )
    found = fitted({"load.normal_force": 0.2}, poisson=0.3)
    predicted = found.predict(voltage=[20.0, 30.0, 40.0], measured=[0.03, 0.07, 0.13])
    for line in (*found.document.sentences, *predicted.document.sentences):
        assert line in out
    labels = [curve.label for curve in predicted.document.figures[0].curves]
    assert labels == [
        "draws",
        "predicted, with the range of draws",
        "measured",
    ]  # a band has no legend of its own
    rows = table(here / "out.csv")
    np.testing.assert_allclose([float(row["force"]) for row in rows], predicted.force)
    np.testing.assert_allclose([float(row["draw 2"]) for row in rows], predicted.forces[1])
    force = {"model": "TabulatedAttraction", "file": "out.csv"}
    trace = ev.run(SINE, set={"force": force, "drive": {"model": "Step", "level": 30.0}})
    assert trace.electrostatic_force.values[-1] == pytest.approx(predicted.force[1], rel=1e-3)


def test_without_a_voltage_the_contact_is_written(here, asked, said, table):
    assert "typical factor" not in said(f"{asked} --seed 3 -o out.csv")
    rows = table(here / "out.csv")
    np.testing.assert_allclose([float(row["fitted"]) for row in rows], fitted({}).fitted)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("--measured 1N", "--measured: is compared with a prediction: give --voltage too"),
        ("--voltage 1N", "--voltage = 1N: expected a voltage"),
        ("--voltage 1V --measured 1V", "--measured = 1V: expected a force"),
        ("--voltage 0V", "--voltage: 0 V attracts nothing"),
        ("--voltage 1V --measured 1N,2N", "--measured: 2 forces for 1 voltages: give one for each"),
        (
            "--body '{ modulos = 1e6 }'",
            "--body.modulos: unknown parameter",
        ),
        ("--body soft", "--body = soft: expected a table { name = value, ... }"),
        ("--body '{ modulus = -1 }'", "--body.modulus = -1"),
        ("--draws 0", "draws = 0"),
        ("-o out.gif", "written as"),
        ("--points 2048 --draws 32", "would take about"),
    ],
)
def test_what_is_wrong_is_one_sentence(asked, refused, wrong, words):
    before = asked.replace("--draws 2", "") if "--draws" in wrong else asked
    assert words in refused(f"{before} {wrong}")


def test_a_spectrum_that_is_not_whole_is_refused(asked, refused):
    assert tomllib.loads(f"x = {TABLE}")["x"]["hurst"] == 0.8
    short = asked.replace(', shortest = "0.25 mm"', "")
    assert "--roughness" in refused(short)
    assert "shortest: missing" in refused(short)
    assert "--roughness.hurst = 2.0: must lie between 0 and 1" in refused(asked.replace("0.8", "2.0"))


def test_columns_of_other_units_are_refused_by_their_option(here, asked, refused):
    """A voltage is no capacitance; a mass that weighs on a load column is the force of its weight."""
    (here / "v.csv").write_text("load (N);C (V)\n0.1;255e-12\n0.3;280e-12\n1;330e-12\n3;420e-12\n")
    told = refused(asked.replace("c.csv", "v.csv").replace("C (pF)", "C"))
    assert "--capacitance = C: it is in 'V', but a capacitance is needed" in told
    told = refused(
        asked.replace("--load 'load (N)'", "--load 'C (pF)'").replace("'C (pF)' --r", "'load (N)' --r")
    )
    assert "--load = C: it is in 'pF', but a force is needed" in told
    assert "--load = gone: the file has no such column" in refused(asked.replace("'load (N)'", "gone"))


def test_contacts_beyond_the_budget_are_refused_before_they_are_solved(asked, refused):
    words = "this contact would take about"
    assert words in refused(f"--budget '0.01 s' {asked}")
    with ev.budget(memory="0.1 MB"), pytest.raises(InputError, match=words):
        fitted({})
    found = fitted({})
    with ev.budget(time=0.01), pytest.raises(InputError, match=words):
        found.predict(voltage=np.linspace(1, 50, 64))
    rough = ev.SelfAffine(rms=1e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    with pytest.raises(InputError, match=words):
        ev.rough_contact(
            SINE, roughness=rough, body=ev.Elastic(modulus=1e6), points=2048, voltage=np.arange(64.0)
        )


def test_rows_without_a_number_are_told(here, asked, said):
    with (here / "c.csv").open("a") as file:
        file.write("2.0,nan\nnan,300\n")
    assert "rows without a number, which are omitted: 2\n" in said(asked)
    law = "fit-power-law c.csv --x 'load (N)' --y 'C (pF)'"
    assert "rows without a number, which are omitted: 2\n" in said(law)


@pytest.mark.usefixtures("blank_pictures")
def test_a_figure_says_that_it_is_one_of_several(here, asked, said):
    assert said(f"{asked} -o out.png").splitlines()[-1] == "written: out.png"
    assert "written: out.svg, one of" in said(f"compare {SINE} -o out.svg")
    assert "written: out.pdf, one of 3 figures; a folder has all of them" in said(f"run {SINE} -o out.pdf")
    assert "written: r.pdf, one of" in said("report bau_2010/sine -o r.pdf")


def spectra(here):
    """Write the impedance of plates with each capacitance, across film, skin and body, one file at each load."""
    frequency, files = np.geomspace(1e3, 1e5, 21), []
    for load, capacitance in zip(LOADS, CAPACITANCES, strict=True):
        gap = eps0 * 1e-4 / (1e-12 * capacitance) - 1e-6 / 3.9
        grid = {"frequency.low": 1e3, "frequency.high": 1e5, "frequency.samples": 21}
        pad = ev.load(SINE, changes={"stack.gap.thickness": gap, **grid})
        impedance = ev.simulate(pad, signals=["impedance"]).impedance.values
        rows = np.column_stack([frequency, np.abs(impedance), np.degrees(np.angle(impedance))])
        file = here / f"z{load}.csv"
        np.savetxt(file, rows, delimiter=",", header="frequency (Hz),size (ohm),turn (deg)", comments="")
        files.append(file.name)
    return files


BY_COLUMNS = "--column modulus='size [ohm]' --column phase='turn [deg]'"


def test_impedances_at_several_loads_are_read_as_capacitances(here, asked, said):
    files = spectra(here)
    loads = " ".join(f"--load {file}='{load} N'" for file, load in zip(files, LOADS, strict=True))
    spectral = asked.replace("c.csv", " ".join(reversed(files))).replace(COLUMNS, f"{loads} {BY_COLUMNS}")
    said(f"{spectral} -o spectra.csv")
    said(f"{asked} -o table.csv")
    from_spectra, from_table = (
        np.genfromtxt(here / name, delimiter=",", comments="#", skip_header=1)
        for name in ("spectra.csv", "table.csv")
    )
    np.testing.assert_allclose(from_spectra[1:], from_table[1:], rtol=1e-4)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (
            ("--load z3.0.csv=3N", ""),
            "--load: give the load of each of z0.1.csv, z0.3.csv, z1.0.csv, z3.0.csv once",
        ),
        (("=3N", ""), "--load z3.0.csv: expected FILE=LOAD for a spectrum, or --capacitance too"),
        (("=3N", "=3V"), "--load = 3V: expected a force"),
        (("turn [deg]", "turned"), "columns.phase = 'turned': the file has no such column"),
        (("--draws 2", "--set contact.area='1 mm2'"), "z0.1.csv.impedance[0]: its gap would be -"),
        (("--draws 2", "--capacitance 'C (pF)'"), "--load: with --capacitance give one column of the tables"),
    ],
)
def test_spectra_that_are_not_those_of_the_loads_are_refused(here, asked, refused, change, words):
    files = spectra(here)
    loads = " ".join(f"--load {file}={load:g}N" for file, load in zip(files, LOADS, strict=True))
    spectral = asked.replace("c.csv", " ".join(files)).replace(COLUMNS, f"{loads} {BY_COLUMNS}")
    assert words in refused(spectral.replace(*change))


def test_a_permittivity_and_columns_of_tables_are_refused(here, asked, refused):
    (here / "e.csv").write_text("frequency (Hz),permittivity,loss\n1000,4,0.1\n2000,4,0.1\n")
    spectral = asked.replace("c.csv", "e.csv").replace(COLUMNS, "--load e.csv=1N")
    assert "e.csv: the file holds a permittivity; the contact has an impedance" in refused(spectral)
    assert "--column: belongs to spectra" in refused(f"{asked} --column phase=turn")


def test_a_map_a_coated_body_and_spots_are_those_of_the_functions(here, asked, said):
    rough = ev.SelfAffine(rms=1e-6, hurst=0.8, longest=1e-3, roll_off=2.5e-4, shortest=2.5e-4)
    heights = rough.heights((16, 16), (1e-3, 1e-3), seed=2)
    np.save(here / "map.npy", heights)
    np.savetxt(here / "map.csv", heights, delimiter=",")
    skin = '{ film = { modulus = "20 MPa", poisson = 0.45 }, thickness = "20 um", below = { modulus = "1 MPa" } }'
    spots = '{ model = "LeakingSpots", resistivity = "100 Mohm m" }'
    out = {}
    for name in ("map.npy", "map.csv"):
        table = f'{{ heights = "{name}", spacing = "62.5 um", spots = {spots} }}'
        words = f"--roughness '{table}' --body '{skin}' --free rms,modulus"
        given = asked.replace(f"--roughness '{TABLE}' --draws 2", words)
        out[name] = said(f"{given} --voltage 30V --frequency 200Hz -o out.csv --force")
    found = ev.fit_contact(
        SINE,
        load=LOADS,
        capacitance=1e-12 * np.array(CAPACITANCES),
        roughness=ev.MeasuredHeights(values=heights, spacing=62.5e-6),
        body=ev.Coated(
            film=ev.Elastic(modulus=2e7, poisson=0.45), thickness=2e-5, below=ev.Elastic(modulus=1e6)
        ),
        free=["rms", "modulus"],
    )
    predicted = found.predict(voltage=[30.0], spots=LeakingSpots(resistivity=1e8), frequency=200.0)
    for line in (*found.document.sentences, *predicted.document.sentences):
        assert line in out["map.npy"]
    assert out["map.csv"] == out["map.npy"]


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        ("--free gap", "free = ['gap']: expected one or both of rms, modulus"),
        ("--frequency 1kHz", "--frequency: belongs to a prediction: give --voltage too"),
        ("--voltage 1V --frequency 1V", "--frequency = 1V: expected a frequency"),
        (
            "--body '{ film = { modulus = 1e6 } }'",
            "--body.thickness: missing",
        ),
        (
            "--body '{ film = 3, thickness = 1e-5, below = { modulus = 1 } }'",
            "--body.film = 3: expected a table of parameters of Elastic",
        ),
    ],
)
def test_what_is_wrong_in_a_body_or_spots_is_one_sentence(asked, refused, wrong, words):
    assert words in refused(f"{asked} {wrong}")


@pytest.mark.parametrize(
    ("table", "words"),
    [
        ("heights = 'map.csv'", "--roughness.spacing: missing"),
        ("heights = 'map.csv', spacing = 1e-6, hurst = 1", "--roughness.hurst: unknown parameter"),
        ("heights = 3, spacing = 1e-6", "--roughness.heights = 3: expected the name of a file"),
        ("heights = 'gone.csv', spacing = 1e-6", "gone.csv"),
        ("heights = 'c.csv', spacing = 1e-6", "--roughness.columns = 2"),
    ],
)
def test_a_map_that_is_none_is_refused(asked, refused, here, table, words):
    np.savetxt(here / "map.csv", np.eye(4), delimiter=",")
    assert words in refused(asked.replace(f"'{TABLE}'", f'"{{ {table} }}"'))


@pytest.mark.parametrize(
    ("spots", "more", "words"),
    [
        ('"IdleSpots"', "", "--roughness: spots belong to a prediction: give --voltage too"),
        ('"IdlSpots"', "--voltage 1V", "--roughness.spots"),
        ('{ model = "LeakingSpots" }', "--voltage 1V", "--roughness.spots.resistivity"),
        ("3", "--voltage 1V", "--roughness.spots"),
    ],
)
def test_spots_that_are_none_are_refused(asked, refused, spots, more, words):
    assert words in refused(f"{asked.replace('hurst', f'spots = {spots}, hurst')} {more}")


def test_idle_spots_attract_less(asked, said):
    idle = asked.replace("hurst", 'spots = "IdleSpots", hurst')
    told = said(f"{idle} --voltage 30V")
    assert "where faces touch they have 0 % of the field of spots that insulate" in told
