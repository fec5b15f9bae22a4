"""A store that is not as it was written: what its checksums find, and when."""

import json
import os
import pickle
import shutil
import warnings

import numpy as np
import pytest
import zarr
from stand_in_population import StandInPopulation

from electrovib.core.errors import DataFileError
from electrovib.studies.population import open_study
from electrovib.studies.population.files import read_group, refuse_irregular, write_group

NAME = "electrostatic_force"
posix = pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="pipes and links of POSIX")


def flipped(path, at=100):
    """Change one bit of a file."""
    raw = bytearray(path.read_bytes())
    raw[at] ^= 4
    path.write_bytes(raw)


@pytest.fixture
def whole(quick, tiles, tmp_path):
    tiles(1024)  # the last bits of sums depend on the tiles
    quick(n=2100, records=True, output=tmp_path / "a.zarr")
    return tmp_path / "a.zarr"


@pytest.fixture
def begun(ended, tiles, tmp_path):
    """A study that was ended in its second block."""
    tiles(256)
    return ended(tmp_path / "b.zarr", after=1280, n=1500)


@pytest.fixture
def doors(quick):
    """Both functions that read a complete store."""
    return (open_study, lambda path: quick(n=2100, records=True, output=path))


def test_signals_are_read_when_they_are_used_and_refused_where_they_are_damaged(whole, quick):
    found, expected = open_study(whole), quick(n=2100, records=True)
    assert not found[NAME].variable._in_memory
    np.testing.assert_array_equal(found[NAME][1000:1100:3, ::2], expected[NAME][1000:1100:3, ::2])
    assert pickle.loads(pickle.dumps(found)).identical(expected)
    assert found.identical(expected)
    assert list(found.variables) == list(expected.variables)
    assert set(found.attrs) == set(expected.attrs)
    flipped(whole / NAME / "c" / "1" / "0")
    found = open_study(whole)
    assert found[NAME][:1024].values.shape == (1024, 7)
    with pytest.raises(DataFileError, match=rf"{NAME}: is damaged: its checksum is not that of its content"):
        found[NAME].values  # noqa: B018


@pytest.mark.parametrize("place", [f"{NAME}/c/0/0", f"{NAME}_mean/c/0", f"{NAME}/zarr.json", "time/c/0"])
def test_a_file_that_is_missing_or_longer_is_named(whole, place):
    path = whole / place
    path.write_bytes(path.read_bytes() + b" ")
    with pytest.raises(DataFileError, match=rf"{place}: is damaged: it has \d+ instead of \d+ bytes"):
        open_study(whole)
    path.unlink()
    with pytest.raises(DataFileError, match=rf"{place}: is missing\. Restore it"):
        open_study(whole)


def exchange_blocks(whole):
    """Each is whole, and ends with its own checksum."""
    one, other = (whole / NAME / "c" / place / "0" for place in "01")
    raw = one.read_bytes(), other.read_bytes()
    one.write_bytes(raw[1]), other.write_bytes(raw[0])


def overwrite(name):
    return lambda whole: zarr.open_array(str(whole / name), mode="r+").__setitem__(0, np.nan)


def change_an_attribute(whole):
    text = (whole / "zarr.json").read_text()
    (whole / "zarr.json").write_text(text.replace('"fingers": 2100', '"fingers": 2101'))


CHANGED = {
    "blocks exchanged": (exchange_blocks, "its checksum is not that of its content"),
    "signals of another program": (overwrite(NAME), "is damaged"),
    "sums of another program": (overwrite(f"{NAME}_mean"), "is damaged"),
    "attribute": (change_an_attribute, r"zarr\.json: is damaged, of an earlier version, or no study of"),
    "earlier version": (
        lambda whole: write_group(whole, read_group(whole) | {"format": "electrovib study 2"}),
        "no study of electrovib, or one of another version",
    ),
}


@pytest.mark.parametrize("case", CHANGED)
def test_what_was_changed_is_found(whole, doors, case):
    change, words = CHANGED[case]
    change(whole)
    for door in doors:
        with pytest.raises(DataFileError, match=words):
            door(whole)


def test_every_program_can_read_a_store_and_a_description_without_end_is_not_read(whole, monkeypatch):
    """The checksums are attributes and a codec of the format."""
    group = zarr.open_group(str(whole), mode="r")
    assert group[NAME].metadata.to_dict()["codecs"][-1]["name"] == "crc32c"
    assert np.isfinite(group[NAME][:]).all()
    table = json.loads((whole / "zarr.json").read_text())
    assert set(table) == {"zarr_format", "node_type", "attributes"}
    os.truncate(whole / "zarr.json", 10**12)
    monkeypatch.setattr("electrovib.studies.population.files.is_ours", None)
    with pytest.raises(DataFileError, match="is damaged"):
        open_study(whole)


