"""Binary and foreign formats: which reader takes a file, what it holds, what is omitted, what a missing package is told."""

import importlib.util
import struct
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
from damaged_records import lecroy, mat73, tektronix_wfm
from scipy.io import wavfile

import electrovib as ev
from electrovib.core.errors import DataFileError, NoColumnError
from electrovib.data import readers, registry
from electrovib.data.readers.oscilloscope_binary import _step
from electrovib.data.registry import FORMATS, CanRead, format_lines, format_of, read_columns, read_recorded

pytestmark = pytest.mark.usefixtures("forked")

T = np.arange(50) * 1e-4
V = np.sin(600 * T)


def names(found):
    return [each.name for each in found.channels]


def test_numpy_rows_columns_and_fields(tmp_path):
    np.save(tmp_path / "a.npy", np.column_stack([T, V]))
    found = read_recorded(tmp_path / "a.npy")
    assert names(found) == ["column 0", "column 1"]
    assert (found.time, found.times()) == ("", None)
    np.testing.assert_array_equal(found.channels[1].values, V)
    np.save(tmp_path / "b.npy", np.ones((2, 65)))
    turned = read_recorded(tmp_path / "b.npy")
    assert turned.attributes["arrangement"] == "a row per signal: column 0 is the first row"
    assert turned.size == 65
    fields = np.zeros(5, [("time [ms]", "f8"), ("force [N]", "f4"), ("word", "U3")])
    fields["time [ms]"] = np.arange(5)
    np.save(tmp_path / "c.npy", fields)
    named = read_recorded(tmp_path / "c.npy")
    assert [(each.name, each.unit) for each in named.channels] == [("time", "ms"), ("force", "N")]
    assert named.time == "time"


@pytest.mark.parametrize("compressed", [False, True])
def test_matlab_structs_by_dotted_path(tmp_path, compressed):
    content = {
        "dataQ": np.column_stack([T, V]),
        "trial": {"force": V, "deep": {"x": T}, "word": "x"},
        "few": T[:7],
    }
    scipy.io.savemat(tmp_path / "a.mat", content, do_compression=compressed)
    found = read_recorded(tmp_path / "a.mat")
    assert names(found) == ["dataQ[0]", "dataQ[1]", "trial.force", "trial.deep.x"]
    np.testing.assert_array_equal(found.channels[2].values, V)
    np.testing.assert_array_equal(found.channels[3].values, T)
    assert [each.name for each in found.not_read] == ["few", "trial.word"]


def test_matlab_of_version_73_and_hdf5_groups_with_units(tmp_path):
    (tmp_path / "a.mat").write_bytes(mat73({"record": np.array([T, V]).T, "trial/force": V[:, None]}))
    found = read_recorded(tmp_path / "a.mat")
    assert names(found) == ["record[0]", "record[1]", "trial.force"]
    np.testing.assert_array_equal(found.channels[1].values, V)
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/force"], file["run/time"], file["other"], file["word"] = V, T, V[:20], "x"
        file["run/force"].attrs["units"], file["run/time"].attrs["units"] = "N", "s"
        file["outside"] = h5py.ExternalLink("b.h5", "x")
    found = read_recorded(tmp_path / "a.h5")
    assert [(each.name, each.unit) for each in found.channels] == [("run/force", "N"), ("run/time", "s")]
    assert (found.time, [each.name for each in found.not_read]) == ("run/time", ["other", "outside", "word"])
    np.testing.assert_array_equal(found.channels[0].values, V)


def pickled(path):
    np.save(path, np.array([{"a": 1}], dtype=object), allow_pickle=True)


def packed_sheet(path):
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "x")
        archive.writestr("xl/worksheets/sheet1.xml", bytes(40_000_000))


@pytest.mark.parametrize(
    ("name", "write", "words"),
    [
        ("a.npy", pickled, "holds Python objects, which are not unpickled"),
        ("a.xlsx", packed_sheet, "would unpack to 40 MB"),
    ],
)
def test_nothing_is_unpickled_and_nothing_unpacked_that_declares_too_much(
    tmp_path, monkeypatch, name, write, words
):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    write(tmp_path / name)
    with pytest.raises(DataFileError, match=words):
        read_recorded(tmp_path / name)


