"""Text files of instruments, written after the public layouts of their makes."""

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.readers.text import read_laboratory_text

STEP, START = 4e-6, -1e-3
TIMES = START + STEP * np.arange(60)
FIRST, SECOND = np.sin(2e3 * TIMES), 0.1 * np.cos(3e3 * TIMES)


def rows(*columns, separator=",", end="", form="{:.9e}"):
    return "\n".join(
        separator.join(form.format(value) for value in row) + end for row in zip(*columns, strict=True)
    )


LAYOUTS = {
    "Tektronix TDS": "\n".join(
        f"{key},{value},,{time:.9e},{volt:.9e},"
        for (key, value), time, volt in zip(
            [("Record Length", "60"), ("Sample Interval", "4e-06"), ("Trigger Point", "250"), ("", ""), ("Source", "CH1"),
             ("Vertical Units", "V"), ("Vertical Scale", "5.0e-01"), ("Horizontal Units", "s"), ("Model Number", "TDS2024B")]
            + [("", "")] * 51, TIMES, FIRST, strict=True,
        )
    ),
    "Tektronix MSO": "Model,MSO4104\nFirmware Version,2.68\n\nWaveform Type,ANALOG\nPoint Format,Y\nHorizontal Units,s\n"
    "Sample Interval,4e-06\nRecord Length,60\n\nTIME,CH1,CH2\n" + rows(TIMES, FIRST, SECOND),
    "Rigol DS1000": "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.000000e-03,4.000000e-06\n"
    + rows(np.arange(60), FIRST, SECOND, end=",,"),
    "Rigol DS1000, times": "Time,X(CH1),X(CH2)\nSecond,Volt,Volt\n" + rows(TIMES, FIRST, SECOND),
    "Rigol MSO5000": "Time(s),CH1(V),CH2(V)\n" + rows(TIMES, FIRST, SECOND, end=","),
    "Keysight": "x-axis,1,2\nsecond,Volt,Volt\n" + rows(TIMES, FIRST, SECOND),
    "Siglent": "Record Length,Analog:60\nSample Interval,Analog:0.000004000000\nVertical Units,CH1:V,CH2:V\nVertical Scale,"
    "CH1:0.50,CH2:0.50\nHorizontal Units,s\nHorizontal Scale,0.0005\nModel Number,SDS1104X-E\nSerial Number,none\n"
    "Software Version,7.1.6.1.25R2\nSource,CH1,CH2\nSecond,Volt,Volt\n" + rows(TIMES, FIRST, SECOND),
    "LeCroy": "LECROYWR64Xi,12345,Waveform\nSegments,1,SegmentSize,60\nSegment,TrigTime,TimeSinceSegment1\n"
    "#1,21-Mar-2016 09:37:08,0\nTime,Ampl,Ampl\n" + rows(TIMES, FIRST, SECOND),
    "decimal commas": "Zeit [s];Kanal 1 [V];Kanal 2 [V]\n"
    + rows(TIMES, FIRST, SECOND, separator=";").replace(".", ","),
    "tabs and a row of units": "time\tforce\tvoltage\n[s]\t[V]\t[V]\n" + rows(TIMES, FIRST, SECOND, separator="\t"),
    "blanks": "# a comment\n" + rows(TIMES, FIRST, SECOND, separator="   "),
    "no headings": rows(TIMES, FIRST, SECOND),
    "PicoScope": "Time,Channel A,Channel B\n(ms),(V),(V)\n\n" + rows(1e3 * TIMES, FIRST, SECOND),
    "Digilent": "#Digilent WaveForms Oscilloscope\n#Device Name: x\n\nTime (s),Channel 1 (V),Channel 2 (V)\n"
    + rows(TIMES, FIRST, SECOND),
    "Rohde & Schwarz": "in s,C1 in V,C2 in V\n" + rows(TIMES, FIRST, SECOND),
    "LabVIEW": "LabVIEW Measurement\nSeparator\tTab\nDate\t2019/01/01\n***End_of_Header***\t\t\nChannels\t2\t\nSamples\t60\t60"
    "\nDelta_X\t4e-06\t4e-06\n***End_of_Header***\t\t\nX_Value\tVoltage\tVoltage 1\tComment\n"
    + rows(TIMES, FIRST, SECOND, separator="\t"),
    "numbered rows": ",t,u,w\n" + rows(np.arange(60), TIMES, FIRST, SECOND),
    "a comment of MATLAB": "% t u w\n" + rows(TIMES, FIRST, SECOND, separator=" "),
    "a sample rate": "Sample Rate: 250 kHz\nStart: -1 ms\nCH1;CH2\n" + rows(FIRST, SECOND, separator=";"),
}  # fmt: skip


