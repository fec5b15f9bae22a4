"""Raw files of ngspice and of LTspice: binary and ASCII, real and complex, several plots, stepped and compressed runs."""

import shutil
import subprocess

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.readers.spice_raw import FORMAT
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of

TIME = np.array([0.0, 1e-6, 3e-6, 1e-5])
VOLTS = np.array([0.0, 0.5, 0.75, -1.25])
GRID = np.array([10.0, 100.0, 1e3, 1e4])
Z = 5e4 / (1 + 2j * np.pi * GRID * 5e-5)


def header(plot, flags, names, points, more=""):
    variables = "".join(f"\t{number}\t{name}\t{kind}\n" for number, (name, kind) in enumerate(names))
    return (
        f"Title: * a circuit\nDate: today\nPlotname: {plot}\nFlags: {flags}\nNo. Variables: {len(names)}\n"
        f"No. Points: {points}\n{more}Variables:\n{variables}"
    )


def ltspice(flags, names, body, points, more="Command: Linear Technology Corporation LTspice XVII\n"):
    """Write a file as LTspice does, with a header in UTF-16."""
    return (header("Transient Analysis", flags, names, points, more) + "Binary:\n").encode("utf-16-le") + body


SIGNALS = [("time", "time"), ("V(out)", "voltage"), ("I(R1)", "device_current")]


def rows(times, *others, kind="<f4"):
    return b"".join(
        np.float64(time).tobytes() + np.array(each, kind).tobytes()
        for time, *each in zip(times, *others, strict=True)
    )


def words(end="\n"):
    points = zip(TIME, VOLTS, 2 * VOLTS, strict=True)
    lines = (f"{number}\t\t{t:.17e}\n\t{v:.17e}\n\t{i:.17e}\n" for number, (t, v, i) in enumerate(points))
    return (PLAIN + "Values:\n" + "".join(lines)).replace("\n", end)


PLAIN = header("Transient Analysis", "real", SIGNALS, 4)
OLD = header("Transient Analysis", "real", SIGNALS, 4, "Command: Linear Technology Corporation LTspice IV\n")
SINGLE, DOUBLE = (rows(TIME, VOLTS, 2 * VOLTS, kind=kind) for kind in ("<f4", "<f8"))
BY_COLUMN = TIME.tobytes() + VOLTS.astype("<f4").tobytes() + (2 * VOLTS).astype("<f4").tobytes()
LTSPICE = {
    "single": ltspice("real forward", SIGNALS, SINGLE, 4),
    "double": ltspice("real forward double", SIGNALS, DOUBLE, 4),
    "fast access": ltspice("real fastaccess", SIGNALS, BY_COLUMN, 4),
    "compressed": ltspice("real forward", SIGNALS, rows(TIME * [1, -1, 1, -1], VOLTS, 2 * VOLTS), 4),
    "header of bytes": OLD.encode() + b"Binary:\n" + SINGLE,
    "ascii": words().encode("utf-16-le"),
    "ngspice": PLAIN.encode() + b"Binary:\n" + DOUBLE,
    "ngspice of Windows": words("\r\n").encode(),
}


@pytest.mark.parametrize("name", LTSPICE)
def test_signals_over_time(tmp_path, name):
    (tmp_path / "a.raw").write_bytes(LTSPICE[name])
    assert format_of(tmp_path / "a.raw") is FORMAT
    found = read_recorded(tmp_path / "a.raw")
    np.testing.assert_array_equal(found.times(), TIME)
    assert [(each.name, each.unit) for each in found.channels] == [
        ("time", "s"),
        ("V(out)", "V"),
        ("I(R1)", "A"),
    ]
    np.testing.assert_array_equal(found.channels[1].values, VOLTS)
    np.testing.assert_array_equal(found.channels[2].values, 2 * VOLTS)
    assert not found.not_read


@pytest.mark.parametrize("flags", ["real forward stepped", "real stepped fastaccess"])
def test_each_run_of_a_stepped_simulation_is_a_part(tmp_path, flags):
    times, volts = np.tile(TIME, 3), np.concatenate([VOLTS, 2 * VOLTS, 4 * VOLTS])
    body = times.tobytes() + volts.astype("<f4").tobytes() if "fast" in flags else rows(times, volts)
    (tmp_path / "a.raw").write_bytes(ltspice(flags, SIGNALS[:2], body, 12))
    for part, factor in ((None, 1), ("Transient Analysis, run 2", 2), ("Transient Analysis, run 3", 4)):
        found = read_recorded(tmp_path / "a.raw", part=part)
        np.testing.assert_array_equal(found.times(), TIME)
        np.testing.assert_array_equal(found.channels[1].values, factor * VOLTS)
        assert len(found.not_read) == 2
        assert all("choose it with part" in each.why for each in found.not_read)
    with pytest.raises(DataFileError, match=r"no such plot or run\..* It has Transient Analysis, run 1"):
        read_recorded(tmp_path / "a.raw", part="run 4")