HEADS = {
    "tdms": (b"TDSm" + bytes(40), "nptdms"),
    "xlsx": (b"PK\x03\x04" + bytes(26) + b"[Content_Types].xml", "openpyxl"),
    "scope": (b"\x0f\x0f:WFM#003" + bytes(40), "RigolWFM"),
    "impedance": (b"ZPLOT2 ASCII\n1\n", "impedance"),
}


@pytest.mark.parametrize("name", HEADS)
def test_a_missing_package_is_answered_with_the_line_that_installs_it(tmp_path, name, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    (tmp_path / "a").write_bytes(HEADS[name][0])
    assert format_of(tmp_path / "a").name == name
    with pytest.raises(DataFileError, match=r"a: .*pip install 'electrovib\[formats\]'") as found:
        read_recorded(tmp_path / "a")
    assert HEADS[name][1] in str(found.value)


@pytest.mark.parametrize(
    ("head", "name"),
    [
        (b"#9000000123WAVEDESC\0", "scope"), (b"AG10\0\0", "scope"), (b"RG01\0\0", "scope"), (b"\x93NUMPY\1", "numpy"),
        (b"MATLAB 5.0 MAT", "matlab"), (b"CDF\x01", "hdf5"), (b"\x89HDF\r\n\x1a\n", "hdf5"), (b"a,b\n1,2\n", "text"),
        (b"EC-Lab ASCII FILE\nNb header lines : 3\n", "text"), (b"ZPLOT2 ASCII\n1\n", "impedance"),
    ],
)  # fmt: skip
def test_formats_are_recognised_by_their_first_bytes(tmp_path, head, name, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: True)
    (tmp_path / "a.unknown").write_bytes(head)
    assert format_of(tmp_path / "a.unknown").name == name


def test_the_list_of_readers_names_all_of_them_as_the_documentation_does():
    lines = format_lines()
    assert [line.split()[0] for line in lines[:-1]] == [each.name for each in FORMATS]
    assert sum("; needs " in line for line in lines) == len(HEADS)
    page = Path(__file__).parents[3] / "docs" / "importing.md"
    rows = [("name", "reads", "package"), ("---", "---", "---")]
    rows += [(f"`{each.name}`", each.description, each.package or "none") for each in FORMATS]
    table = "\n".join(f"| {' | '.join(row)} |" for row in rows)
    assert table in page.read_text(encoding="utf-8")


def needs(module):
    return pytest.mark.skipif(
        importlib.util.find_spec(module) is None, reason=f"needs {module}: pip install 'electrovib[formats]'"
    )


@needs("nptdms")
def test_tdms(tmp_path):
    from nptdms import ChannelObject, TdmsWriter

    about = {"wf_increment": 1e-4, "wf_start_offset": 0.5, "unit_string": "mV"}
    with TdmsWriter(tmp_path / "a.tdms") as file:
        file.write_segment([ChannelObject("g", "f", V, about), ChannelObject("g", "few", V[:9])])
    found = read_recorded(tmp_path / "a.tdms")
    np.testing.assert_allclose(found.times(), 0.5 + T)
    assert [(each.name, each.unit) for each in found.channels] == [("g/f", "mV")]
    np.testing.assert_array_equal(found.channels[0].values, V)
    assert found.not_read[0].name == "g/few"


@needs("openpyxl")
def test_spreadsheets_and_the_choice_of_a_sheet(tmp_path):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["no numbers on this sheet"])
    for name, factor in (("first", 1), ("second", 2)):
        sheet = book.create_sheet(name)
        for row in (["a title"], ["time [ms]", "force [N]"], *zip(1e3 * T, factor * V, strict=True)):
            sheet.append(list(row))
    book.save(tmp_path / "a.xlsx")
    found = read_recorded(tmp_path / "a.xlsx")
    assert (found.time, found.attributes["sheet"]) == ("time", "first")
    assert [each.name for each in found.not_read] == ["Sheet", "second"]
    np.testing.assert_allclose(found.channels[1].values, V, rtol=1e-15)
    second = read_recorded(tmp_path / "a.xlsx", part="second")
    np.testing.assert_allclose(second.channels[1].values, 2 * V, rtol=1e-15)
    said = r"no such sheet with content. Did you mean 'second'\? It has Sheet, first, second"
    with pytest.raises(DataFileError, match=said):
        read_recorded(tmp_path / "a.xlsx", part="secnd")


