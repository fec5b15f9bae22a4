"""A store that is not as it was written: what its checksums find, and when."""

from __future__ import annotations

import json
import os
import pickle
import shutil

import numpy as np
import pytest
import zarr
from stand_in_population import StandInPopulation

from electrovib.core.errors import DataFileError, InputError
from electrovib.study.population import StudyCancelledError, open_study
from electrovib.study.population.files import read_group, refuse_irregular, write_group

NAME = "electrostatic_force"


def flipped(path, at=100):
    """Change one bit of a file."""
    raw = bytearray(path.read_bytes())
    raw[at] ^= 4
    path.write_bytes(raw)


def content(folder):
    return {each.relative_to(folder): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


@pytest.fixture
def whole(quick, tiles, tmp_path):
    tiles(1024)  # the last bits of sums depend on the tiles
    quick(n=2100, draws=True, output=tmp_path / "a.zarr")
    return tmp_path / "a.zarr"


@pytest.fixture
def begun(quick, tiles, tmp_path):
    """A study that was ended in its second block."""
    tiles(256)
    with pytest.raises(StudyCancelledError):
        quick(n=1500, output=tmp_path / "b.zarr", progress=lambda done, _: done >= 1280)
    return tmp_path / "b.zarr"


def test_signals_that_are_damaged_are_refused_where_they_are_read(whole):
    """Opening reads no signal; the checksum of a chunk is found to be wrong when it is used."""
    flipped(whole / NAME / "c" / "1" / "0")
    found = open_study(whole)
    assert found[NAME][:1024].values.shape == (1024, 7)
    with pytest.raises(DataFileError, match=rf"{NAME}: is damaged: its checksum is not that of its content"):
        found[NAME].values  # noqa: B018


def test_signals_are_read_when_they_are_used(whole, quick):
    found, expected = open_study(whole), quick(n=2100, draws=True)
    assert not found[NAME].variable._in_memory
    np.testing.assert_array_equal(found[NAME][1000:1100:3, ::2], expected[NAME][1000:1100:3, ::2])
    assert pickle.loads(pickle.dumps(found)).identical(expected)
    assert found.identical(expected)
    assert list(found.variables) == list(expected.variables)
    assert set(found.attrs) == set(expected.attrs)


@pytest.mark.parametrize("place", [f"{NAME}/c/0/0", f"{NAME}_mean/c/0", f"{NAME}/zarr.json", "time/c/0"])
@pytest.mark.parametrize("how", ["missing", "longer"])
def test_a_file_that_is_missing_or_longer_is_named(whole, place, how):
    path = whole / place
    if how == "missing":
        path.unlink()
    else:
        path.write_bytes(path.read_bytes() + b" ")
    words = r"is missing\. Restore it" if how == "missing" else r"is damaged: it has \d+ instead of \d+ bytes"
    with pytest.raises(DataFileError, match=f"{place}: {words}"):
        open_study(whole)


def test_blocks_of_signals_that_are_exchanged_are_found(whole):
    """Each is whole, and ends with its own checksum."""
    one, other = (whole / NAME / "c" / place / "0" for place in "01")
    raw = one.read_bytes(), other.read_bytes()
    one.write_bytes(raw[1]), other.write_bytes(raw[0])
    with pytest.raises(DataFileError, match="its checksum is not that of its content"):
        open_study(whole)


@pytest.mark.parametrize("name", [NAME, f"{NAME}_mean"])
def test_values_that_another_program_wrote_are_found(whole, name):
    zarr.open_array(str(whole / name), mode="r+")[0] = np.nan
    with pytest.raises(DataFileError, match="is damaged"):
        open_study(whole)


def test_an_attribute_that_was_changed_is_found(whole, quick):
    path = whole / "zarr.json"
    path.write_text(path.read_text().replace('"fingers": 2100', '"fingers": 2101'))
    for door in (open_study, lambda path: quick(n=2100, draws=True, output=path)):
        with pytest.raises(
            DataFileError, match=r"zarr\.json: is damaged, of an earlier version, or no study of electrovib"
        ):
            door(whole)


def test_the_store_of_an_earlier_version_is_refused(whole):
    attributes = read_group(whole)
    write_group(whole, attributes | {"format": "electrovib study 2"})
    with pytest.raises(DataFileError, match="no study of electrovib, or one of another version"):
        open_study(whole)


def test_a_description_without_end_is_not_read(whole, monkeypatch):
    os.truncate(whole / "zarr.json", 10**12)
    monkeypatch.setattr("electrovib.study.population.files.is_ours", None)
    with pytest.raises(DataFileError, match="is damaged"):
        open_study(whole)


def test_a_folder_that_another_process_removes_meanwhile_is_no_damage(begun, monkeypatch):
    """A second command may look at a store while the first one replaces its sums."""
    original = os.scandir

    def scandir(folder):
        if str(folder).endswith("checkpoint"):
            raise FileNotFoundError
        return original(folder)

    monkeypatch.setattr("electrovib.study.population.files.os.scandir", scandir)
    refuse_irregular(begun)


@pytest.mark.parametrize("place", [f"{NAME}/c/0/0", f"{NAME}/zarr.json", "sums"])
def test_a_damaged_study_is_not_continued_and_stays_as_it_is(begun, quick, place):
    flipped(begun / "checkpoint" / place, at=40)
    (begun / "x.partial").write_text("left by a kill")
    before = content(begun)
    with pytest.raises(DataFileError, match=r"is damaged.*remove the folder of the study"):
        quick(n=1500, output=begun)
    assert content(begun) == before


def test_a_chunk_that_is_missing_is_not_continued_as_zeros(begun, quick):
    (begun / "checkpoint" / NAME / "c" / "0" / "0").unlink()
    with pytest.raises(DataFileError, match=r"c/0/0: is missing"):
        quick(n=1500, output=begun)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="links of POSIX")
