"""Text in the dialects of instruments and countries: every column is read as written, or named with the reason."""

import re

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.registry import read_recorded
from electrovib.data.unit_words import as_unit, name_and_unit

NAN = np.nan
WIDE = "{:<14}{:<28}{}\n".format
READ = {
    "signs apart": (
        "NO.\tTime\tus\tCH1\tCH2\tA12\nNO.\tTime\tus\tV\tmV\tA12\n"
        "1\t10:00:00\t0\t- 0.500\t+  300.00\tLL\n2\t10:00:00\t10\t+ 6.279\t+ 306.27\tLL\n3\t10:00:00\t20\t+ 7\t- 1\tLL\n",
        {"CH1": ("V", [-0.5, 6.279, 7]), "CH2": ("mV", [300, 306.27, -1])},
    ),
    "headings of several words": (
        "% Model: x\n" + WIDE("% Time (s)", "Electric potential (V)", "Force (mN)")
        + WIDE(0, -1.5, 300) + WIDE(0.1, -6.25, 306) + WIDE(0.2, -12, 312),
        {"Time": ("s", [0, 0.1, 0.2]), "Electric potential": ("V", [-1.5, -6.25, -12]), "Force": ("mN", [300, 306, 312])},
    ),
    "comments with quoted headings": ('% "Time [s]","Re(Z)"\n0,1\n1,2.5\n', {"Time": ("s", [0, 1]), "Re(Z)": ("", [1, 2.5])}),
    "names with brackets": (
        "f [Hz]\tEps'\tTan(Delta)\tV(out)\tI(R1)\n1\t2\t3\t4\t5\n2\t3\t4\t5\t6\n",
        {"Tan(Delta)": ("", [3, 4]), "V(out)": ("", [4, 5]), "I(R1)": ("", [5, 6]), "Eps'": ("", [2, 3])},
    ),
    "decimal commas in quotes": (
        '"t (s)","F (N)"\n"0,0","1,50"\n"0,1","-1,51"\n', {"t": ("s", [0, 0.1]), "F": ("N", [1.5, -1.51])},
    ),
    "thousands with points": ("t [s];F [mN]\n0,00;900,00\n0,01;1.390,25\n", {"F": ("mN", [900, 1390.25])}),
    "thousands with blanks": ("t;F\n0;1\u202f234,5\n1;5\u00a0678,1\n2;12 345,6\n", {"F": ("", [1234.5, 5678.1, 12345.6])}),
    "thousands with apostrophes": ("t;F\n0;1'234.5\n1;12\u2019678.1\n", {"F": ("", [1234.5, 12678.1])}),
    "lakh": ("t;F\n0;1,23,456.5\n1;7,890.1\n", {"F": ("", [123456.5, 7890.1])}),
    "quotes behind blanks": ('"t [s]", "F [N]"\n"0", "1.5"\n"1", "-2.5"\n', {"t": ("s", [0, 1]), "F": ("N", [1.5, -2.5])}),
    "thousands in quotes": ('t,F\n0,"1,234.5"\n1,"-5,678.1"\n', {"F": ("", [1234.5, -5678.1])}),
    "minus of mathematics": ("t (s),u (V)\n0,\u22121.5\n1,2\n2,\u22123e\u22122\n", {"u": ("V", [-1.5, 2, -0.03])}),
    "brackets for a minus": ("t,F\n0,(1.5)\n1,2.5\n2,(3)\n", {"F": ("", [-1.5, 2.5, -3])}),
    "a unit in each field": ("u (V),t\n1,-1.25 us\n2,0.00E+00 us\n", {"t": ("us", [-1.25, 0])}),
    "units with several prefixes": ("u (V),t\n1,1.25 s\n2,500 ms\n3,0 s\n", {"t": ("s", [1.25, 0.5, 0])}),
    "Greek mu": ("t [\u03bcs];I\n;\u03bcA\n0;1\n1;2\n", {"t": ("us", [0, 1]), "I": ("uA", [1, 2])}),
    "a setting above the rows": (
        ",CH1_Voltage(mV)\nFrequency,F=100Hz\nSampling rate,10.0kS/s\n\n1,-0.5\n2,-6.25\n3,4\n",
        {"CH1_Voltage": ("mV", [-0.5, -6.25, 4])},
    ),
    "nanoamperes are no reading that is missing": (
        "Time,I\n,nA\n10:00:00.5,1.5\n10:00:01.0,2.5\n10:00:01.5,3.5\n", {"I": ("nA", [1.5, 2.5, 3.5])},
    ),
    "three decimals everywhere": ("t;F\n1.234;5.678\n2.345;6.789\n", {"t": ("", [1.234, 2.345]), "F": ("", [5.678, 6.789])}),
    "stamps with a blank between tabs": (
        "Time\tI [uA]\tv [m/s]\n2026-03-29 00:59:59.0\t74.5\t-0.5\n2026-03-29 00:59:59.5\t-57.25\t0.5\n",
        {"I": ("uA", [74.5, -57.25])},
    ),
    "settings above one column": ("Model,DX-120\nRange CH1,10 V\n1.5\n-2.5\n", {"column 0": ("", [1.5, -2.5])}),
    "settings behind headings": (
        "Time(s),Load (N),t0 = -0.5, tInc = 5e-03,\n0,1,,\n0.005,2,,\n0.010,4,,\n",
        {"Load": ("N", [1, 2, 4])},
    ),
    "settings beside the first of many rows": (
        "Record Length,99,Points,0.0,1.0\nSource,CH1,,0.1,2.0\nScale,5,,0.2,3.0\n"
        + "".join(f",,,{at / 10},{at + 1}\n" for at in range(3, 99)),
        {"CH1": ("", [*range(1, 100)])},
    ),
    "a heading like a setting": ("Probe position,Speed\n0.5 um,1\n1.5 um,2\n", {"Probe position": ("um", [0.5, 1.5])}),
    "newtons are no numbers of rows": ("Sampling rate=100 Hz\nLoad [N],u [V]\n4,1\n1,2\n3,3\n", {"Load": ("N", [4, 1, 3])}),
    "units behind strokes": ("Time / s,Speed / mm/s\n0,1\n1,2\n", {"Time": ("s", [0, 1]), "Speed": ("mm/s", [1, 2])}),
    "rows of units with gaps": ("a=1\nb=2\nt\tU\tV\n\t[V]\t[m]\n10:00:00.5\t1\t2\n10:00:01.0\t3\t4\n", {"U": ("V", [1, 3])}),
    "one column": ("# Force [mN]\n1,5\n-2,25\n3,125\n", {"Force": ("mN", [1.5, -2.25, 3.125])}),
    "a decimal comma shown by its zeros": ("1,05\n1,15\n2,00\n", {"column 0": ("", [1.05, 1.15, 2])}),
    "a first row without its number": (
        "Time,F [N]\n2026-03-29T00:00:59.0,\n2026-03-29T00:00:59.5,1.5\n2026-03-29T00:01:00.0,2.5\n2026-03-29T00:01:00.5,\n",
        {"F": ("N", [NAN, 1.5, 2.5, NAN])},
    ),
    "a column with gaps": ("t,E,F\n0,,1\n1,5,\n2,,3\n3,7,4\n", {"E": ("", [NAN, 5, NAN, 7]), "F": ("", [1, NAN, 3, 4])}),
    "excel has no number": ("F [N]\n#N/A\n1.5\n2\n#DIV/0!\n", {"F": ("N", [NAN, 1.5, 2, NAN])}),
    "trailing delimiters in the rows alone": ("t [s]\tF [N]\n0\t1\t\n1\t2\t\n", {"t": ("s", [0, 1]), "F": ("N", [1, 2])}),
    "a long preamble": (
        "".join(f"Key{n}: word\n" for n in range(900)) + "t [s],F [N]\n" + "".join(f"{n},{n}.5\n" for n in range(2000)),
        {"F": ("N", np.arange(2000) + 0.5)},
    ),
}  # fmt: skip


