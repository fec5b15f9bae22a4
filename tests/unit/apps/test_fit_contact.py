"""The command that fits a rough contact to a capacitance prints what the functions return."""

import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError

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


def test_what_is_printed_and_written_is_what_the_functions_return(here, asked, said, table):
    out = said(
        f"{asked} --seed 3 --set load.normal_force='0.2 N' --body '{{ poisson = 0.3 }}' --voltage '20 V,40 V'"
        " --measured 30mN,130mN -o out.csv"
    )
    found = fitted({"load.normal_force": 0.2}, poisson=0.3)
    predicted = found.predict(voltage=[20.0, 40.0], measured=[0.03, 0.13])
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


def test_the_prediction_is_the_force_law_of_a_run(here, asked, said):
    """Of a constant voltage between those of the table, across film and gap."""
    said(f"{asked} --seed 3 --set load.normal_force='0.2 N' --voltage '20 V,30 V,40 V' -o p.csv")
    expected = fitted({"load.normal_force": 0.2}).predict(voltage=[20.0, 30.0, 40.0]).force
    force = {"model": "TabulatedAttraction", "file": "p.csv"}
    trace = ev.run(SINE, set={"force": force, "drive": {"model": "Step", "level": 30.0}})
    assert trace.electrostatic_force.values[-1] == pytest.approx(expected[1], rel=1e-3)


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
            "--body: modulos is none of modulus, poisson. Did you mean 'modulus'?",
        ),
        ("--body soft", "--body = soft: expected a table { modulus, poisson }"),
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
    assert "without shortest" in refused(short)
    assert "--roughness.hurst = 2.0: a Hurst exponent" in refused(asked.replace("0.8", "2.0"))


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