@pytest.mark.parametrize("first_ends", [True, False])
def test_two_records_of_different_length_in_a_sheet_are_both_read(tmp_path, first_ends):
    """Before, the columns of the shorter one were omitted without a word."""
    openpyxl = pytest.importorskip("openpyxl", reason="needs the extra 'formats'")
    book = openpyxl.Workbook()
    book.active.append(["t (s)", "F (N)", "t2 (s)", "U (V)"])
    for at in range(60):
        one, two = [0.1 * at, 1.0 * at], [0.2 * at, 5.0 * at]
        short = at < 25
        book.active.append(
            [*(one if short or not first_ends else [None] * 2), *(two if short or first_ends else [])]
        )
    book.save(tmp_path / "a.xlsx")
    found = read_recorded(tmp_path / "a.xlsx")
    assert [each.name for each in found.channels] == ["t", "F", "t2", "U"]
    counts = [int(np.isfinite(each.values).sum()) for each in found.channels]
    assert counts == ([25, 25, 60, 60] if first_ends else [60, 60, 25, 25])
    signal, column, time = ("lateral_force", "F", "t") if first_ends else ("drive_voltage", "U", "t2")
    trace = ev.import_file(tmp_path / "a.xlsx", {signal: column}, time=time)
    np.testing.assert_allclose(trace.time, (0.1 if first_ends else 0.2) * np.arange(25))
    np.testing.assert_allclose(trace[signal], (1.0 if first_ends else 5.0) * np.arange(25))


@needs("RigolWFM")
@pytest.mark.parametrize("form", ["lecroy", "2<", "2>", "3<", "3>"])
def test_waveforms_of_lecroy_and_of_tektronix(tmp_path, form):
    counts = np.array([-3, 0, 5, 7, 100, -128, 4, 2])
    if form == "lecroy":
        raw, volts, times = lecroy(counts), 0.5 * counts - 2.0, -1e-3 + 1e-6 * np.arange(8)
    else:
        raw = tektronix_wfm(100 * counts, version=int(form[0]), order=form[1])
        volts, times = 0.2 * counts + 0.25, -1e-3 + 4e-6 * np.arange(8)
    (tmp_path / "a.wfm").write_bytes(raw)
    found = read_recorded(tmp_path / "a.wfm")
    np.testing.assert_allclose(found.channels[0].values, volts, rtol=1e-6)
    np.testing.assert_allclose(found.times(), times, atol=1e-9 if form == "lecroy" else 1e-12)
    assert not found.not_read
    assert form == "lecroy" or [(each.name, each.unit) for each in found.channels] == [("CH 1", "V")]


@needs("RigolWFM")
def test_a_waveform_of_tektronix_states_its_unit_its_frames_and_its_envelope(tmp_path):
    (tmp_path / "a.wfm").write_bytes(tektronix_wfm([1, 2, 3], unit=b"A", frames=3))
    found = read_recorded(tmp_path / "a.wfm")
    assert found.channels[0].unit == "A"
    assert found.channels[0].values.size == 3
    assert [each.name for each in found.not_read] == ["frames 2 to 3 of 3"]
    envelope, cut = tektronix_wfm([1, 2, 3], storage=1), tektronix_wfm([1, 2, 3])[:400]
    carrier = envelope + b"tekmeta!" + b"\x12\0\0\0IQ_centerFrequency\x03" + bytes(8)
    for raw, words in (
        (envelope, "a.wfm: holds an envelope"),
        (cut, "damaged or not .* Tektronix"),
        (carrier, "a.wfm: holds I and Q, the two parts of a modulated carrier"),
    ):
        (tmp_path / "a.wfm").write_bytes(raw)
        with pytest.raises(DataFileError, match=words):
            read_recorded(tmp_path / "a.wfm")