def test_a_lock_that_is_a_link_leaves_the_other_file_as_it_is(begun, quick):
    mine = begun.with_name("mine.txt")
    mine.write_text("mine")
    (begun / ".lock").symlink_to(mine)
    with pytest.raises(DataFileError, match="is a link"):
        quick(n=1500, output=begun)
    assert mine.read_text() == "mine"


def test_the_progress_of_another_study_is_not_continued(begun, quick, tmp_path):
    other = tmp_path / "other.zarr"
    with pytest.raises(StudyCancelledError):
        quick(n=1600, output=other, progress=lambda done, _: done >= 1280)
    shutil.rmtree(other / "checkpoint")
    shutil.copytree(begun / "checkpoint", other / "checkpoint")
    with pytest.raises(DataFileError, match=r"zarr\.json: is damaged: it has|its checksum is not"):
        quick(n=1600, output=other)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and links of POSIX")
@pytest.mark.parametrize("name", [".lock", "note", "checkpoint/sums", f"{NAME}/c/more", "x.partial"])
@pytest.mark.parametrize("kind", ["pipe", "link"])
def test_pipes_and_links_are_not_opened(whole, quick, name, kind, monkeypatch):
    mine = whole.with_name("mine.txt")
    mine.write_text("mine")
    (whole / name).parent.mkdir(exist_ok=True)
    os.mkfifo(whole / name) if kind == "pipe" else (whole / name).symlink_to(mine)
    monkeypatch.setattr(StandInPopulation, "signals", None)
    for door in (open_study, lambda path: quick(n=2100, draws=True, output=path)):
        with pytest.raises(DataFileError, match=r"(a link|not an ordinary file), which no study writes"):
            door(whole)
    assert mine.read_text() == "mine"
    assert os.path.lexists(whole / name)


def test_a_description_that_is_a_link_is_not_followed(whole):
    (whole / "zarr.json").rename(whole.with_name("elsewhere"))
    (whole / "zarr.json").symlink_to(whole.with_name("elsewhere"))
    with pytest.raises(InputError, match="is a link"):
        open_study(whole)


def test_every_program_can_read_a_store(whole):
    """The checksums are attributes and a codec of the format."""
    group = zarr.open_group(str(whole), mode="r")
    assert group[NAME].metadata.to_dict()["codecs"][-1]["name"] == "crc32c"
    assert np.isfinite(group[NAME][:]).all()
    table = json.loads((whole / "zarr.json").read_text())
    assert set(table) == {"zarr_format", "node_type", "attributes"}
