"""Textures and paths as a user gives them, and a sentence for each mistake."""

import numpy as np
import pytest
from PIL import Image

from electrovib.core.errors import InputError
from electrovib.physics.texture.profile import GreyscalePicture
from electrovib.studies.texture.reading import read_path, read_texture

INLINE = '{ model = "Grating", period = "2 mm", amplitude = "1 mN" }'
GRATING = read_texture(INLINE)
PICTURE = {"model": "GreyscalePicture", "width": 3, "value_samples": [0] * 12, "pixels_per_millimetre": 1}


def test_a_texture_is_read_from_text_a_file_a_table_itself_or_with_its_picture(tmp_path):
    file, pictured = tmp_path / "grating.toml", tmp_path / "t.toml"
    file.write_text(f"texture = {INLINE}\n", encoding="utf-8")
    table = {"model": "Grating", "period": 2e-3, "amplitude": "1 mN"}
    assert [read_texture(each) for each in (file, str(file), table, GRATING)] == [GRATING] * 4
    assert (GRATING.period, GRATING.amplitude) == (2e-3, 1e-3)
    Image.fromarray(np.arange(12, dtype=np.uint8).reshape(4, 3)).save(tmp_path / "grey.png")
    text = 'model = "GreyscalePicture"\nfile = "grey.png"\npixels_per_millimetre = 2\n'
    pictured.write_text(text, encoding="utf-8")
    found = read_texture(pictured)
    assert (type(found), found.width) == (GreyscalePicture, 3)
    np.testing.assert_array_equal(found.value_samples.values, np.arange(12))


def test_a_speed_is_one_stroke_over_the_texture_along_its_middle_and_a_table_is_read():
    found = read_path("30 mm/s", read_texture(PICTURE))
    assert (found.speed, found.stroke, found.across) == (0.03, 3e-3, 2e-3)
    assert read_path("3 cm/s", GRATING).stroke == 20e-3
    found = read_path('{ model = "ConstantSpeed", speed = "1 cm/s", stroke = "1 mm" }', GRATING)
    assert read_path({"model": "ConstantSpeed", "speed": 0.01, "stroke": 1e-3}, GRATING) == found
    assert read_path(found, GRATING) is found


HEADINGS = ["time [ms],x [mm],y [mm]\n0,0,1\n10,2,3", "time [ms],x [mm]\n0,0\n10,2"]
HEADINGS += ["time,position\n0,0\n0.01,0.002", "0,0\n0.01,0.002"]


@pytest.mark.parametrize("lines", HEADINGS)
def test_a_recorded_path_is_read_with_or_without_headings(lines, tmp_path):
    (tmp_path / "path.csv").write_text(lines, encoding="utf-8")
    found = read_path(tmp_path / "path.csv", read_texture(PICTURE))
    assert found.duration == pytest.approx(0.01)
    last = (2e-3, 3e-3 if "y" in lines else 2e-3)
    np.testing.assert_allclose(found.positions(np.array([0.01]))[0], last, rtol=1e-12)


UNSIZED = {"model": "GreyscalePicture", "width": 1, "value_samples": [0]}
MISSING = {"model": "GreyscalePicture", "file": "none.png", "pixels_per_millimetre": 1}
BAD = {"model": "HeightProfile", "file": "bad.csv"}
WRONG = {
    "no file": ("none.toml", "none.toml: No such file or directory. Give a TOML file or a table such as"),
    "not TOML": ("{ model = ", "texture: not valid TOML"),
    "no model": ({"period": 1}, r"texture = .*needs a name, for instance model = .*Grating"),
    "another model": ({"model": "Grate"}, "texture = .*Did you mean 'Grating'"),
    "a wrong value": (INLINE.replace("2 mm", "2 V"), "texture.period = '2 V': expected a length"),
    "two mistakes": ({"model": "Grating", "period": "2 V"}, "texture.amplitude: missing"),
    "no picture": ({**PICTURE, "file": "none.png", "value_samples": []}, "holds no pixels"),
    "a missing picture": (MISSING, "none.png: there is no such file"),
    "no resolution": (UNSIZED, "texture.pixels_per_millimetre: missing"),
    "a bad file": (BAD, "bad.csv: line 3, column 'height'"),
    "another column": (BAD | {"height_column": "hight"}, "no column 'hight'. Did you mean 'height'"),
    "not text": ("binary.toml", "not a text in UTF-8"),
}


@pytest.mark.parametrize("case", WRONG)
def test_a_wrong_texture_is_refused_in_a_sentence(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "bad.csv").write_text("position,height\n0,1\n1,here\n", encoding="utf-8")
    (tmp_path / "binary.toml").write_bytes(b"\xff\xfe\x00")
    source, words = WRONG[case]
    with pytest.raises(InputError, match=words):
        read_texture(source)


WRONG_PATHS = {
    "another column": ("time,z\n0,1\n1,2\n", "there is no column 'x' or 'position'"),
    "not numbers": ("time,x\n0,1\n1,here\n", "path.csv: line 3, column 'x'"),
    "back in time": ("time,x\n0,1\n0,2\n", "path.csv: time must increase"),
    "another unit": ("time [s],x [V]\n0,1\n1,2\n", "is in 'V', but a length is needed"),
    "empty": ("", "path.csv: .*empty"),
}


@pytest.mark.parametrize("case", WRONG_PATHS)
def test_a_wrong_path_is_refused_in_a_sentence(case, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    lines, words = WRONG_PATHS[case]
    (tmp_path / "path.csv").write_text(lines, encoding="utf-8")
    with pytest.raises(InputError, match=words) as caught:
        read_path("path.csv", GRATING)
    assert len(caught.value.problems) == 1


@pytest.mark.parametrize("text", ["30 mm", "fast", "nan m/s", "30 s", "3O mm/s", "12:30"])
def test_what_is_neither_a_speed_nor_a_file_is_said_and_so_is_a_missing_file(text, tmp_path):
    """A length in the place of a speed is the most frequent mistake."""
    with pytest.raises(InputError) as caught:
        read_path(text, GRATING)
    (problem,) = caught.value.problems
    assert (problem.path, problem.value) == ("path", text)
    assert problem.reason.startswith("neither a speed nor a file")
    assert ("Did you mean '30 mm/s'?" in problem) == (text == "30 mm")
    assert "path.csv with the columns time and x" in problem
    for source in ("none.csv", tmp_path / "30 mm"):
        with pytest.raises(InputError, match="there is no such file"):
            read_path(source, GRATING)