@pytest.mark.parametrize("name", LAYOUTS)
@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "utf-16"])
def test_layouts_are_read_without_an_option(tmp_path, name, encoding):
    (tmp_path / "a.csv").write_text(LAYOUTS[name] + "\n", encoding=encoding)
    found = read_laboratory_text(tmp_path / "a.csv")
    unit = next((each.unit for each in found.channels if each.name == found.time), "s")
    times = found.times() * (1e-3 if unit == "ms" else 1)
    np.testing.assert_allclose(times, TIMES, rtol=0, atol=1e-11)
    columns = [each for each in found.channels if each.name not in (found.time, "column 0")]
    if name == "no headings":
        columns = list(found.channels[1:])
    np.testing.assert_allclose(columns[0].values, FIRST, rtol=0, atol=1e-8)
    if name != "Tektronix TDS":
        assert len(columns) == 2
        np.testing.assert_allclose(columns[1].values, SECOND, rtol=0, atol=1e-8)


def test_names_units_and_settings(tmp_path):
    (tmp_path / "a.csv").write_text(LAYOUTS["Siglent"], encoding="utf-8")
    found = read_laboratory_text(tmp_path / "a.csv")
    assert found.attributes["Model Number"] == "SDS1104X-E"
    assert [each.unit for each in found.channels] == ["s", "V", "V"]
    (tmp_path / "b.csv").write_text(LAYOUTS["decimal commas"], encoding="utf-8")
    named = read_laboratory_text(tmp_path / "b.csv")
    assert [(each.name, each.unit) for each in named.channels] == [
        ("Zeit", "s"),
        ("Kanal 1", "V"),
        ("Kanal 2", "V"),
    ]
    assert named.time == "Zeit"


def test_empty_and_starred_fields_are_missing(tmp_path):
    (tmp_path / "a.csv").write_text("t [s],f [N]\n0,1\n1,\n2,****\n3,4\n4,5\n", encoding="utf-8")
    found = read_laboratory_text(tmp_path / "a.csv")
    np.testing.assert_array_equal(found.channels[1].values, [1, np.nan, np.nan, 4, 5])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("only words\nand more\n", "no rows of numbers"),
        ("a,b\n1,2\n3,4\n5,6\n7\n9,10\n", r"line 5 has 1 fields.*cut off"),
        ("a;b\n1;2\n3;4\n5;x\n7;8\n9;9\n1;1\n1;1\n", r"line 4: 'x' is not a number"),
        ("a,b\n1,2\n", "fewer than two rows"),
    ],
)
def test_what_is_no_table_is_refused_with_what_helps(tmp_path, text, words):
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    with pytest.raises(DataFileError, match=words):
        read_laboratory_text(tmp_path / "a.csv")


def test_a_very_long_row_of_digits_is_refused_at_once(tmp_path):
    (tmp_path / "a.csv").write_text(
        "a,b\n1,2\n3,4\n" + "9" * 120_000 + "x,5\n6,7\n8,9\n1,1\n", encoding="utf-8"
    )
    with pytest.raises(DataFileError, match="is not a number"):
        read_laboratory_text(tmp_path / "a.csv")
    (tmp_path / "b.csv").write_text("a" + " " * 100_000 + "(b,c\n1,2\n3,4\n", encoding="utf-8")
    assert len(read_laboratory_text(tmp_path / "b.csv").channels[0].name) <= 200


def test_quoted_numbers_between_blanks_are_numbers(tmp_path):
    (tmp_path / "a.txt").write_text('"0" "1.5"\n"1" "2.5"\n"2" "5"\n', encoding="utf-8")
    found = read_laboratory_text(tmp_path / "a.txt")
    np.testing.assert_array_equal([each.values for each in found.channels], [[0, 1, 2], [1.5, 2.5, 5]])
