"""Which reader takes a file."""

import struct

import numpy as np
import pytest
from scipy.io import wavfile

from electrovib.core.errors import DataFileError, NoColumnError
from electrovib.data import readers, registry
from electrovib.data.columns import read_columns
from electrovib.data.file_format import CanRead
from electrovib.data.registry import FORMATS, format_of, read_recorded


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


def test_a_file_is_known_by_its_content_not_by_its_name(tmp_path):
    (tmp_path / "a.dat").write_bytes(b":WFMPRE:BYT_NR 2;")
    assert format_of(tmp_path / "a.dat").name == "isf"
    (tmp_path / "b.isf").write_text("t,u\n0,1\n1,2\n", encoding="utf-8")
    answers = {each.name: each.can_read(b"t,u\n0,1", ".isf") for each in FORMATS}
    assert {name for name, answer in answers.items() if answer is CanRead.PERHAPS} == {"isf", "text"}
    assert CanRead.YES not in answers.values()


@pytest.mark.parametrize(
    ("content", "options", "words"),
    [
        (b"\x00\x01\x02" * 40, {}, "no format that is known. Known are .*; Tektronix"),
        (b"t,u\n0,1\n1,2\n", {"reader": "txt"}, "there is no reader 'txt'. Did you mean 'text'"),
        (b":WFMPRE:BYT_NR 2;", {"delimiter": ";"}, "delimiter does not belong to Tektronix"),
        (b"RIFF\x10\x00\x00\x00WAVEfmt ", {}, "damaged or not a sound file"),
    ],
)
def test_what_is_not_known_is_refused_with_what_is(tmp_path, content, options, words):
    (tmp_path / "a.raw").write_bytes(content)
    with pytest.raises(DataFileError, match=words):
        read_recorded(tmp_path / "a.raw", **options)


def test_options_of_text(tmp_path):
    (tmp_path / "a.csv").write_text("0;1,5\n1;2,5\n2;3,5\n", encoding="utf-8")
    found = read_recorded(tmp_path / "a.csv", delimiter=";", decimal_comma=True)
    np.testing.assert_array_equal(found.channels[1].values, [1.5, 2.5, 3.5])


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


def test_one_file_adds_a_reader(tmp_path, monkeypatch):
    """Every module of the folder is asked, and a new one needs no line elsewhere."""
    (tmp_path / "counts_of_a_lab.py").write_text(
        """
import numpy as np
from electrovib.data.file_format import FileFormat, begins
from electrovib.data.recorded import DataColumn, Recorded

def read(path):
    return Recorded(channels=(DataColumn(name="counts", unit="mV", values=np.array([1.0, 2.0, np.nan])),), step=1e-3)

FORMAT = FileFormat(name="lab", description="counts", suffixes=(".lab",), can_read=begins(b"LAB"), read=read)
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
    with pytest.raises(
        DataFileError, match=r"row 2 \(first is 0\), column 'counts': nan is not a finite number"
    ):
        read_columns(tmp_path / "a.bin", {"v": (0, "V")})
    with pytest.raises(NoColumnError, match=r"there is no column 'count'\. Did you mean 'counts'"):
        read_columns(tmp_path / "a.bin", {"v": ("count", "V")})


def test_columns_are_read_from_every_format(tmp_path):
    samples = (np.array([0.0, 0.5, -0.25]) * 2**15).astype("i2")
    wavfile.write(tmp_path / "a.wav", 8000, samples)
    found = read_columns(tmp_path / "a.wav", {"x": ("channel 1", "1")})["x"]
    np.testing.assert_array_equal(found, [0.0, 0.5, -0.25])
    with pytest.raises(DataFileError, match="column 'channel 1' is in '1', but a voltage is needed"):
        read_columns(tmp_path / "a.wav", {"x": (0, "V")})


def test_the_suffix_does_not_hide_the_content(tmp_path):
    (tmp_path / "a.mat").write_text("0 1\n77 -2.5\n156 300\n")  # as MATLAB saves with -ascii
    assert read_columns(tmp_path / "a.mat", {"v": (1, "V")})["v"].tolist() == [1.0, -2.5, 300.0]
    np.save(tmp_path / "b.npy", np.zeros((3, 2)))
    (tmp_path / "b.npy").rename(tmp_path / "b.csv")
    assert read_columns(tmp_path / "b.csv", {"v": (1, "V")})["v"].tolist() == [0.0, 0.0, 0.0]
    for suffix, words in {"npy": "a NumPy file", "nc": "a netCDF file", "wav": "a sound file"}.items():
        (tmp_path / f"c.{suffix}").write_bytes(b"time,voltage\n0,1\n" * 9)
        with pytest.raises(DataFileError, match=f"is damaged or not {words}"):
            read_recorded(tmp_path / f"c.{suffix}")
