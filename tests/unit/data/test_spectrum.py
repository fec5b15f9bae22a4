"""Impedance and permittivity from tables with any headings, of one spectrum and of several."""

from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.data.readers.text import read_laboratory_text
from electrovib.data.registry import read_recorded
from electrovib.data.spectrum import spectrum_of
from electrovib.recordings.importing import list_columns

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
GRID = np.geomspace(10, 1e5, 12)
Z = 5e4 / (1 + 2j * np.pi * GRID * 5e4 * 1e-9)
EPS = 1000 / (1 + 2j * np.pi * GRID * 1e-4) + 5 - 1j * 1e-5 / (2 * np.pi * GRID * eps0)
SIGMA = -EPS.imag * 2 * np.pi * GRID * eps0
TABLES = {
    "Frequency,Impedance,Phase": (GRID, abs(Z), np.degrees(np.angle(Z))),
    "freq (kHz);|Z| (ohm);theta (rad)": (GRID / 1e3, abs(Z), np.angle(Z)),
    "f [Hz],Z' [kohm],Z'' [kohm]": (GRID, Z.real / 1e3, Z.imag / 1e3),
    "freq/Hz,Re(Z)/Ohm,-Im(Z)/Ohm": (GRID, Z.real, -Z.imag),
    "Frequency (Hz),Z_real,Z_imag": (GRID, Z.real, Z.imag),
    "omega,Zre,Zim": (2 * np.pi * GRID, Z.real, Z.imag),
}  # fmt: skip
PERMITTIVITIES = {
    "Frequency (Hz),Permittivity,Loss Factor,Conductivity (S/m)": (GRID, EPS.real, -EPS.imag, SIGMA),
    "f,eps',sigma [mS/m]": (GRID, EPS.real, SIGMA * 1e3),
    "freq,epsilon',epsilon''": (GRID, EPS.real, -EPS.imag),
    "frequency (Hz),permittivity,resistivity (ohm m)": (GRID, EPS.real, 1 / SIGMA),
    "f [kHz];eps_r;rho [kohm cm]": (GRID / 1e3, EPS.real, 0.1 / SIGMA),
    "Frequency/Hz,Permittivity,Resistivity/Ohm.m": (GRID, EPS.real, 1 / SIGMA),
    "f [Hz],eps,whatever [Ω·m]": (GRID, EPS.real, 1 / SIGMA),
    "f,er',some current [uS/cm]": (GRID, EPS.real, SIGMA * 1e4),
    "freq,Permittivity,AC Conductivity/S/m": (GRID, EPS.real, SIGMA),
    "freq,Relative Permittivity,Loss Tangent": (GRID, EPS.real, -EPS.imag / EPS.real),
    "freq,permittivity,tan(delta)": (GRID, EPS.real, -EPS.imag / EPS.real),
    "freq,er,D,d [mm]": (GRID, EPS.real, -EPS.imag / EPS.real, 2 + 0 * GRID),
    "freq,eps',tan_d [%]": (GRID, EPS.real, -100 * EPS.imag / EPS.real),
    "freq,dielectric constant,Dissipation Factor,loss index": (
        GRID,
        EPS.real,
        -EPS.imag / EPS.real,
        -EPS.imag,
    ),
    "f,real permittivity,imaginary permittivity": (GRID, EPS.real, -EPS.imag),
    "f,real part of the permittivity,imag. permittivity": (GRID, EPS.real, -EPS.imag),
    "f [Hz],permittivity [nF/m],conductivity [mS/m]": (GRID, EPS.real * eps0 * 1e9, SIGMA * 1e3),
}


def table(tmp_path, heading, columns):
    separator = ";" if ";" in heading else ","
    lines = [separator.join(f"{value:.12e}" for value in row) for row in zip(*columns, strict=True)]
    (tmp_path / "a.csv").write_text("\n".join([heading, *reversed(lines)]), encoding="utf-8")
    return read_laboratory_text(tmp_path / "a.csv")


