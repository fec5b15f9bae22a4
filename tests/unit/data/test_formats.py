"""Binary and foreign formats: what they hold, what is omitted, and what is answered without their package."""

import importlib.util
import struct
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest
import scipy.io
import xarray
from damaged_records import tektronix_wfm

from electrovib.core.errors import DataFileError
from electrovib.data.readers.impedance_file import read_impedance_file
from electrovib.data.recorded import check_package
from electrovib.data.registry import FORMATS, format_lines, format_of, format_table, read_recorded
from electrovib.data.spectrum import spectrum_of

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
    assert turned.attributes["arrangement"] == "a row per signal"
    assert turned.size == 65
    fields = np.zeros(5, [("time [ms]", "f8"), ("force [N]", "f4"), ("word", "U3")])
    fields["time [ms]"] = np.arange(5)
    np.save(tmp_path / "c.npy", fields)
    named = read_recorded(tmp_path / "c.npy")
    assert [(each.name, each.unit) for each in named.channels] == [("time", "ms"), ("force", "N")]
    assert named.time == "time"


def test_nothing_is_unpickled(tmp_path):
    np.save(tmp_path / "a.npy", np.array([{"a": 1}], dtype=object), allow_pickle=True)
    with pytest.raises(DataFileError, match="damaged or not a NumPy file"):
        read_recorded(tmp_path / "a.npy")


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
    assert found.attributes["omitted"] == "few (7)"