def written(tmp_path, text):
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    return tmp_path / "a.csv"


@pytest.mark.parametrize("name", READ)
def test_numbers_are_read_as_they_were_written(tmp_path, name):
    text, expected = READ[name]
    found = {each.name: each for each in read_recorded(written(tmp_path, text)).channels}
    for column, (unit, values) in expected.items():
        assert found[column].unit == unit
        np.testing.assert_array_equal(found[column].values, values)


ROWS, MORE = (
    "".join(f"{0.5 * row},{row * row % 7}.25,{row}.5\n" for row in range(start, start + 40))
    for start in (0, 50)
)
HEADED = "t [s],F [N],G [N]\n"
NAMED = {
    "statistics": (HEADED + ROWS + "Mean,3.25,20\nMax:,6.25,39.5\n", 40, "2 lines, 42 to 43", "statistics.*Mean,3.25,20"),
    "more statistics than rows": (
        HEADED[:-1] + ",S\n0,1,2,x\n1,2,3,y\n2,4,5,x\nMax,1,2,0\nMin,1,2,0\nMean,2,2,0\nStd,1,1,0\n", 3,
        "4 lines, 5 to 8", "statistics",
    ),
    "statistics with a heading": (HEADED + ROWS + "\nStatistics,F,G\nStd. Dev.,1,1\n", 40, "2 lines, 43 to 44", "Statistics,F,G"),
    "statistics in a column of words": (
        "Nr,Label,F\n" + "".join(f"{n},x,{n}.5\n" for n in range(9)) + "9,Mean,4.5\n", 9, "line 11", "9,Mean,4.5",
    ),
    "words between the rows": (HEADED + ROWS + "Pause\n" + MORE, 80, "line 42", "words.*'Pause'"),
    "words in a column": (HEADED + ROWS + "20,abc,1\n" + MORE, 81, "F", "words in 1 of 81 rows, the first 'abc' in line 42"),
    "a column of words": (HEADED[:-1] + ",State\n" + ROWS.replace("\n", ",OK\n"), 40, "State", "words in 40 of 40 rows.*line 2"),
    "an empty column": (HEADED[:-1] + ",Spare\n" + ROWS.replace("\n", ",\n"), 40, "Spare", "^empty$"),
    "a single number": (HEADED[:-1] + ",Gain\n1,2,3,4\n" + ROWS.replace("\n", ",\n"), 41, "Gain", "a number in 1 of 41 rows"),
    "readings beyond the range": (HEADED + ROWS + "90,OVLD,1\n91,ol,2\n92,,3\n", 43, "3 of 43 samples of 'F'", "1 OVLD, 1 ol"),
    "an index beside a step": ("Sampling rate,100 Hz\nSample,F [N]\n0,1.5\n1,2.5\n2,0.5\n", 3, "Sample", "numbers the rows"),
}  # fmt: skip