@pytest.mark.parametrize("heading", TABLES | PERMITTIVITIES)
def test_impedances_and_permittivities(tmp_path, heading):
    found = spectrum_of(table(tmp_path, heading, (TABLES | PERMITTIVITIES)[heading]))
    np.testing.assert_allclose(found.frequency, GRID, rtol=1e-11)
    of, known = (found.impedance, Z) if heading in TABLES else (found.permittivity, EPS)
    np.testing.assert_allclose(of, known, rtol=1e-10)
    assert not found.lossless


def test_a_permittivity_without_loss_is_said_to_be_one(tmp_path):
    found = spectrum_of(table(tmp_path, "f,permittivity", (GRID, EPS.real)))
    assert found.lossless
    np.testing.assert_allclose(found.permittivity, EPS.real, rtol=1e-11)
    other = spectrum_of(table(tmp_path, "f,permittivity,noise", (GRID, EPS.real, SIGMA)))
    assert other.lossless
    assert other.read_as == "frequency: 'f', permittivity: 'permittivity'; columns not used: 'noise'"


def test_columns_may_be_stated(tmp_path):
    recorded = table(tmp_path, "a,b,c", (GRID, Z.real, Z.imag))
    with pytest.raises(InputError, match=r"no column is the frequency; the file has 'a', 'b', 'c'"):
        spectrum_of(recorded)
    stated = {"frequency": "a", "real": "b", "imaginary": "c"}
    np.testing.assert_allclose(spectrum_of(recorded, columns=stated).impedance, Z, rtol=1e-11)
    with pytest.raises(InputError, match="no such column; it has a, b, c"):
        spectrum_of(recorded, columns={"frequency": "d"})


@pytest.mark.parametrize(
    ("heading", "columns", "words"),
    [
        ("f,|Z|,phase", (abs(Z), np.angle(Z)), "degrees or radians"),
        ("f,|Z|", (abs(Z),), "neither modulus and phase"),
        ("f [V],|Z|,phase [deg]", (abs(Z), np.angle(Z)), "not a unit of Hz"),
        (
            "f,eps',loss factor,sigma",
            (EPS.real, -EPS.imag, 2 * SIGMA),
            r"factor and conductivity .* differ by 0\.5",
        ),
        (
            "f,eps',sigma,rho",
            (EPS.real, SIGMA, 1.05 / SIGMA),
            r"and resistivity of the table differ by 0\.04",
        ),
        ("f,eps',loss factor,loss tangent", (EPS.real, -EPS.imag, -EPS.imag), "loss factor and loss tangent"),
        ("f,eps',resistivity [ohm]", (EPS.real, 1 / SIGMA), "'ohm' is not a unit of ohm m"),
        ("f,eps',resistivity [ohm m]", (EPS.real, 0 * SIGMA), "resistivity has to be above 0"),
        ("f,permittivity [V],sigma", (EPS.real, SIGMA), "'V' is not a unit of 1"),
    ],
)
def test_what_is_ambiguous_is_refused(tmp_path, heading, columns, words):
    with pytest.raises(InputError, match=words):
        spectrum_of(table(tmp_path, heading, (GRID, *columns)))


@pytest.mark.skipif(not FOLDER.exists(), reason="needs shared/data, which is not part of the repository")
@pytest.mark.parametrize(
    ("name", "columns"),
    [
        ("Cal10k_51k.csv", {"phase": "Phase [deg]"}),  # of a bare resistor: it could be either
        ("Cal10k_51kp33.csv", {}),
        ("rcal_10k_20k_par101.csv", {}),
        ("gabriel_measured_skin_dry.txt", {}),
    ],
)
def test_real_files(name, columns):
    found = spectrum_of(read_laboratory_text(FOLDER / name), columns=columns)
    assert found.frequency.size in (51, 156)
    assert (found.permittivity is not None) == name.startswith("gabriel")


G = np.geomspace(1e5, 10, 29)