def test_matlab_of_version_73(tmp_path):
    with h5py.File(tmp_path / "a.mat", "w", userblock_size=512) as file:
        file.create_dataset("record", data=np.array([T, V]))
        file["record"].attrs["MATLAB_class"] = np.bytes_("double")
        file.create_group("trial").attrs["MATLAB_class"] = np.bytes_("struct")
        file["trial/force"] = V[None]
        file["trial/force"].attrs["MATLAB_class"] = np.bytes_("double")
    whole = (tmp_path / "a.mat").read_bytes()
    (tmp_path / "a.mat").write_bytes(b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM" + whole[128:])
    found = read_recorded(tmp_path / "a.mat")
    assert names(found) == ["record[0]", "record[1]", "trial.force"]
    np.testing.assert_array_equal(found.channels[1].values, V)


def test_hdf5_groups_and_units(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file["run/force"], file["run/time"], file["other"], file["word"] = V, T, V[:20], "x"
        file["run/force"].attrs["units"], file["run/time"].attrs["units"] = "N", "s"
        file["outside"] = h5py.ExternalLink("b.h5", "x")
    found = read_recorded(tmp_path / "a.h5")
    assert [(each.name, each.unit) for each in found.channels] == [("run/force", "N"), ("run/time", "s")]
    assert found.time == "run/time"
    np.testing.assert_array_equal(found.channels[0].values, V)
    assert found.attributes["omitted"] == "other (20)"


@pytest.mark.parametrize("engine", ["h5netcdf", "scipy"])
def test_netcdf(tmp_path, engine):
    measured = xarray.Dataset(
        {"voltage": ("time", V, {"units": "mV"})}, {"time": ("time", T, {"units": "s"})}
    )
    measured.to_netcdf(tmp_path / "a.nc", engine=engine)
    found = read_recorded(tmp_path / "a.nc")
    assert {each.name: each.unit for each in found.channels} == {"voltage": "mV", "time": "s"}
    np.testing.assert_array_equal(found.times(), T)


def test_a_file_that_declares_too_much_is_refused(tmp_path):
    with h5py.File(tmp_path / "a.h5", "w") as file:
        file.create_dataset("big", (30_000_000,), "f8", compression="gzip", fillvalue=1.0)[:10] = 1
    with pytest.raises(DataFileError, match="packed too tightly"):
        read_recorded(tmp_path / "a.h5")


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


def test_the_list_of_readers_names_all_of_them():
    lines = format_lines()
    assert [line.split()[0] for line in lines[:-1]] == [each.name for each in FORMATS]
    assert sum("; needs " in line for line in lines) == len(HEADS)


def test_the_documentation_has_the_table_of_readers():
    page = Path(__file__).parents[3] / "docs" / "importing.md"
    assert format_table() in page.read_text(encoding="utf-8")


G = np.geomspace(1e5, 10, 20)
Z = 100 + 5e4 / (1 + 2j * np.pi * G * 5e4 * 1e-9)
PHASE = np.degrees(np.angle(Z))


def rows(form, *columns):
    return "".join(form.format(*row) for row in zip(*columns, strict=True))


ANALYSERS = {
    "gamry": "EXPLAIN\nTAG\tEISPOT\nTITLE\tLABEL\tx\tTest\nZCURVE\tTABLE\n\tPt\tTime\tFreq\tZreal\tZimag\tZsig\tZmod\tZphz\n"
    "\t#\ts\tHz\tohm\tohm\tV\tohm\t°\n"
    + rows("\t{:.0f}\t{:.6g}\t{:.9E}\t{:.9E}\t{:.9E}\t1\t{:.9E}\t{:.9E}\n", G * 0, T[:20], G, Z.real, Z.imag, abs(Z), PHASE),
    "biologic": "EC-Lab ASCII FILE\nNb header lines : 4\n\nfreq/Hz\tRe(Z)/Ohm\t-Im(Z)/Ohm\t|Z|/Ohm\tPhase(Z)/deg\n"
    + rows("{:.9E}\t{:.9E}\t{:.9E}\t{:.9E}\t{:.9E}\n", G, Z.real, -Z.imag, abs(Z), PHASE),
    "chinstruments": "Nov. 1, 2019   10:00:00\nA.C. Impedance\nInit E (V) = 0\n\nFreq/Hz, Z'/ohm, Z\"/ohm, Z/ohm, Phase/deg\n\n"
    + rows("{:.9e}, {:.9e}, {:.9e}, {:.9e}, {:.9e}\n", G, Z.real, Z.imag, abs(Z), PHASE),
}  # fmt: skip


@pytest.mark.parametrize("name", ANALYSERS)
def test_tables_of_impedance_analysers_are_read_without_a_package(tmp_path, name, monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda _: None)
    (tmp_path / "a.txt").write_text(ANALYSERS[name], encoding="utf-8")
    assert format_of(tmp_path / "a.txt").name == "text"
    found = spectrum_of(read_recorded(tmp_path / "a.txt"))
    np.testing.assert_allclose(found.frequency, G[::-1], rtol=1e-8)
    np.testing.assert_allclose(found.impedance, Z[::-1], rtol=1e-7)


def needs(module):
    return pytest.mark.skipif(
        importlib.util.find_spec(module) is None, reason=f"needs {module}: pip install 'electrovib[formats]'"
    )


@needs("impedance")
@pytest.mark.parametrize("name", [*ANALYSERS, "zplot"])
def test_impedance_analysers_by_their_package(tmp_path, name):
    zplot = "ZPLOT2 ASCII\n  Freq(Hz)\tAmpl\tBias\tTime(Sec)\tZ'(a)\tZ''(b)\nEnd Comments\n" + rows(
        "{:.9E}\t0\t0\t0\t{:.9E}\t{:.9E}\n", G, Z.real, Z.imag
    )
    (tmp_path / "a.txt").write_text(ANALYSERS.get(name, zplot), encoding="latin-1")
    found = spectrum_of(read_impedance_file(tmp_path / "a.txt"))
    np.testing.assert_allclose(found.impedance, Z[::-1], rtol=1e-7)


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
    assert found.attributes["omitted"] == "g/few (9)"


@needs("openpyxl")
def test_spreadsheets(tmp_path):
    import openpyxl

    book = openpyxl.Workbook()
    book.active.append(["no numbers on this sheet"])
    sheet = book.create_sheet("second")
    for row in (["a title"], ["time [ms]", "force [N]"], *zip(1e3 * T, V, strict=True)):
        sheet.append(list(row))
    book.save(tmp_path / "a.xlsx")
    found = read_recorded(tmp_path / "a.xlsx")
    assert (found.time, found.attributes["sheet"]) == ("time", "second")
    np.testing.assert_allclose(found.channels[1].values, V, rtol=1e-15)


def test_a_spreadsheet_that_unpacks_to_too_much_is_refused_before_it_is_unpacked(tmp_path, monkeypatch):
    monkeypatch.setattr("electrovib.data.readers.spreadsheet.check_package", lambda *_: None)
    with zipfile.ZipFile(tmp_path / "a.xlsx", "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("[Content_Types].xml", "x")
        archive.writestr("xl/worksheets/sheet1.xml", bytes(40_000_000))
    with pytest.raises(DataFileError, match="would unpack to 40 MB"):
        read_recorded(tmp_path / "a.xlsx")


@needs("RigolWFM")
def test_a_waveform_of_lecroy(tmp_path):
    counts = np.array([-3, 0, 5, 7, 100, -128, 4, 2], np.int8)
    (tmp_path / "a.trc").write_bytes(lecroy(counts))
    found = read_recorded(tmp_path / "a.trc")
    np.testing.assert_allclose(found.channels[0].values, 0.5 * counts - 2.0, rtol=1e-6)
    np.testing.assert_allclose(found.times(), -1e-3 + 1e-6 * np.arange(8), atol=1e-9)


@needs("RigolWFM")
@pytest.mark.parametrize("order", "<>")
@pytest.mark.parametrize("version", [2, 3])
def test_a_waveform_of_tektronix(tmp_path, version, order):
    counts = np.array([-3, 0, 5, 7, 1000, -12800, 4, 2])
    (tmp_path / "a.wfm").write_bytes(tektronix_wfm(counts, version=version, order=order))
    found = read_recorded(tmp_path / "a.wfm")
    assert [(each.name, each.unit) for each in found.channels] == [("CH 1", "V")]
    np.testing.assert_allclose(found.channels[0].values, 2e-3 * counts + 0.25, rtol=1e-6)
    np.testing.assert_allclose(found.times(), -1e-3 + 4e-6 * np.arange(8), atol=1e-12)
    assert "omitted" not in found.attributes


@needs("RigolWFM")
def test_a_waveform_of_tektronix_states_its_unit_its_frames_and_its_envelope(tmp_path):
    (tmp_path / "a.wfm").write_bytes(tektronix_wfm([1, 2, 3], unit=b"A", frames=3))
    found = read_recorded(tmp_path / "a.wfm")
    assert found.channels[0].unit == "A"
    assert found.channels[0].values.size == 3
    assert found.attributes["omitted"] == "frames 2 to 3 of 3"
    (tmp_path / "a.wfm").write_bytes(tektronix_wfm([1, 2, 3], storage=1))
    with pytest.raises(DataFileError, match="envelope"):
        read_recorded(tmp_path / "a.wfm")
    (tmp_path / "a.wfm").write_bytes(tektronix_wfm([1, 2, 3])[:400])
    with pytest.raises(DataFileError, match="Tektronix"):
        read_recorded(tmp_path / "a.wfm")


def lecroy(counts):
    """Write the descriptor of a waveform after the public template LECROY_2_3."""
    block = bytearray(346)
    block[0:8] = b"WAVEDESC"
    block[16:26] = b"LECROY_2_3"
    block[76:88] = b"LECROYtest\0\0"
    for place, form, value in [
        (32, "<h", 0), (34, "<h", 1), (36, "<i", 346), (60, "<i", counts.size), (116, "<i", counts.size),
        (124, "<i", 0), (128, "<i", counts.size - 1), (144, "<i", 1), (156, "<f", 0.5), (160, "<f", 2.0),
        (176, "<f", 1e-6), (180, "<d", -1e-3),
    ]:  # fmt: skip
        struct.pack_into(form, block, place, value)
    block[196:197], block[244:245] = b"V", b"S"
    return bytes(block) + counts.tobytes()


def test_a_package_that_is_there_is_not_asked_for(tmp_path):
    check_package(tmp_path, "numpy", "a table")
