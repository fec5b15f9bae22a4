"""Text files of instruments, written after the public layouts of their makes: names, units, times and tables."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest
import scipy.io
from damaged_records import read_damaged

from electrovib.core.errors import DataFileError
from electrovib.data.registry import format_of, read_recorded
from electrovib.data.spectrum import spectrum_of
from electrovib.data.text.stamps import seconds_from_first

pytestmark = pytest.mark.usefixtures("forked")

T = -1e-5 + 1e-6 * np.arange(40)
V, W = np.sin(3e5 * T), np.cos(3e5 * T)
G = np.geomspace(1e5, 10, 40)
Z = 100 + 5e4 / (1 + 2j * np.pi * G * 5e4 * 1e-9)
PHASE = np.degrees(np.angle(Z))


def rows(form, *columns):
    return "\n".join(form.format(*row) for row in zip(*columns, strict=True)) + "\n"


def numbered(form, *columns):
    return rows(form, np.arange(40), *columns)


SIDE = [
    "Record Length,2500,Points,",
    "Sample Interval,1e-06,s,",
    "Source,CH2,,",
    "Vertical Units,V,,",
    "Horizontal Units,s,,",
]
LAYOUTS = {
    "settings beside the numbers": (
        "\n".join(f"{key}{time:.9e},{volt:.7f}," for key, time, volt in zip(SIDE + [",,,"] * 35, T, V, strict=True)),
        ["time", "CH2"], ["s", "V"],
    ),
    "a row of vertical units": (
        "Model,MSO4034B\n\nPoint Format,Y,,\nHorizontal Units,s,,\nSample Interval,1e-06,,\nVertical Units,V,A,\n,,\n"
        "Label,Drive,Load,\nTIME,CH1,CH2\n" + rows("{:.9e},{:.7f},{:.7f}", T, V, W),
        ["TIME", "CH1", "CH2"], ["s", "V", "A"],
    ),
    "units with their channel": (
        "Record Length,Analog:40\nVertical Units,CH1:V,CH3:A\nVertical Scale,CH1:0.50,CH3:0.50\nHorizontal Units,s\n"
        "Model Number,SDS1104X-E\nSource,CH1,CH3\nSecond,Value,Value\n"
        + rows("{:.9e},{:.7f},{:.7f}", T, V, W),
        ["Source", "CH1", "CH3"], ["s", "V", "A"],
    ),
    "a setting above the units": (
        "Record Length,Analog:40\nVertical Scale,CH1: 0.05\nHorizontal Scale, 0.000010000\nSecond,Volt\n"
        + rows("{:.9e},{:.7f}", T, V),
        ["time", "Volt"], ["s", "V"],
    ),
    "numbers as headings": ("x-axis,1,2\nsecond,Volt,Volt\n" + rows("{:.9e},{:.7f},{:.7f}", T, V, W),
        ["x-axis", "1", "2"], ["s", "V", "V"]),
    "an empty heading of the time": (",CH1\nSecond,Volt\n" + rows("{:.9e},{:.7f}, ", T, V), ["time", "CH1"], ["s", "V"]),
    "start and increment of one channel": (
        "X,CH2,Start,Increment,\nSequence,Volt,-1.0e-05,1.0e-06,\n" + numbered("{},{:.7f},", V), ["CH2"], ["V"],
    ),
    "settings with colons": (
        "Points:,40\nXInc:,1e-06\nXOrg:,-1E-05\nXUnits:,second\nYUnits:,Volt\nTime:,11:53:15\nData:\n" + rows("{:.7f}", V),
        ["column 0"], ["V"],
    ),
    "settings with one number each": (
        "LabVIEW Measurement\t\nWriter_Version\t2\nSeparator\tTab\n***End_of_Header***\t\nChannels\t1\t\nY_Unit_Label\tVolts\t\n"
        "X_Dimension\tTime\t\nX0\t-1E-5\t\nDelta_X\t0.000001\t\n***End_of_Header***\t\t\nX_Value\tVoltage\tComment\n"
        + rows("\t{:.7f}\t", V),
        ["Voltage"], ["V"],
    ),
    "settings of each trace": (
        '"Model Name","DL850E"\n"BlockNumber",1\n"TraceName","CH1","CH2"\n"BlockSize",40,40\n"VUnit","V","A"\n'
        '"HResolution",1.0E-06,1.0E-06\n"HOffset",-1.0E-05,-1.0E-05\n"Date","2012/10/10","2012/10/10"\n'
        '"Time","10:10:10.1","10:10:10.1"\n' + rows(",{:.7f},{:.7f}", V, W),
        ["CH1", "CH2"], ["V", "A"],
    ),
    "titles of channels": (
        "Interval=\t1E-06 s\nDateFormat=\t\nChannelTitle=\tForce\tVolt\nRange=\t10.00 V\t5 V\n"
        + rows("{:.9e}\t{:.7f}\t{:.7f}", T, V, W),
        ["column 0", "Force", "Volt"], ["", "", ""],
    ),
    "an index and a time interval": (
        "Channel :,CH1,CH2\nTime interval :,1.00000uS,1.00000uS\nStart :,-10us\nindex,CH1_Voltage(mV),CH2_Voltage(mV)\n"
        + numbered("{},{:.7f},{:.7f}", V, W),
        ["CH1_Voltage", "CH2_Voltage"], ["mV", "mV"],
    ),
    "a sign of number as heading": (
        "Save Time,2020-01-01 10:00:00\n#,Time(ms),CH1(mV)\n" + numbered("{},{:.9f},{:.7f}", 1e3 * T, V),
        ["column 0", "Time", "CH1"], ["", "ms", "mV"],
    ),
    "a clock in a comment": ("#CHANNEL:CH1\n#CLOCK=1.0uS\n#Start=-10us\n" + rows("{:.7f}", V), None, None),
    "a time that is not the first column": (
        "mode\tNs\ttime/s\tEwe/V\n" + rows("2\t0\t{:.9e}\t{:.7f}", T + 1e-5, V),
        ["mode", "Ns", "time", "Ewe"], ["", "", "s", "V"],
    ),
    "start and increment of two channels": (
        "X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-1.0e-05,1.0e-06\n" + numbered("{},{:.7f},{:.7f},,", V, W),
        ["CH1", "CH2"], ["V", "V"],
    ),
    "a comma at the end": ("Time(s),CH1(V)\n" + rows("{:.9e},{:.7f},", T, V), ["Time", "CH1"], ["s", "V"]),
    "a table of segments": (
        "LECROYWR64Xi,12345,Waveform\nSegments,1,SegmentSize,40\nSegment,TrigTime,TimeSinceSegment1\n"
        "#1,21-Mar-2016 09:37:08,0\nTime,Ampl,Ampl\n" + rows("{:.9e},{:.7f},{:.7f}", T, V, W), None, None,
    ),
    "decimal commas": (
        "Zeit [s];Kanal 1 [V];Kanal 2 [V]\n" + rows("{:.9e};{:.7f};{:.7f}", T, V, W).replace(".", ","),
        ["Zeit", "Kanal 1", "Kanal 2"], ["s", "V", "V"],
    ),
    "tabs and a row of units": (
        "time\tforce\n[s]\t[N]\n" + rows("{:.9e}\t{:.7f}", T, V), ["time", "force"], ["s", "N"],
    ),
    "blanks": ("# a comment\n" + rows("{:.9e}   {:.7f}   {:.7f}", T, V, W), None, None),
    "no headings": (rows("{:.9e},{:.7f},{:.7f}", T, V, W), None, None),
    "units in brackets and an empty row": (
        "Time,Channel A\n(ms),(V)\n\n" + rows("{:.9f},{:.7f}", 1e3 * T, V), ["Time", "Channel A"], ["ms", "V"],
    ),
    "comments above headings": (
        "#Digilent WaveForms Oscilloscope\n#Device Name: x\n\nTime (s),Channel 1 (V)\n" + rows("{:.9e},{:.7f}", T, V),
        ["Time", "Channel 1"], ["s", "V"],
    ),
    "units behind in": ("in s,C1 in V\n" + rows("{:.9e},{:.7f}", T, V), None, None),
    "numbered rows": (",t,u\n" + numbered("{},{:.9e},{:.7f}", T, V), ["column 0", "t", "u"], ["", "", ""]),
    "a comment as headings": ("% t u\n" + rows("{:.9e} {:.7f}", T, V), None, None),
    "a sample rate": ("Sample Rate: 1 MHz\nStart: -10 us\nCH1;CH2\n" + rows("{:.7f};{:.7f}", V, W), ["CH1", "CH2"], ["", ""]),
}  # fmt: skip


@pytest.mark.parametrize("name", LAYOUTS)
def test_names_units_and_times_are_those_of_the_preamble(tmp_path, name):
    text, names, units = LAYOUTS[name]
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    found = read_recorded(tmp_path / "a.csv")
    if names is not None:
        assert [each.name for each in found.channels] == names
        assert [each.unit for each in found.channels] == units
    scale = {"ms": 1e-3}.get(next((each.unit for each in found.channels if each.name == found.time), ""), 1)
    times = found.times() * scale
    np.testing.assert_allclose(times - times[0], T - T[0], atol=2e-12)
    assert times[0] == pytest.approx(0 if "not the first" in name else -1e-5)
    second = f"{W[9]:.7f}".partition(".")[2] in text
    for known in (V, W) if second else (V,):
        assert any(
            each.values.size == 40 and np.abs(each.values - known).max() < 1e-6 for each in found.channels
        )
    if name == "units with their channel":
        assert found.attributes["Model Number"] == "SDS1104X-E"


@pytest.mark.parametrize("encoding", ["latin-1", "utf-16"])
def test_text_is_read_in_every_encoding(tmp_path, encoding):
    (tmp_path / "a.csv").write_text(
        "Zeit [µs],Öl [V]\n" + rows("{:.9e},{:.7f}", 1e6 * T, V), encoding=encoding
    )
    found = read_recorded(tmp_path / "a.csv")
    assert [(each.name, each.unit) for each in found.channels] == [("Zeit", "us"), ("Öl", "V")]
    np.testing.assert_allclose(found.channels[1].values, V, atol=1e-7)


def second(options, reference=""):
    """Begin a Touchstone file of version 2."""
    return f"[Version] 2.0\n{options}\n[Number of Ports] 1\n[Number of Frequencies] {G.size}\n{reference}\n[Network Data]\n"


SPECTRA = {
    "nova.txt": "Index;Frequency (Hz);Z' (Ω);-Z'' (Ω);Z (Ω);-Phase (°)\n"
    + numbered("{};{:.8g};{:.8g};{:.8g};{:.8g};{:.8g}", G, Z.real, -Z.imag, abs(Z), -PHASE),
    "autolab.txt": "Freq(Hz),t,s,idx,Z',Z''\n" + rows("{:.8g},0,0,1,{:.8g},{:.8g}", G, Z.real, Z.imag),
    "z60w.txt": '"Z60W Data File: Version 1.1"\n""\n""\n0,2,0,1,0.1,10000\n41\n'
    "\"  Freq (Hz)    Ampl     Bias   Time(Sec)   Z'(a)    Z''(b)    GD   Err   Range\"\n"
    + rows("{:.8g},0,0,0,{:.9g},{:.9g},0,0,0", G, Z.real, Z.imag),
    "powersuite.txt": "Frequency\t Zre\t Zimg\n" + rows("{:.8g}\t {:.8g}\t {:.8g}", G, Z.real, Z.imag),
    "parstat_samples.txt": "Potential (V)\tElapsed Time (s)\tFrequency (Hz)\tZre (ohms)\tZim (ohms)\t\n"
    + rows("3.4\t{}\t0\t0\t0\t", range(30)) + rows("3.4\t{}\t{:.8g}\t{:.8g}\t{:.8g}\t", range(40), G, Z.real, Z.imag),
    "parstat.txt": "Segment\tPoint\tE(V)\tFrequency(Hz)\tZre(ohms)\tZim(ohms)\n"
    + numbered("0\t{}\t0.1\t{:.8g}\t{:.8g}\t{:.8g}", G, Z.real, Z.imag),
    "versa.par": "<Application>\nName=VersaStudio\n</Application>\n<Experiment>\nSegments=1\n</Experiment>\n<Segment1>\nType=2\n"
    "Definition=Segment #, Point #, E(V), I(A), Elapsed Time(s), Frequency(Hz), Z Real, Z Imag, ActionId, 0\n"
    + numbered("0,{},0.1,1e-6,1,{:.8g},{:.8g},{:.8g},4", G, Z.real, Z.imag)
    + "</Segment1>\n\n" + "".join(f"<Graph{at}>\nHeight=291\nWidth={at}\n</Graph{at}>\n" for at in range(80)),
    "chi.txt": "Feb. 2, 2021   10:10:10\nA.C. Impedance\nHeader: \n\nInit E (V) = 0\nLow Frequency (Hz) = 1\n\n"
    "Freq/Hz, Z'/ohm, Z\"/ohm, Z/ohm, Phase/deg\n\n"
    + rows("{:.8e}, {:.8e}, {:.8e}, {:.8e}, {:.6f}", G, Z.real, Z.imag, abs(Z), PHASE),
    "comma.mpt": "EC-Lab ASCII FILE\nNb header lines : 5\n\nPEIS\nfreq/Hz\tRe(Z)/Ohm\t-Im(Z)/Ohm\t|Z|/Ohm\n"
    + rows("{:.7E}\t{:.7E}\t{:.7E}\t{:.7E}", G, Z.real, -Z.imag, abs(Z)).replace(".", ","),
    "a.dta": "EXPLAIN\nTAG\tEISPOT\nAREA\tQUANT\t2.5\tArea (cm^2)\nOCVCURVE\tTABLE\t3\n\tPt\tT\tVf\n\t#\ts\tV vs. Ref.\n"
    + rows("\t{}\t{}\t0.1", range(60), range(60))
    + "EOC\tQUANT\t0.1\tOpen Circuit (V)\nZCURVE\tTABLE\n\tPt\tTime\tFreq\tZreal\tZimag\tZphz\n\t#\ts\tHz\tohm\tohm\t°\n"
    + numbered("\t{}\t1\t{:.8g}\t{:.8g}\t{:.8g}\t{:.8g}", G, Z.real, Z.imag, PHASE),
    "e4990.csv": "!CSV A.01.01\n!Agilent Technologies,E4990A\nBEGIN CH1_DATA\n"
    "Frequency(Hz), Trace 1 |Z|(Ohm), Trace 2 Theta-z(deg)\n"
    + rows("{:.8E}, {:.8E}, {:.8E}", G, abs(Z), PHASE) + "END\n",
    "solartron.csv": "Frequency (Hz),Impedance Magnitude (Ohms),Impedance Phase Degrees (')\n"
    + rows("{:.8g},{:.8g},{:.8g}", G, abs(Z), PHASE),
    "discovery.csv": "#Digilent WaveForms Impedance Analyzer\n\nFrequency (Hz),Trace θ (deg),Trace |Z| (Ohm)\n"
    + rows("{:.8g},{:.8g},{:.8g}", G, PHASE, abs(Z)),
    "z2.s1p": second("# kHz Z MA R 50", "[Reference]\n75") + rows("{:.8g} {:.8g} {:.8g}", G / 1e3, abs(Z), PHASE) + "[End]\n",
    "y2.ts": second("# hz y ri r 2") + rows("{:.8g} {:.8g} {:.8g}", G, (1 / Z).real, (1 / Z).imag) + "[Noise Data]\n1 2 3 4\n",
    "s2.ts": "! by a VNA\n" + second("# Hz S RI R 50", "[Reference]\n! of port 1\n 1000") + rows(
        "{:.12g} {:.12g} {:.12g}", G, ((Z - 1e3) / (Z + 1e3)).real, ((Z - 1e3) / (Z + 1e3)).imag
    ),
    "z.s1p": "! VNA\n# kHz Z MA R 50\n" + rows("{:.8g} {:.8g} {:.8g}", G / 1e3, abs(Z) / 50, PHASE),
    "y.s1p": "# r 2 hz ri y\n" + rows("{:.8g} {:.8g} {:.8g}", G, (2 / Z).real, (2 / Z).imag),
    "s.s1p": "!\n# Hz S DB R 1000 ! comment\n" + rows(
        "{:.8g} {:.12g} {:.12g}", G, 20 * np.log10(abs((Z - 1e3) / (Z + 1e3))), np.degrees(np.angle((Z - 1e3) / (Z + 1e3)))
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", SPECTRA)
def test_spectra_of_instruments_are_read_without_an_option(tmp_path, name):
    (tmp_path / name).write_text(SPECTRA[name], encoding="utf-8")
    found = spectrum_of(read_recorded(tmp_path / name))
    np.testing.assert_allclose(found.frequency, G[::-1], rtol=1e-6)
    np.testing.assert_allclose(found.impedance, Z[::-1], rtol=1e-5)


PACKAGED = {
    "a.dta": SPECTRA["a.dta"],
    "chi.txt": SPECTRA["chi.txt"],
    "a.mpt": SPECTRA["comma.mpt"].replace(",", "."),
    "a.z": "ZPLOT2 ASCII\n  Freq(Hz)\tAmpl\tBias\tTime(Sec)\tZ'(a)\tZ''(b)\nEnd Comments\n"
    + rows("{:.9E}\t0\t0\t0\t{:.9E}\t{:.9E}", G, Z.real, Z.imag),
}


@pytest.mark.skipif(importlib.util.find_spec("impedance") is None, reason="needs the package impedance")
@pytest.mark.parametrize("name", PACKAGED)
def test_the_reader_of_text_agrees_with_the_package_impedance(tmp_path, name):
    (tmp_path / name).write_text(PACKAGED[name], encoding="latin-1")
    found = spectrum_of(read_recorded(tmp_path / name, reader="impedance"))
    np.testing.assert_allclose(found.impedance, Z[::-1], rtol=1e-6)
    assert format_of(tmp_path / name).name == ("impedance" if name == "a.z" else "text")
    if name != "a.z":
        own = spectrum_of(read_recorded(tmp_path / name))
        np.testing.assert_allclose(own.impedance, found.impedance, rtol=1e-7)


def test_a_table_or_an_array_of_a_file_of_several_is_chosen(tmp_path):
    (tmp_path / "a.dta").write_text(SPECTRA["a.dta"], encoding="utf-8")
    found = read_recorded(tmp_path / "a.dta", part="OCVCURVE")
    assert [(each.name, each.unit) for each in found.channels] == [("Pt", ""), ("T", "s"), ("Vf", "V")]
    assert (found.size, found.time) == (60, "T")
    known = {"table": "OCVCURVE", "AREA": "2.5"}
    assert known.items() <= found.attributes.items()
    (tmp_path / "a.csv").write_text("t,u\n0,1\n1,2\n", encoding="utf-8")
    trial = {"force": np.arange(7.0), "time": np.arange(7.0)}
    scipy.io.savemat(tmp_path / "a.mat", {"long": np.arange(50.0), "trial": trial})
    assert [each.name for each in read_recorded(tmp_path / "a.mat").channels] == ["long"]
    found = read_recorded(tmp_path / "a.mat", part="trial.force")
    assert [each.name for each in found.channels] == ["trial.force", "trial.time"]
    for name, part, words in (
        ("a.dta", "ZCURV", r"no such table. Did you mean 'ZCURVE'\? It has OCVCURVE, ZCURVE"),
        ("a.csv", "ZCURVE", "does not consist of parts with names"),
        ("a.mat", "trail", r"no such array. .*It has long \(50\), trial.force \(7\)"),
    ):
        with pytest.raises(DataFileError, match=words):
            read_recorded(tmp_path / name, part=part)


STAMPS = {
    "iso": ["2024-02-28T23:59:59.500Z", "2024-02-29T00:00:01.000Z", "2024-03-01T00:00:00.500Z"],
    "half days": ["1/31/2024 11:59:59.5 AM", "1/31/2024 12:00:01 PM", "2/1/2024 12:00:00.5 PM"],
    "day first": ["31.01.2024 23:59:59,5", "01.02.2024 00:00:01,0", "02.02.2024 00:00:00,5"],
    "midnight": ["23:59:59.5", "0:00:01", "23:59:59.75"],
}


@pytest.mark.parametrize("name", STAMPS)
def test_dates_and_times_of_day_become_seconds(name):
    time, order = seconds_from_first(STAMPS[name])
    assert time == pytest.approx([0, 1.5, 86400.25 if name == "midnight" else 86401.0])
    assert order == ""


def test_an_open_order_of_day_and_month_is_stated_and_two_columns_are_one_time(tmp_path):
    text = "Moment,F (N)\n03/01/2024 10:00:00,1\n03/02/2024 10:00:00,2\n03/03/2024 10:00:00,3\n"
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    found = read_recorded(tmp_path / "a.csv")
    assert found.attributes["date_order"] == "month/day"
    assert found.attributes["first_time"] == "03/01/2024 10:00:00"
    np.testing.assert_allclose(found.times(), [0, 86400, 2 * 86400])
    assert [each.name for each in found.channels] == ["time", "F"]
    assert seconds_from_first(["03.01.2024 10:00:00", "04.01.2024 10:00:00"])[1] == "day.month"
    lines = [f"03/01/2024,10:00:{second:02d}.500,{second}" for second in range(20)]
    (tmp_path / "a.csv").write_text("\n".join(["Date,Time,Force (N)", *lines]), encoding="utf-8")
    np.testing.assert_allclose(read_recorded(tmp_path / "a.csv").times(), np.arange(20))


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("Time,Channel A\n(ms),(V)\n\n0,1\n1,∞\n2,-∞\n3,OL\n4,2\n", [1, np.nan, np.nan, np.nan, 2]),
        ("t [s],f [N]\n0,1\n1,\n2,****\n3,4\n4,5\n", [1, np.nan, np.nan, 4, 5]),
        ('"0" "1.5"\n"1" "2.5"\n"2" "5"\n', [1.5, 2.5, 5]),
    ],
    ids=["out of range", "empty and starred", "quoted between blanks"],
)
def test_readings_that_are_none_are_missing_and_quoted_ones_are_numbers(tmp_path, text, expected):
    (tmp_path / "a.csv").write_text(text, encoding="utf-8")
    np.testing.assert_array_equal(read_recorded(tmp_path / "a.csv").channels[1].values, expected)


@pytest.mark.parametrize(
    ("name", "text", "words"),
    [
        ("a.csv", "only words\nand more\n", "no rows of numbers"),
        ("a.csv", "a,b\n1,2\n3,4\n5,6\n7\n9,10\n", r"line 5 has 1 fields.*cut off"),
        ("a.csv", "a;b\n1;2\n3;4\n5;x\n7;8\n9;9\n1;1\n1;1\n", r"line 4: 'x' is not a number"),
        ("a.csv", "a,b\n1,2\n", "fewer than two rows"),
        ("a.csv", "1;" * 100_000 + "1\n", "more than 1024 columns"),
        ("a.csv", "# of 1,025 fields\n" + "1 2.5 " * 600 + "\n", "more than 1024 columns"),
        ("a.csv", "t,u\n0,1\n1,٢\n2,3\n3,4\n", "'٢' is not a number"),
        ("a.csv", "a,b\n1,2\n3,4\n" + "9" * 120_000 + "x,5\n6,7\n8,9\n1,1\n", "is not a number"),
        ("a.s1p", "# Hz S RI R 50\n1 2 3 4 5\n1 2 3 4 5\n", "rows do not have three numbers"),
        (
            "a.s2p",
            "# Hz S RI R 50\n" + "1 2 3 4 5 6 7 8 9\n" * 2,
            "states 2 ports, .* one reflection such as S11, as .s1p",
        ),
        ("a.ts", second("# Hz Z RI").replace("Ports] 1", "Ports] 4") + "1 2 3\n" * 2, "states 4 ports"),
        ("a.ts", second("# Hz Z RI") + "1 2 3\n" * 2, f"states {G.size} frequencies and holds 2"),
        ("a.ts", second("# Hz Z RI", "[Reference] -3") + "1 2 3\n" * 2, "states '-3' for .Reference., where"),
        ("a.s1p", "# Hz H RI R 50\n1 2 3\n2 2 3\n", "states the parameters H"),
        ("a.s1p", "# Hz S RI R x\n1 2 3\n2 2 3\n", "states 'X' for .Reference."),
        ("a.s1p", "# Hz S RI R 50\n1 2 a\n2 2 3\n", "not made of numbers"),
    ],
)
def test_what_is_no_table_is_refused_with_what_helps(tmp_path, name, text, words):
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(DataFileError, match=words):
        read_recorded(tmp_path / name)


def test_a_long_heading_takes_no_time_and_is_shortened(tmp_path):
    (tmp_path / "b.csv").write_text("a" + " " * 100_000 + "(b,c\n1,2\n3,4\n", encoding="utf-8")
    assert len(read_recorded(tmp_path / "b.csv").channels[0].name) <= 200


REGRESSIONS = sorted((Path(__file__).parents[2] / "fuzz" / "regressions").glob("*"))


@pytest.mark.parametrize("path", REGRESSIONS, ids=lambda path: path.name)
def test_what_fuzzing_found_stays_mended(path, tmp_path):
    copy = tmp_path / path.name
    copy.write_bytes(path.read_bytes())
    assert read_damaged(copy) in ("read", "refused")
