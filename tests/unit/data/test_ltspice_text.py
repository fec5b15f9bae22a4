"""Text of LTspice: complex cells as modulus and angle or as parts, and stepped runs."""

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of

GRID = np.geomspace(10, 1e4, 7)
Z = 5e4 / (1 + 2j * np.pi * GRID * 5e-5)


def polar(value):
    return f"({20 * np.log10(abs(value)):.14e}dB,{np.degrees(np.angle(value)):.14e}\N{DEGREE SIGN})"


def parts(value):
    return f"{value.real:.14e},{value.imag:.14e}"


@pytest.mark.parametrize("encoding", ["latin-1", "utf-8"])
@pytest.mark.parametrize("cell", [polar, parts])
def test_complex_cells_and_steps(tmp_path, cell, encoding):
    """Before, all columns but the frequency were left out, and two runs were one table."""
    lines = ["Freq.\tz\tV(out)"]
    for run in (1, 2):
        lines.append(f"Step Information: R={run}K  (Run: {run}/2)")
        lines += [f"{f:.14e}\t{cell(run * z)}\t{cell(z / 9)}" for f, z in zip(GRID, Z, strict=True)]
    for content, runs in ((lines, (1, 2)), ([lines[0], *lines[2:9]], (1,))):
        (tmp_path / "a.txt").write_text("\n".join([*content, ""]), encoding=encoding)
        assert format_of(tmp_path / "a.txt").name == "ltspice"
        for run in runs:
            found = read_recorded(
                tmp_path / "a.txt", part=f"R={run}K (Run: {run}/2)" if len(runs) > 1 else None
            )
            spectrum = spectrum_of(found)
            np.testing.assert_allclose(spectrum.frequency, GRID, rtol=1e-12)
            np.testing.assert_allclose(spectrum.impedance, run * Z, rtol=1e-12)
            assert [each.unit for each in found.channels] == ["Hz", "", "", "V", "V"]
            assert len(found.not_read) == len(runs) - 1


def test_runs_over_time(tmp_path):
    rows = "0.0e+00\t1.5\n1.0e-03\t2.5\n2.0e-03\t3.5\n"
    (tmp_path / "a.txt").write_text(
        f"time\tV(out)\nStep Information: R=1 (Run: 1/2)\n{rows}Step Information: R=2 (Run: 2/2)\n{rows}"
    )
    found = read_recorded(tmp_path / "a.txt")
    np.testing.assert_array_equal(found.times(), [0.0, 1e-3, 2e-3])
    np.testing.assert_array_equal(found.channels[1].values, [1.5, 2.5, 3.5])
    assert [each.name for each in found.not_read] == ["R=2 (Run: 2/2)"]
    (tmp_path / "a.txt").write_text("time\tV(out)\n0,5\t1,5e-3\n1,5\t2,5e-3\n2,5\t3,5e-3\n")
    assert format_of(tmp_path / "a.txt").name == "text"


@pytest.mark.parametrize(
    "row", ["1.0e-03", "1.0e-03\t(1dB,2)", "1.0e-03\t1,2,3", "x\t1", "1\t(1e9dB,2\N{DEGREE SIGN})"]
)
def test_what_is_no_number_is_one_sentence(tmp_path, row):
    (tmp_path / "a.txt").write_text(
        f"Freq.\tV(out)\nStep Information: R=1 (Run: 1/1)\n1\t2\n{row}\n", encoding="latin-1"
    )
    with pytest.raises(DataFileError, match=r"holds a row of R=1 \(Run: 1/1\) that is not made of numbers"):
        read_recorded(tmp_path / "a.txt")