def test_stamps_that_a_package_spreads_over_one_interval_less_are_mended():
    """8192 samples over the time of 8192 samples, ends included, were 122 ppm long."""
    times = np.linspace(-0.5, 0.5, 8192)
    assert _step(times, 1 / 8192) == 1 / 8192
    assert _step(times, None) == pytest.approx(1 / 8191, rel=1e-12)
    assert _step(times, 2 / 8192) == pytest.approx(1 / 8191, rel=1e-12)  # another statement is not believed
    assert _step(1e-3 * np.arange(100), 1e-3) == pytest.approx(1e-3, rel=1e-12)


@pytest.mark.parametrize("kind", ["int16", "int32", "uint8", "float32"])
def test_sound_files(tmp_path, kind):
    exact = 0.5 * np.sin(np.linspace(0, 6, 200))
    full = {"int16": 2**15, "int32": 2**31, "uint8": 128, "float32": 1}[kind]
    stored = (exact * full + (128 if kind == "uint8" else 0)).astype(kind)
    wavfile.write(tmp_path / "a.wav", 8000, np.column_stack([stored, stored]))
    found = read_recorded(tmp_path / "a.wav")
    assert len(found.channels) == 2
    np.testing.assert_allclose(found.channels[1].values, exact, atol=1.01 / full if full > 1 else 1e-7)
    np.testing.assert_allclose(np.diff(found.times()), 1 / 8000)


@pytest.mark.parametrize("order", ["<", ">"])
def test_sound_files_of_24_bits_in_both_byte_orders(tmp_path, order):
    counts = [0, 1, -1, 2**23 - 1, -(2**23)]
    data = b"".join(each.to_bytes(3, "little" if order == "<" else "big", signed=True) for each in counts)
    form = struct.pack(f"{order}HHIIHH", 1, 1, 1000, 3000, 3, 24)
    size = struct.Struct(f"{order}I").pack
    parts = b"fmt " + size(16) + form + b"LIST" + size(3) + b"abc\0" + b"data" + size(len(data)) + data
    (tmp_path / "a.wav").write_bytes(
        (b"RIFF" if order == "<" else b"RIFX") + size(len(parts) + 4) + b"WAVE" + parts
    )
    found = read_recorded(tmp_path / "a.wav")
    np.testing.assert_array_equal(found.channels[0].values, np.array(counts) / 2**23)
    assert found.step == 1e-3


def test_a_file_is_known_by_its_content_not_by_its_name(tmp_path):
    (tmp_path / "a.dat").write_bytes(b":WFMPRE:BYT_NR 2;")
    assert format_of(tmp_path / "a.dat").name == "isf"
    (tmp_path / "b.isf").write_text("t,u\n0,1\n1,2\n", encoding="utf-8")
    answers = {each.name: each.can_read(b"t,u\n0,1", ".isf") for each in FORMATS}
    assert {name for name, answer in answers.items() if answer is CanRead.PERHAPS} == {"isf", "text"}
    assert CanRead.YES not in answers.values()
    (tmp_path / "a.mat").write_text("0 1\n77 -2.5\n156 300\n")  # as MATLAB saves with -ascii
    assert read_columns(tmp_path / "a.mat", {"v": (1, "V")})["v"].tolist() == [1.0, -2.5, 300.0]
    np.save(tmp_path / "b.npy", np.zeros((3, 2)))
    (tmp_path / "b.npy").rename(tmp_path / "b.csv")
    assert read_columns(tmp_path / "b.csv", {"v": (1, "V")})["v"].tolist() == [0.0, 0.0, 0.0]