def test_a_folder_that_another_process_removes_meanwhile_is_no_damage(begun, monkeypatch):
    """A second command may look at a store while the first one replaces its sums."""
    original = os.scandir

    def scandir(folder):
        if str(folder).endswith("checkpoint"):
            raise FileNotFoundError
        return original(folder)

    monkeypatch.setattr("electrovib.studies.population.files.os.scandir", scandir)
    refuse_irregular(begun)


@pytest.mark.parametrize("place", [f"{NAME}/c/0/0", f"{NAME}/zarr.json", "sums"])
def test_a_damaged_study_is_not_continued_and_stays_as_it_is(begun, quick, content, place):
    flipped(begun / "checkpoint" / place, at=40)
    (begun / "x.partial").write_text("left by a kill")
    before = content(begun)
    with pytest.raises(DataFileError, match=r"is damaged.*remove the folder of the study"):
        quick(n=1500, output=begun)
    assert content(begun) == before


def test_a_missing_chunk_and_the_progress_of_another_study_are_not_continued(begun, ended, quick, tmp_path):
    other = ended(tmp_path / "other.zarr", after=1280, n=1600)
    shutil.rmtree(other / "checkpoint")
    shutil.copytree(begun / "checkpoint", other / "checkpoint")
    with pytest.raises(DataFileError, match=r"zarr\.json: is damaged: it has|its checksum is not"):
        quick(n=1600, output=other)
    (begun / "checkpoint" / NAME / "c" / "0" / "0").unlink()
    with pytest.raises(DataFileError, match=r"c/0/0: is missing"):
        quick(n=1500, output=begun)


@posix
@pytest.mark.parametrize("name", [".lock", "note", "checkpoint/sums", f"{NAME}/c/more", "x.partial"])
@pytest.mark.parametrize("kind", ["pipe", "link"])
def test_pipes_and_links_are_not_opened(whole, doors, name, kind, monkeypatch):
    mine = whole.with_name("mine.txt")
    mine.write_text("mine")
    (whole / name).parent.mkdir(exist_ok=True)
    os.mkfifo(whole / name) if kind == "pipe" else (whole / name).symlink_to(mine)
    monkeypatch.setattr(StandInPopulation, "signals", None)
    for door in doors:
        with pytest.raises(DataFileError, match=r"(a link|not an ordinary file), which no study writes"):
            door(whole)
    assert mine.read_text() == "mine"
    assert os.path.lexists(whole / name)


@posix
def test_links_in_place_of_a_lock_or_a_description_are_not_followed(whole, begun, quick):
    mine = begun.with_name("mine.txt")
    mine.write_text("mine")
    (begun / ".lock").symlink_to(mine)
    with pytest.raises(DataFileError, match="is a link"):
        quick(n=1500, output=begun)
    assert mine.read_text() == "mine"
    (whole / "zarr.json").rename(whole.with_name("elsewhere"))
    (whole / "zarr.json").symlink_to(whole.with_name("elsewhere"))
    with pytest.raises(DataFileError, match="is a link"):
        open_study(whole)


def added(path, how):
    """Let another program work on a store, which warns that consolidated metadata is an extension."""
    warnings.simplefilter("ignore", zarr.errors.ZarrUserWarning)
    group = zarr.open_group(path, mode="r+")
    if how == "consolidated":
        zarr.consolidate_metadata(path)
    elif how == "attribute":
        group.update_attributes({"note": "of another program"})
    else:
        group.create_array("of_another", data=np.arange(3.0), dimension_names=["n"])
        zarr.consolidate_metadata(path)


@pytest.mark.parametrize("how", ["consolidated", "attribute", "variable"])
def test_what_another_program_adds_to_a_store_is_no_damage(whole, begun, quick, how):
    expected = open_study(whole).load()
    added(whole, how)
    assert open_study(whole).identical(expected)
    assert quick(n=2100, records=True, output=whole).identical(expected)
    added(begun, how)
    found = quick(n=1500, output=begun)
    np.testing.assert_array_equal(found[f"{NAME}_mean"], quick(n=1500)[f"{NAME}_mean"])
    assert open_study(begun).identical(found)
