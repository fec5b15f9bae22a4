"""Impedance and permittivity from tables with any headings, of one spectrum and of several."""

from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.errors import InputError
from electrovib.data.readers.text import read_laboratory_text
from electrovib.data.recorded import recorded_of
from electrovib.data.registry import read_recorded
from electrovib.data.spectrum import spectrum_of
from electrovib.recordings.importing.import_file import list_columns

FOLDER = Path(__file__).parents[4] / "shared" / "data" / "skin_impedance"
GRID = np.geomspace(10, 1e5, 12)
R, C, W = 5e4, 1e-9, 2 * np.pi * GRID
Z = 1 / (1 / R + 1j * W * C)
EPS = 1000 / (1 + 2j * np.pi * GRID * 1e-4) + 5 - 1j * 1e-5 / (2 * np.pi * GRID * eps0)
SIGMA = -EPS.imag * 2 * np.pi * GRID * eps0
TABLES = {
    "Frequency,Impedance,Phase": (GRID, abs(Z), np.degrees(np.angle(Z))),
    "freq (kHz);|Z| (ohm);theta (rad)": (GRID / 1e3, abs(Z), np.angle(Z)),
    "f [Hz],Z' [kohm],Z'' [kohm]": (GRID, Z.real / 1e3, Z.imag / 1e3),
    "freq/Hz,Re(Z)/Ohm,-Im(Z)/Ohm": (GRID, Z.real, -Z.imag),
    "Frequency (Hz),Z_real,Z_imag": (GRID, Z.real, Z.imag),
    "omega,Zre,Zim": (2 * np.pi * GRID, Z.real, Z.imag),
    "freq/Hz,|Z|/Ohm,-Phase/deg": (GRID, abs(Z), -np.degrees(np.angle(Z))),
    "f [Hz],Z',\N{MINUS SIGN}Z''": (GRID, Z.real, -Z.imag),
    "f [Hz],-Z' [ohm],neg. Z'' [ohm]": (GRID, -Z.real, -Z.imag),
    "Frequency (Hz),Cp (F),D": (GRID, C + 0 * GRID, 1 / (W * R * C)),
    "Frequency (Hz),Cp (nF),Tan(Delta)": (GRID, 1e9 * C + 0 * GRID, 1 / (W * R * C)),
    "Frequency (Hz),Cp (pF),Q": (GRID, 1e12 * C + 0 * GRID, W * R * C),
    "Frequency (Hz),C_p (nF),Rp (kohm)": (GRID, 1e9 * C + 0 * GRID, R / 1e3 + 0 * GRID),
    "Frequency (Hz),Cp [F],G [uS]": (GRID, C + 0 * GRID, 1e6 / R + 0 * GRID),
    "Frequency (Hz),G (S),B (mS)": (GRID, 1 / R + 0 * GRID, 1e3 * W * C),
    "Frequency (Hz),G,-B": (GRID, 1 / R + 0 * GRID, -W * C),
    "Frequency (Hz),|Y| (S),Theta (deg)": (GRID, abs(1 / Z), -np.degrees(np.angle(Z))),
    "Frequency (Hz),Cs (F),Rs (ohm)": (GRID, -1 / (W * Z.imag), Z.real),
    "Frequency (Hz),Cs (F),D": (GRID, -1 / (W * Z.imag), 1 / (W * R * C)),
    "Frequency (Hz),Cs (uF),Q": (GRID, -1e6 / (W * Z.imag), W * R * C),
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
    recorded = table(tmp_path, "f,|Z|,phase [deg],a,b", (GRID, 9 * abs(Z), 0 * GRID, Z.real, -Z.imag))
    stated = {"real": "a", "minus_imaginary": "b"}
    np.testing.assert_allclose(spectrum_of(recorded, columns=stated).impedance, Z, rtol=1e-11)
    recorded = table(tmp_path, "a,b,c", (GRID, Z.real, Z.imag))
    with pytest.raises(InputError, match="no such column; it has a, b, c"):
        spectrum_of(recorded, columns={"frequency": "d"})


@pytest.mark.parametrize(
    ("heading", "columns", "words"),
    [
        ("f,|Z|,phase", (abs(Z), np.angle(Z)), "degrees or radians"),
        ("f,|Z|", (abs(Z),), "neither modulus and phase"),
        ("f,Cp", (0 * GRID + C,), "nor Cp or Cs with D, Q, G, Rp or Rs"),
        (
            "f,Cp,D",
            (0 * GRID + 1e3, 0 * GRID + 1),
            r"farads are not likely; state its unit, such as 'Cp \[pF\]'",
        ),
        ("f,Lp,Rp", (-1 / (W**2 * C), 0 * GRID + R), "'Lp' is an inductance"),
        ("f,Z' [kohm],Z''", (Z.real / 1e3, Z.imag), "one has a unit; state that of the other"),
        (
            "f,Z' [ohm cm2],Z'' [ohm cm2],|Z| [ohm],phase [deg]",
            (Z.real, Z.imag, abs(Z), 0 * R * GRID),
            "times an area",
        ),
        (
            "f,Z',Z'',|Z|,phase [deg]",
            (Z.real, -Z.imag, abs(Z), np.degrees(np.angle(Z))),
            r"differ from .* quantities",
        ),
        ("f [V],|Z|,phase [deg]", (abs(Z), np.angle(Z)), "not a unit of Hz"),
        (
            "f,eps',loss factor,sigma",
            (EPS.real, -EPS.imag, 2 * SIGMA),
            r"loss factor' differ from .*sigma' by 0\.5",
        ),
        ("f,eps',sigma,rho", (EPS.real, SIGMA, 1.05 / SIGMA), r"sigma' differ from .*rho' by 0\.04"),
        (
            "f,eps',loss factor,loss tangent",
            (EPS.real, -EPS.imag, -EPS.imag),
            r"loss factor' differ from .*loss tangent'",
        ),
        ("f,eps',resistivity [ohm]", (EPS.real, 1 / SIGMA), "'ohm' is not a unit of ohm m"),
        ("f,eps',resistivity [ohm m]", (EPS.real, 0 * SIGMA), "resistivity has to be above 0"),
        ("f,permittivity [V],sigma", (EPS.real, SIGMA), "'V' is not a unit of 1"),
    ],
)
def test_what_is_ambiguous_is_refused(tmp_path, heading, columns, words):
    with pytest.raises(InputError, match=words):
        spectrum_of(table(tmp_path, heading, (GRID, *columns)))


def test_a_trace_of_zeros_is_no_imaginary_part():
    """As Agilent's 4294A writes the magnitude under the heading Real, and its phase as another trace."""
    grid = np.array([10.0, 100.0, 1000.0, 1e4])
    table = recorded_of([("Frequency", "Hz", grid), ("Real", "", 1e6 / grid), ("Imag", "", 0 * grid)])
    with pytest.raises(InputError, match=r"'Imag' is 0 in every row.*choose another table with part"):
        spectrum_of(table)


def test_a_factor_for_a_meaning_and_a_minus_that_is_stated(tmp_path):
    """Before, scale.phase was accepted and ignored, and no column could be the negative of a phase."""
    turned = (GRID, abs(Z), -np.degrees(np.angle(Z)))
    table(tmp_path, "f,|Z|,-Phase/deg", turned)
    columns = {"frequency": "f", "modulus": "|Z|", "phase": "-Phase"}
    found = ev.import_file(tmp_path / "a.csv", columns, scale={"phase": -1, "modulus": "2"})
    np.testing.assert_allclose(found.impedance, 2 * Z, rtol=1e-10)
    assert "phase: '-Phase' times -1" in found.attrs["history"]
    minus = {"frequency": "f", "modulus": "|Z|", "minus_phase": "-Phase"}
    np.testing.assert_allclose(ev.import_file(tmp_path / "a.csv", minus).impedance, Z, rtol=1e-10)
    with pytest.raises(InputError, match=r"columns.phase = '-Phase': .*states a minus; .* minus_phase"):
        ev.import_file(tmp_path / "a.csv", columns)
    for scale, words in (({"phase": -1}, "the spectrum has f"), ({"minus_phase": 0}, "other than 0")):
        with pytest.raises(InputError, match=words):
            ev.import_file(tmp_path / "a.csv", scale=scale)
    with pytest.raises(InputError, match=r"'minus_modulus' is not among .*minus_phase"):
        ev.import_file(tmp_path / "a.csv", {"minus_modulus": "|Z|", "frequency": "f"})


@pytest.mark.parametrize(
    "option",
    [
        {"time": "f"}, {"step": "1 ms"}, {"stamps": "keep_increasing"}, {"offset": {"phase": 1}}, {"shift": {"phase": 1}},
        {"trigger": "phase"}, {"baseline": {"phase": "0 s..1 s"}}, {"detrend": "phase"}, {"crop": "0 s..1 s"},
        {"average": "phase"}, {"resample": "1 ms"}, {"calibration": {"phase": "none.csv"}},
    ],
)  # fmt: skip
def test_an_option_that_a_spectrum_does_not_use_is_refused_by_name(tmp_path, option):
    table(tmp_path, "f,Z',Z''", (GRID, Z.real, Z.imag))
    with pytest.raises(InputError, match=f"{next(iter(option))}: has no effect on a spectrum"):
        ev.import_file(tmp_path / "a.csv", **option)


@pytest.mark.parametrize("unit", ["ohm cm2", "Ohm.cm²", "kΩ·cm^2"])
def test_an_impedance_times_an_area_needs_the_area(tmp_path, unit):
    size = 0.5e-4
    per = Z * size / (1e-1 if unit.startswith("k") else 1e-4)
    table(tmp_path, f"f [Hz],Z' ({unit}),Z'' ({unit})", (GRID, per.real, per.imag))
    with pytest.raises(InputError, match=r"one times an area; .* --as material"):
        ev.import_file(tmp_path / "a.csv")
    found = ev.import_material(
        tmp_path / "a.csv", ev.SpectrumRecipe(area="0.5 cm2", thickness="200 um")
    ).material
    np.testing.assert_allclose(found.permittivity_samples.values, C * 2e-4 / (eps0 * size), rtol=1e-6)
    loss = 2e-4 / (R * size) / (W * eps0)
    np.testing.assert_allclose(found.loss_samples.values, loss, rtol=1e-6)


@pytest.mark.parametrize("count", [2, 3, 4])
def test_a_material_needs_four_frequencies(tmp_path, count):
    """Before, three rows ended in a traceback."""
    table(tmp_path, "f,Z' [ohm],Z'' [ohm]", (GRID[:count], Z.real[:count], Z.imag[:count]))
    recipe = ev.SpectrumRecipe(area="1 cm2", thickness="1 mm")
    for made in (ev.import_material, ev.fit_material):
        if count == 4:
            made(tmp_path / "a.csv", recipe)
            continue
        with pytest.raises(InputError, match=f"has {count} frequencies; a material needs 4 or more"):
            made(tmp_path / "a.csv", recipe)


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
        material = ev.import_material(path, ev.SpectrumRecipe(part=part, area="1 cm2", thickness="1 mm"))
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