def impedance(number, grid=G):
    return 100 * number + 5e4 / (1 + 2j * np.pi * grid * 5e4 * 1e-9 * number)


def spectra(path, *numbers, turned=()):
    rows = ["freq/Hz,Re(Z)/Ohm,-Im(Z)/Ohm"]
    for number in numbers:
        grid = G[::-1] if number in turned else G
        parts = zip(grid.tolist(), impedance(number, grid).tolist(), strict=True)
        rows += [f"{f!r},{z.real!r},{-z.imag!r}" for f, z in parts]
    path.write_text("\n".join(rows))
    return rows


@pytest.mark.parametrize("turned", [(), (2,), (1, 3)])
def test_each_spectrum_of_a_table_is_a_part(tmp_path, turned):
    path = tmp_path / "a.csv"
    spectra(path, 1, 2, 3, turned=turned)
    for part, number in ((None, 1), ("spectrum 1", 1), ("spectrum 2", 2), ("spectrum 3", 3)):
        found = ev.import_file(path, part=part)
        np.testing.assert_allclose(found.frequency, G[::-1])
        np.testing.assert_allclose(found.impedance, impedance(number)[::-1])
        others = ", ".join(f"spectrum {other}" for other in (1, 2, 3) if other != number)
        assert f"read: spectrum {number}; not read: {others}" in found.attrs["validity"]
        material = ev.import_material(path, part=part, area="1 cm2", thickness="1 mm")
        assert material.material.frequency_samples.values.size == 29
    with pytest.raises(InputError, match="3 spectra, spectrum 1 to spectrum 3"):
        ev.import_file(path, part="spectrum 4")
    with pytest.raises(InputError, match="not a spectrum"):
        ev.import_file(path, {"current": "Re(Z) [A]"}, step="1 ms", part="spectrum 2")
    listed = list_columns(path)
    assert "read: spectrum 1; not read: spectrum 2, spectrum 3; choose with --set part=..." in listed


def test_one_spectrum_in_any_order_is_whole_and_rows_of_no_impedance_are_omitted(tmp_path):
    path = tmp_path / "a.csv"
    head, *rows = spectra(path, 1)
    assert "not read" not in ev.import_file(path).attrs["validity"]
    path.write_text("\n".join([head, *np.random.default_rng(1).permutation(rows)]))
    np.testing.assert_allclose(ev.import_file(path).impedance, impedance(1)[::-1])
    path.write_text("\n".join([head, *(line for line in rows for _ in range(2))]))  # each measured twice
    assert ev.import_file(path).frequency.size == 58
    rows[4] = rows[4].split(",")[0] + ",0,0"
    path.write_text("\n".join([head, *rows]))
    assert ev.import_file(path).frequency.size == 28


@pytest.mark.parametrize("empty", ["modulus and phase", "modulus in part", "parts", "neither"])
def test_the_columns_that_are_filled_make_the_impedance(tmp_path, empty):
    """Before, an EC-Lab file with zeros in |Z| and phase was read as 0 + 0j."""
    z = impedance(1)
    modulus, phase = (
        (0 * abs(z), 0 * abs(z)) if empty == "modulus and phase" else (abs(z), np.degrees(np.angle(z)))
    )
    modulus[20:] *= empty != "modulus in part"
    parts = 0 * z if empty == "parts" else z
    rows = [
        "\t".join(f"{value:.8e}" for value in row)
        for row in zip(G, parts.real, -parts.imag, modulus, phase, strict=True)
    ]
    head = "EC-Lab ASCII FILE\nNb header lines : 3\nfreq/Hz\tRe(Z)/Ohm\t-Im(Z)/Ohm\t|Z|/Ohm\tPhase(Z)/deg\n"
    (tmp_path / "a.mpt").write_text(head + "\n".join(rows))
    found = spectrum_of(read_recorded(tmp_path / "a.mpt"))
    np.testing.assert_allclose(found.impedance, z[::-1], rtol=1e-6)