def test_a_complex_vector_is_two_columns_and_each_plot_a_part(tmp_path):
    names = [("frequency", "frequency"), ("z", "impedance")]
    sweep = header("AC Analysis", "complex", names, 4).encode() + b"Binary:\n"
    sweep += b"".join(np.array(each, "<c16").tobytes() for each in zip(GRID, Z, strict=True))
    point = header("Operating Point", "real", SIGNALS[1:], 1).encode() + b"Binary:\n" + bytes(16)
    (tmp_path / "a.raw").write_bytes(point + sweep + LTSPICE["ngspice"] + LTSPICE["ngspice"])
    found = read_recorded(tmp_path / "a.raw")
    assert [each.name for each in found.channels] == ["frequency", "Re(z)", "Im(z)"]
    np.testing.assert_array_equal(spectrum_of(found).impedance, Z)
    others = ["Operating Point", "Transient Analysis", "Transient Analysis 2"]
    assert [each.name for each in found.not_read] == others
    np.testing.assert_array_equal(read_recorded(tmp_path / "a.raw", part=others[2]).channels[1].values, VOLTS)


FEWER = "does not hold the 4 points of 3 numbers that it states: it is cut off or damaged"


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (LTSPICE["single"][:-1], FEWER),
        (LTSPICE["fast access"][:-1], FEWER),
        (LTSPICE["single"].partition(b"y\0:\0\n\0")[0] + b"y\0:\0\n\0", FEWER),
        (LTSPICE["ngspice"].replace(b"Points: 4", b"Points: " + b"9" * 30), "does not hold the 9{30} points"),
        (LTSPICE["ngspice of Windows"][:-50], FEWER),
        (header("DC", "real", SIGNALS[1:2], 0).encode() + b"Binary:\n", "no column of two or more"),
        (LTSPICE["ngspice of Windows"].replace(b"\t7.5", b"\tx.5"), FEWER),
        (words().encode() + b"7", FEWER),
        (LTSPICE["ngspice"].partition(b"Binary")[0], "header without values"),
        (LTSPICE["ngspice"] + b"Title: next", "header without values"),
        (
            LTSPICE["ngspice"].replace(b"No. Variables: 3", b"No. Variables: 4"),
            "without the number of its variables",
        ),
        (
            LTSPICE["ngspice"].replace(b"Points: 4", b"Points: x"),
            "without the number of its variables and points",
        ),
        (
            header("Operating Point", "real", SIGNALS, 1).encode() + b"Binary:\n" + bytes(24),
            "no column of two or more",
        ),
    ],
)
def test_damage_is_one_sentence(tmp_path, content, words):
    (tmp_path / "a.raw").write_bytes(content)
    with pytest.raises(DataFileError, match=words):
        read_recorded(tmp_path / "a.raw")


@pytest.mark.skipif(
    shutil.which("ngspice") is None, reason="needs ngspice, which no package of Python brings"
)
@pytest.mark.parametrize("kind", ["binary", "ascii"])
def test_what_ngspice_writes(tmp_path, kind):
    """A resistor and a capacitor in parallel, driven with 1 V: their impedance, and the charging of a low-pass."""
    (tmp_path / "a.cir").write_text(
        f"""* a circuit
V1 in 0 dc 0 ac 1 pulse(0 1 0 1n 1n 1 2)
R1 in 0 50k
C1 in 0 1n
R2 in out 1k
C2 out 0 1u
.control
set filetype={kind}
ac dec 5 10 1e5
let z = v(in)/(-i(v1)-(v(in)-v(out))/1000)
tran 10u 5m
write a.raw tran1.all ac1.all
quit
.endc
.end
"""
    )
    subprocess.run(["ngspice", "-b", "a.cir"], cwd=tmp_path, capture_output=True, check=True)
    found = read_recorded(tmp_path / "a.raw")
    volts = next(each.values for each in found.channels if each.name == "v(out)")
    np.testing.assert_allclose(volts, 1 - np.exp(-found.times() / 1e-3), atol=2e-3)
    found = spectrum_of(read_recorded(tmp_path / "a.raw", part="AC Analysis"))
    known = 5e4 / (1 + 2j * np.pi * found.frequency * 5e-5)
    np.testing.assert_allclose(found.impedance, known, rtol=1e-9)
