"""Headings above rows without numbers, and tables of several steps: layouts made here, as CETR tribometers write them."""

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.registry import read_recorded

T = 0.5 * np.arange(60)
V = 1e3 * np.sin(T / 9)
F = 0.4 + 0.01 * np.cos(1.7 * T)


def written(tmp_path, first, heading="Time (ms),Voltage (mV),Force (N)\n"):
    rows = "".join(f"{t:.1f},{v:.5f},{f:.5f}\n" for t, v, f in zip(T, V, F, strict=True))
    (tmp_path / "a.csv").write_text(f"{heading}{first}{rows}")
    return read_recorded(tmp_path / "a.csv")


@pytest.mark.parametrize(
    ("first", "kept"),
    [
        ("", True),
        ("OVLD,OVLD,OVLD\n", True),
        ("-0.5,OVLD,0.41\n", True),
        ("ERR7,ERR7,ERR7\n", False),
        ("-1.0,Sat.,0.41\n-0.5,Sat.,Sat.\n", False),
    ],
)
@pytest.mark.parametrize("units_apart", [False, True])
def test_a_heading_stays_one_above_rows_without_numbers(tmp_path, first, kept, units_apart):
    heading = "Time,Voltage,Force\n(ms),(mV),(N)\n" if units_apart else "Time (ms),Voltage (mV),Force (N)\n"
    found = written(tmp_path, first, heading)
    assert [(each.name, each.unit) for each in found.channels] == [
        ("Time", "ms"), ("Voltage", "mV"), ("Force", "N"),
    ]  # fmt: skip
    assert found.time == "Time" or first.startswith("OVLD")
    np.testing.assert_allclose(found.channels[1].values[-60:], V, atol=1e-5)
    assert any(each.why.startswith("words in place of numbers") for each in found.not_read) is not kept
    assert found.size == 60 + (first.count("\n") if kept else 0)


def test_a_row_of_settings_or_of_units_is_no_row_without_numbers(tmp_path):
    assert written(tmp_path, "", "x-axis,1,2\nsecond,Volt,Volt\n").channels[1].name == "1"
    found = written(tmp_path, "", "Interval,2,ms\nTime,U,F\nms,mV,N\n")
    assert [each.unit for each in found.channels] == ["ms", "mV", "N"]


STEP = """Step No. {number}

Step Type Code: 0
Radius       = 3.9
Velocity     = {speed}
Data Count   = {count}
Started at: 10:00:0{number}.100 01 Jan 2020

Fx,Fz,Z,V1,T,Ff,COF
g,g,mm,mm/sec,sec,g,

"""


def steps(*counts, label="Step No. {number}"):
    """Write a synthetic export in the layout that public exports of CETR Data Viewer 2.19 show."""
    text = "Created by CETR Data Viewer ver.2\nTotal number of steps = 2\nC:\\a_002.tst\n\nRun # 1\n"
    for number, count in enumerate(counts, 1):
        text += STEP.replace("Step No. {number}", label).format(number=number, speed=10 * number, count=count)
        for place in range(count):
            fx, fz = 80 * np.sin(place / 9) * number, -100 - 0.01 * place
            text += f"{fx:.6f},{fz:.6f},-0.6620,0.0035,{place * 0.02:.4f},{abs(fx):.6f},{abs(fx / fz):.6f}\n"
        text += "\n\n"
    return text


def test_steps_of_a_tribometer_are_parts_with_their_units(tmp_path):
    path = tmp_path / "cetr.csv"
    path.write_text(steps(50, 70, 30))
    for part, count, number in ((None, 70, 2), ("step 1", 50, 1), ("step 3", 30, 3)):
        found = read_recorded(path, part=part)
        assert [(each.name, each.unit) for each in found.channels] == [
            ("Fx", "gf"), ("Fz", "gf"), ("Z", "mm"), ("V1", "mm/s"), ("T", "s"), ("Ff", "gf"), ("COF", ""),
        ]  # fmt: skip
        assert found.time == "T"
        np.testing.assert_allclose(found.times(), 0.02 * np.arange(count), atol=1e-9)
        known = 80 * np.sin(np.arange(count) / 9) * number
        np.testing.assert_allclose(found.channels[0].values, known, atol=1e-6)
        assert found.attributes["table"] == f"step {number}"
        assert {each.name for each in found.not_read} == {f"step {n}" for n in (1, 2, 3) if n != number}
        assert found.attributes["Velocity"] == f"{10 * number}"
    with pytest.raises(DataFileError, match=r"there is no such table.*step 1, step 2, step 3"):
        read_recorded(path, part="step 4")


def test_tables_without_numbers_of_their_own_are_counted(tmp_path):
    path = tmp_path / "cetr.csv"
    path.write_text(steps(20, 30, label="Next"))
    assert read_recorded(path, part="table 1").size == 20
    path.write_text(steps(20))
    found = read_recorded(path)
    assert (found.size, "table" in found.attributes) == (20, False)
    with pytest.raises(DataFileError, match="does not consist of parts"):
        read_recorded(path, part="table 1")


FIXED = [f"{t:.1f},{v:.4f}" for t, v in zip(T, V, strict=True)]
EXPONENTS = [f"{t:.1f},{v:.3e}" for t, v in zip(T, V, strict=True)]
AS_SHORT_AS_CAN_BE = [f"{t:.1f},{round(v, 2)!r}" for t, v in zip(T, V, strict=True)]
WHOLE_NUMBERS = [f"{t:.1f},{round(v)}" for t, v in zip(T, V, strict=True)]


def doubts_of(tmp_path, text):
    (tmp_path / "a.csv").write_text(text)
    return read_recorded(tmp_path / "a.csv").attributes.get("unsure", "")


@pytest.mark.parametrize(
    ("rows", "cut"), [(FIXED, 1), (FIXED, 3), (EXPONENTS, 1), (EXPONENTS, 4)], ids=lambda each: str(each)[:9]
)
def test_a_last_number_that_is_cut_off_is_told(tmp_path, rows, cut):
    """It was read without a word: 9 in place of 9.0293, or 1.2 in place of 1.2e-03."""
    text = "t [s],F [N]\n" + "\n".join(rows)
    found = doubts_of(tmp_path, text[:-cut])
    last = rows[-1].partition(",")[2][:-cut]
    assert f"the last number '{last}': it is shorter than the 59 above, and no line ends behind it" in found


@pytest.mark.parametrize("rows", [FIXED, EXPONENTS, AS_SHORT_AS_CAN_BE, WHOLE_NUMBERS])
@pytest.mark.parametrize("last", ["", "30.5,7", "30.5,0.1"])
def test_a_text_that_ends_without_a_line_end_is_not_doubted_without_a_reason(tmp_path, rows, last):
    """With a line end behind it, or where numbers are written as short as they can be, a short number is whole."""
    text = "\n".join(["t [s],F [N]", *rows, *([last] if last else [])])
    of_one_form = rows in (FIXED, EXPONENTS)
    assert bool(doubts_of(tmp_path, text)) == bool(of_one_form and last)
    assert not doubts_of(tmp_path, text + "\n")
    assert not doubts_of(tmp_path, "t [s],F [N]\n" + "\n".join([*rows[:5], "2.5,7"]))