@pytest.mark.parametrize("name", NAMED)
def test_what_is_not_read_is_named_with_its_lines(tmp_path, name):
    text, size, what, why = NAMED[name]
    found = read_recorded(written(tmp_path, text))
    assert found.size == size
    (said,) = (each for each in found.not_read if each.name == what)
    assert re.search(why, said.why)


REFUSED = {
    "two columns or decimals": ("0,512\n1,513\n2,611\n", r"as 0, 512 .*or as 0.512 .*decimal_comma=true, or false"),
    "thousands or decimals": ("t;F\n1,234;5,678\n2,345;6,789\n", r"as 1234, 5678 .*thousands.*or as 1.234, 5.678"),
    "the same with units": ('"I";"v"\n"23,206 mA";"32,727 mm/s"\n"-92,329 mA";"30,654 mm/s"\n', "as 23206, 32727.*or as 23.206"),
    "one column in quotes": ('"F","State"\n"-18,050","wait"\n"51,944","OK"\n', "as -18050 .*or as -18.05 "),
    "integers with points": ('"t","F"\n"0","7.970"\n"10","643"\n', "as 0, 7.97 .*or as 0, 7970"),
    "commas between columns and in decimals": ("Time,Force\n0,1,1,5\n0,2,1,7\n", "4 fields in each row below 2 headings"),
    "decimals with both": ("t;F;G\n0.5;1,25;7.5\n1.5;2,5;8.5\n2.5;2,7;9.5\n", "column 'F' holds '1,25' in line 2.*both signs"),
    "words in the first column": (HEADED + ROWS + "abc,1,2\n" + MORE, "line 42: 'abc' is not a number"),
    "a row that is cut off": (HEADED + ROWS + "99,1\n", "line 42 has 2 fields"),
}  # fmt: skip


@pytest.mark.parametrize("name", REFUSED)
def test_what_nothing_decides_is_refused_with_both_readings(tmp_path, name):
    text, words = REFUSED[name]
    with pytest.raises(DataFileError, match=words):
        read_recorded(written(tmp_path, text))


def test_the_decimal_sign_decides(tmp_path):
    path = written(tmp_path, REFUSED["thousands or decimals"][0])
    for comma, expected in ((True, [5.678, 6.789]), (False, [5678, 6789])):
        assert list(read_recorded(path, decimal_comma=comma).channels[1].values) == expected


@pytest.mark.parametrize(
    ("heading", "expected"),
    [
        ("Re(Z)", ("Re(Z)", "")), ("V(a)", ("V(a)", "")), ("V(mV)", ("V", "mV")), ("I(R1)", ("I(R1)", "")),
        ("I (A)", ("I", "A")),
        ("tan(delta)", ("tan(delta)", "")), ("Force (raw)", ("Force (raw)", "")), ("T (°C)", ("T", "°C")),
        ("x [odd]", ("x", "odd")),
        ("F / mN", ("F", "mN")), ("v/mm/s", ("v", "mm/s")), ("p (mbar)", ("p", "mbar")), ("G (mS)", ("G", "mS")),
    ],
)  # fmt: skip
def test_brackets_hold_a_unit_or_belong_to_the_name(heading, expected):
    assert name_and_unit(heading) == expected


def test_units_in_greek_and_with_a_small_prefix():
    assert [as_unit(each) for each in ("\u03bcA", "\u00b5m", "mHz", "MHz", "min", "kΩ")] == [
        "uA", "um", "mHz", "MHz", "min", "kohm",
    ]  # fmt: skip