@pytest.mark.parametrize(
    ("name", "content", "options", "words"),
    [
        ("a.raw", b"\x00\x01\x02" * 40, {}, "no format that is known. Known are .*; Tektronix"),
        ("a.raw", b"t,u\n0,1\n1,2\n", {"reader": "txt"}, "there is no reader 'txt'. Did you mean 'text'"),
        ("a.raw", b":WFMPRE:BYT_NR 2;", {"delimiter": ";"}, "delimiter does not belong to Tektronix"),
        ("a.raw", b"RIFF\x10\x00\x00\x00WAVEfmt ", {}, "damaged or not a sound file"),
        (
            "a.pssession",
            b"{}",
            {},
            "of a potentiostat or impedance analyser in its own form; export the spectrum there",
        ),
        ("c.npy", b"time,voltage\n0,1\n" * 9, {}, "is damaged or not a NumPy file"),
        ("c.nc", b"time,voltage\n0,1\n" * 9, {}, "is damaged or not a netCDF file"),
        ("c.wav", b"time,voltage\n0,1\n" * 9, {}, "is damaged or not a sound file"),
        ("c.dat", b"PAR1" + bytes(9), {}, "format Parquet"),
        ("c.dat", b"MDF     4.10    " + bytes(9), {}, "format MDF .* export the channels as .csv"),
        ("c.dat", b"SQLite format 3\0", {}, "a database .SQLite."),
        ("c.pkl", b"\x80\x04\x95" + bytes(9), {}, "a pickle of Python, which may run any program"),
        ("c.json", b"[[0, 1], [1, 2], [2, 3]]", {}, "is JSON, .* as .csv"),
        ("c.tdm", b'<?xml version="1.0"?>', {}, "XML, such as TDM of DIAdem"),
        (
            "c.xls",
            b"\n<HTML><table><tr><td>1</td></tr></table>",
            {},
            "a page of the web .HTML.; save the table",
        ),
    ],
)
def test_what_is_not_known_is_refused_with_what_is(tmp_path, name, content, options, words):
    (tmp_path / name).write_bytes(content)
    with pytest.raises(DataFileError, match=words):
        read_recorded(tmp_path / name, **options)


def test_options_of_text_and_columns_of_every_format(tmp_path):
    (tmp_path / "a.csv").write_text("0;1,5\n1;2,5\n2;3,5\n", encoding="utf-8")
    found = read_recorded(tmp_path / "a.csv", delimiter=";", decimal_comma=True)
    np.testing.assert_array_equal(found.channels[1].values, [1.5, 2.5, 3.5])
    wavfile.write(tmp_path / "a.wav", 8000, (np.array([0.0, 0.5, -0.25]) * 2**15).astype("i2"))
    found = read_columns(tmp_path / "a.wav", {"x": ("channel 1", "1")})["x"]
    np.testing.assert_array_equal(found, [0.0, 0.5, -0.25])
    with pytest.raises(DataFileError, match="column 'channel 1' is in '1', but a voltage is needed"):
        read_columns(tmp_path / "a.wav", {"x": (0, "V")})


def test_one_file_adds_a_reader(tmp_path, monkeypatch):
    """Every module of the folder is asked, and a new one needs no line elsewhere."""
    (tmp_path / "counts_of_a_lab.py").write_text(
        """
import numpy as np
from electrovib.data.recorded import FileFormat, begins
from electrovib.data.recorded import DataColumn, Recorded

def read(path):
    return Recorded(channels=(DataColumn(name="counts", unit="mV", values=np.array([1.0, 2.0, np.nan])),), step=1e-3)

FORMAT = FileFormat(name="lab", description="counts", can_read=begins(b"LAB"), read=read)
"""
    )
    monkeypatch.setattr(readers, "__path__", [*readers.__path__, str(tmp_path)])
    monkeypatch.setattr(registry, "FORMATS", registry._formats())
    assert [each.name for each in registry.FORMATS][-1] == "text"
    (tmp_path / "a.bin").write_bytes(b"LAB\0\1")
    assert registry.format_of(tmp_path / "a.bin").name == "lab"
    assert registry.read_recorded(tmp_path / "a.bin").channels[0].unit == "mV"
    found = read_columns(tmp_path / "a.bin", {"v": ("counts", "V")}, missing=True)["v"]
    np.testing.assert_array_equal(found, [1e-3, 2e-3, np.nan])
    with pytest.raises(DataFileError, match=r"row 2 \(first is 0\), column 'counts': nan is not a finite"):
        read_columns(tmp_path / "a.bin", {"v": (0, "V")})
    with pytest.raises(NoColumnError, match=r"there is no column 'count'\. Did you mean 'counts'"):
        read_columns(tmp_path / "a.bin", {"v": ("count", "V")})
