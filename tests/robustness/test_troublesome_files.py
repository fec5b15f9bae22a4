"""Files as programs and instruments write them, of known arrays, that were once read wrongly: right now, or refused by name."""

import numpy as np
import pytest
from scipy.io import savemat

import electrovib as ev
from electrovib.core.errors import InputError

TIME = np.round(np.arange(60) * 0.005, 6)
FORCE = np.round(0.3 + 0.1 * np.sin(TIME * 27) + 0.01 * np.cos(TIME * 420), 5)
FREQUENCIES = np.logspace(1, 4, 20)
IMPEDANCE = 50e3 / (1 + 1j * FREQUENCIES / 300)


def lines(*columns, separator=","):
    """Rows of text of some columns."""
    return "".join(
        separator.join(f"{cell:.12g}" for cell in row) + "\n" for row in zip(*columns, strict=True)
    )


@pytest.mark.parametrize(("options", "reference"), [("R 75 RI S hz", 75), ("RI hz S", 50)])
def test_the_order_of_the_options_of_touchstone_is_free(tmp_path, options, reference):
    path = tmp_path / "skin.s1p"
    reflection = (IMPEDANCE - reference) / (IMPEDANCE + reference)
    path.write_text(f"# {options}\n" + lines(FREQUENCIES, reflection.real, reflection.imag, separator=" "))
    np.testing.assert_allclose(ev.import_file(path, {}).impedance, IMPEDANCE, rtol=1e-6)


@pytest.mark.parametrize("trace", [np.abs(IMPEDANCE), 1e-9 + 0 * FREQUENCIES])
def test_a_trace_of_an_analyser_under_the_heading_of_a_real_part_is_no_impedance(tmp_path, trace):
    path = tmp_path / "skin.txt"
    rows = lines(FREQUENCIES, trace, 0 * FREQUENCIES, separator="\t")
    path.write_text("TRACE: A\nFORMAT: |Z|\nFrequency\tReal\tImag\n" + rows)
    with pytest.raises(InputError, match="Imag"):
        ev.import_file(path, {})


@pytest.mark.parametrize(("cell", "factor"), [("c{1}", 1), ("c{2}", 2)])
def test_cells_are_counted_as_their_program_does(tmp_path, cell, factor):
    path = tmp_path / "runs.mat"
    cells = np.empty((1, 2), dtype=object)
    cells[0, 0], cells[0, 1] = FORCE, 2 * FORCE
    savemat(path, {"c": cells, "t": TIME})
    trace = ev.import_file(path, {"lateral_force": f"{cell} [N]"}, time="t [s]")
    np.testing.assert_allclose(trace.lateral_force, factor * FORCE)


def test_a_file_of_matlab_4_is_read(tmp_path):
    path = tmp_path / "old.mat"
    savemat(path, {"t": TIME, "force": FORCE}, format="4")
    trace = ev.import_file(path, {"lateral_force": "force [N]"}, time="t [s]")
    np.testing.assert_array_equal(trace.lateral_force, FORCE)
    np.testing.assert_allclose(trace.time, TIME)


@pytest.mark.parametrize(
    ("name", "begin", "said"),
    [
        ("a.parquet", b"PAR1", "Parquet"),
        ("a.mf4", b"MDF     4.10    ", "MDF"),
        ("a.sqlite", b"SQLite format 3\0", "SQLite"),
        ("a.pkl", b"\x80\x04\x95", "pickle"),
        ("a.json", b'{"time": [0, 1], "force": [1, 2]}', "JSON"),
        ("a.tdm", b'<?xml version="1.0"?>', "XML"),
        ("a.xls", b"<html><table><tr><td>0</td><td>1</td></tr></table></html>", "HTML"),
    ],
)
def test_a_format_that_is_not_read_is_named(tmp_path, name, begin, said):
    path = tmp_path / name
    path.write_bytes(begin + bytes(200 * (name not in ("a.json", "a.tdm", "a.xls"))))
    with pytest.raises(InputError, match=said):
        ev.import_file(path, {"lateral_force": "force"})
