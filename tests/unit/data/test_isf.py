"""Tektronix internal format: long and short keys, single samples and envelopes, 1 and 2 bytes, both byte orders."""

import importlib.util
import itertools
from pathlib import Path

import numpy as np
import pytest

from electrovib.core.errors import DataFileError
from electrovib.data.readers.isf import read_isf

EXAMPLE = Path(__file__).parents[4] / "shared" / "data" / "oscilloscope" / "example.isf"
COUNTS = np.array([0, 1, -2, 100, -128, 127, 5, 6])
LONG = (
    ":WFMPRE:BYT_NR {width};BIT_NR {bits};ENCDG BIN;BN_FMT {form};BYT_OR {order};NR_PT {points};"
    'WFID "Ch1, DC coupling; 2.0E0 V/div";PT_FMT {kind};XINCR 4.0E-6;PT_OFF 2;XZERO -1.0E-3;XUNIT "s";YMULT 0.5;YZERO 10.0;'
    'YOFF 3.0;YUNIT "V";:CURVE #'
)
SHORT = (
    "BYT_N {width};BIT_N {bits};ENC BIN;BN_F {form};BYT_O {order};NR_P {points};PT_F {kind};XIN 4.0E-6;PT_O 2;"
    'XZE -1.0E-3;XUN "s";YMU 0.5;YZE 10.0;YOF 3.0;YUN "V";:CURV #'
)


def written(preamble=LONG, *, width=2, form="RI", order="MSB", kind="Y", points=None, counts=COUNTS):
    dtype = f"{'<' if order == 'LSB' else '>'}{'i' if form == 'RI' else 'u'}{width}"
    body = (counts + (128 if form == "RP" else 0)).astype(dtype).tobytes()
    text = preamble.format(
        width=width, bits=8 * width, form=form, order=order, points=points or counts.size, kind=kind
    )
    return text.encode() + f"{len(str(len(body)))}{len(body)}".encode() + body


@pytest.mark.parametrize(
    ("preamble", "width", "order", "form"),
    list(itertools.product([LONG, SHORT], [1, 2], ["MSB", "LSB"], ["RI", "RP"])),
)
def test_samples_and_times(tmp_path, preamble, width, order, form):
    (tmp_path / "a.isf").write_bytes(written(preamble, width=width, order=order, form=form))
    found = read_isf(tmp_path / "a.isf")
    shift = 128 if form == "RP" else 0
    np.testing.assert_allclose(found.channels[0].values, 10 + 0.5 * (COUNTS + shift - 3), rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.times(), -1e-3 + 4e-6 * (np.arange(8) - 2), rtol=0, atol=1e-15)
    assert found.channels[0].unit == "V"


def test_an_envelope_is_a_minimum_and_a_maximum(tmp_path):
    (tmp_path / "a.isf").write_bytes(written(kind="ENV"))
    found = read_isf(tmp_path / "a.isf")
    volts = 10 + 0.5 * (COUNTS - 3)
    assert [each.name for each in found.channels] == ["Ch1 minimum", "Ch1 maximum"]
    np.testing.assert_array_equal(found.channels[0].values, np.minimum(volts[::2], volts[1::2]))
    np.testing.assert_array_equal(found.channels[1].values, np.maximum(volts[::2], volts[1::2]))
    np.testing.assert_allclose(np.diff(found.times()), 8e-6)


def in_words(end=b"", points=8):
    text = LONG.replace("BIN;", "ASC;").removesuffix("#")
    head = text.format(width=2, bits=16, form="RI", order="MSB", points=points, kind="Y")
    return head.encode() + ",".join(map(str, COUNTS)).encode() + end


@pytest.mark.parametrize("end", [b"", b"\n", b"\r\n", b";\r\n"])
@pytest.mark.parametrize("form", ["block", "without length", "words"])
def test_a_curve_in_words_or_in_a_block_without_length_and_its_terminator(tmp_path, form, end):
    """Before, a curve in ASCII and a block that begins with #0 were refused."""
    content = in_words() if form == "words" else written()
    content = content.replace(b"#216", b"#0") if form == "without length" else content
    (tmp_path / "a.isf").write_bytes(content + end)
    found = read_isf(tmp_path / "a.isf")
    np.testing.assert_array_equal(found.channels[0].values, 10 + 0.5 * (COUNTS - 3))
    assert not found.not_read
    (tmp_path / "a.isf").write_bytes(content + b";" + in_words())
    found = read_isf(tmp_path / "a.isf")
    np.testing.assert_array_equal(found.channels[0].values, 10 + 0.5 * (COUNTS - 3))
    assert [each.name.partition(" ")[2] for each in found.not_read] == ["bytes behind the curve"]


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"time,volt\n0,1\n", "no 'CURVE #'"),
        (written()[:-3], "cut off"),
        (written(points=9), "states 9 points and holds 8"),
        (written(LONG.replace("YMULT 0.5;", "")), "no number for YMULT"),
        (written(LONG.replace("XINCR 4.0E-6", "XINCR nan")), "no number for XINCR"),
        (written(LONG.replace("BIN;", "ASC;")), "known are 1 or 2 bytes"),
        (written(kind="ENV", counts=COUNTS[:-1]), "odd number"),
        (written(counts=COUNTS[:1]), "no column of two or more"),
        (b":WFMPRE:BYT_NR 2;:CURVE #0", "unknown length"),
        (written().replace(b"#216", b"#0")[:-1], "states 16 bytes of samples and holds 15"),
        (in_words(points=9), "states 9 points and holds 8"),
        (in_words(b",x\n"), "not made of numbers"),
        (b":WFMPRE:BYT_NR 2;:CURVE #9999999999" + bytes(10), "cut off"),
    ],
)
def test_damage_is_one_sentence(tmp_path, content, words):
    (tmp_path / "a.isf").write_bytes(content)
    with pytest.raises(DataFileError, match=words):
        read_isf(tmp_path / "a.isf")


@pytest.mark.skipif(not EXAMPLE.exists(), reason="needs shared/data, which is not part of the repository")
def test_a_real_file_agrees_with_another_reader():
    ours = read_isf(EXAMPLE)
    assert ours.size == 10_000
    assert np.isfinite(ours.channels[0].values).all()
    if importlib.util.find_spec("RigolWFM") is not None:  # of electrovib[formats]
        from RigolWFM import wfm

        (theirs,) = wfm.Wfm.from_file(str(EXAMPLE)).channels
        np.testing.assert_allclose(ours.channels[0].values, theirs.volts, rtol=0, atol=1e-6)
        np.testing.assert_allclose(ours.times(), theirs.times, rtol=0, atol=1e-15)
