"""Several spectra in one table, and columns of an impedance that an instrument leaves empty."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.data.registry import read_recorded
from electrovib.data.spectrum import spectrum_of
from electrovib.recordings.importing import list_columns

G = np.geomspace(1e5, 10, 29)


def impedance(number, grid=G):
    return 100 * number + 5e4 / (1 + 2j * np.pi * grid * 5e4 * 1e-9 * number)


def table(path, *numbers, turned=(), heading="freq/Hz,Re(Z)/Ohm,-Im(Z)/Ohm"):
    rows = []
    for number in numbers:
        grid = G[::-1] if number in turned else G
        rows += [
            f"{f!r},{z.real!r},{-z.imag!r}"
            for f, z in zip(grid.tolist(), impedance(number, grid).tolist(), strict=True)
        ]
    path.write_text("\n".join([heading, *rows]))
    return path


@pytest.mark.parametrize("turned", [(), (2,), (1, 3)])
def test_each_spectrum_of_a_table_is_a_part(tmp_path, turned):
    path = table(tmp_path / "a.csv", 1, 2, 3, turned=turned)
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
    assert "read: spectrum 1; not read: spectrum 2, spectrum 3; choose with --set part=..." in list_columns(
        path
    )


def test_one_spectrum_in_any_order_is_whole(tmp_path):
    path = table(tmp_path / "a.csv", 1)
    assert "not read" not in ev.import_file(path).attrs["validity"]
    lines = path.read_text().splitlines()
    shuffled = [lines[0], *np.random.default_rng(1).permutation(lines[1:])]
    path.write_text("\n".join(shuffled))
    np.testing.assert_allclose(ev.import_file(path).impedance, impedance(1)[::-1])
    path.write_text(
        "\n".join([lines[0], *(line for line in lines[1:] for _ in range(2))])
    )  # each measured twice
    assert ev.import_file(path).frequency.size == 58


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


def test_rows_of_no_impedance_are_omitted(tmp_path):
    path = table(tmp_path / "a.csv", 1)
    lines = path.read_text().splitlines()
    lines[5] = lines[5].split(",")[0] + ",0,0"
    path.write_text("\n".join(lines))
    assert ev.import_file(path).frequency.size == 28
