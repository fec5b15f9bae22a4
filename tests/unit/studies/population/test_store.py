"""The store of a study: what it refuses, what it survives, and what it leaves."""

import errno
import shutil

import numpy as np
import pytest
from stand_in_population import PATH, SPACE, StandInPopulation
from zarr.storage import LocalStore

from electrovib.core.budget import budget
from electrovib.core.errors import InputError
from electrovib.data import atomic
from electrovib.data.atomic import HeldError, held
from electrovib.scenario import load
from electrovib.studies.population import StudyCancelledError, open_study, study
from electrovib.studies.population.result import computing_versions


@pytest.fixture
def path(tmp_path):
    return tmp_path / "a.zarr"


@pytest.fixture
def impatient(monkeypatch):
    """A scheduler is not awaited for long."""
    monkeypatch.setattr("electrovib.studies.population.tiles._CONNECT", 0.5)


def assert_same(found, expected, words=""):
    for name in expected.variables:
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-12, err_msg=words)


def test_a_complete_study_is_returned_without_being_computed_and_another_refused(
    quick, path, content, monkeypatch
):
    quick(n=100, output=path)
    before = content(path)
    monkeypatch.setattr(StandInPopulation, "signals", None)
    assert quick(n=100, output=path).attrs["fingers"] == 100
    for change, words in (
        ({"n": 101}, "n is 100 there and 101 here"),
        ({"seed": 4}, "seed is 3 there and 4 here"),
        ({"percentiles": [50]}, "percentiles is"),
        ({"records": True}, "records is false there and true here"),
        ({"exceed": "2 mN"}, "exceed is"),
        ({"quantity": "lateral_force"}, "quantity is"),
    ):
        with pytest.raises(InputError, match=words):
            quick(**{"n": 100} | change, output=path)
    scenario, asked = load("vezzoli_2014/fig6"), {"n": 100, "seed": 3, "output": path}
    for other, space, words in (
        (scenario.replace({"drive.high": "10 V"}), SPACE, "its scenario is not the same"),
        (scenario, {PATH: SPACE[PATH] | {"factor": 1.6}}, "its space is not the same"),
    ):
        with pytest.raises(InputError, match=words):
            study(other, space, **asked)
    titled, source = (
        scenario.model_copy(update={"title": "another"}),
        {PATH: SPACE[PATH] | {"source": "a book"}},
    )
    assert study(titled, source, **asked).attrs["fingers"] == 100
    assert content(path) == before


def test_what_is_no_study_or_no_place_for_one_is_not_touched(quick, tmp_path, content, monkeypatch):
    (tmp_path / "file.zarr").write_text("text")
    for name, file, text in (
        ("folder", "mine.txt", "text"),
        ("other", "zarr.json", '{"attributes": {}}'),
        ("broken", "zarr.json", '{"attri'),
    ):
        (tmp_path / f"{name}.zarr").mkdir()
        (tmp_path / f"{name}.zarr" / file).write_text(text)
    before = content(tmp_path)
    monkeypatch.setattr(StandInPopulation, "signals", None)
    for name, words in {
        "file.zarr": "is a file",
        "folder.zarr": "no study of electrovib",
        "other.zarr": "no study of electrovib",
        "broken.zarr": "is damaged",
        "a.csv": r"ends in \.zarr",
        "study": r"ends in \.zarr",
        "missing/a.zarr": "cannot be written: No such file or directory",
        "file.zarr/a.zarr": "cannot be written: Not a directory",
    }.items():
        with pytest.raises(InputError, match=words):
            quick(n=10, output=tmp_path / name)
    for name in ("file", "folder", "other", "broken"):
        with pytest.raises(InputError, match="no study of electrovib"):
            open_study(tmp_path / f"{name}.zarr")
    assert content(tmp_path) == before


def test_an_incomplete_study_is_not_opened_and_continued_by_another_kernel_alone(
    quick, ended, path, monkeypatch
):
    expected = quick(n=5000)
    ended(path, budget_memory="1 GB")
    with pytest.raises(InputError, match="is not complete; the command that began it continues it"):
        open_study(path)
    with pytest.raises(InputError, match="percentiles from 'exact"):
        quick(n=5000, output=path, budget_memory="120 kB")
    with monkeypatch.context() as patched:
        patched.setattr(StandInPopulation, "method", "another method")
        with pytest.raises(InputError, match=r"begun with method 'in closed form', here 'another method'"):
            quick(n=5000, output=path)
    with monkeypatch.context() as patched:
        versions = computing_versions() | {"numpy": "1.0"}
        patched.setattr("electrovib.studies.population.result.computing_versions", lambda: versions)
        with pytest.raises(InputError, match=r"begun with numpy '.*', here '1.0'"):
            quick(n=5000, output=path)
    monkeypatch.setattr(StandInPopulation, "kernel", "another stand-in")
    assert_same(quick(n=5000, output=path), expected)
    monkeypatch.setattr(StandInPopulation, "method", "another method")
    quick(n=5000, output=path)  # complete


def faulty(monkeypatch, at, error):
    """Let the write of number `at` to a store fail; return the list of what was written."""
    written, of_array, of_group = [], LocalStore.set, atomic._complete

    def note(key):
        written.append(key)
        if len(written) == at:
            raise error

    async def put(self, key, value):
        note(key)
        await of_array(self, key, value)

    def complete(temporary, place, form):
        note(place)
        of_group(temporary, place, form)

    monkeypatch.setattr(LocalStore, "set", put)
    monkeypatch.setattr(atomic, "_complete", complete)
    return written


@pytest.mark.slow
@pytest.mark.parametrize("draws", [True, False])
@pytest.mark.parametrize("memory", ["1 GB", "120 kB"])
def test_a_full_disk_at_any_write_loses_nothing(quick, tiles, content, tmp_path, monkeypatch, memory, draws):
    tiles(1024)
    monkeypatch.setattr("electrovib.studies.population.run.PAUSE", 0.0)  # a checkpoint after every tile
    monkeypatch.setattr("electrovib.studies.population.run._SHARE", 0.0)
    asked = {"n": 4500, "records": draws, "budget_memory": memory}
    quick(**asked, output=tmp_path / "reference.zarr")
    reference, files = open_study(tmp_path / "reference.zarr"), set(content(tmp_path / "reference.zarr"))
    full = OSError(errno.ENOSPC, "No space left on device")
    at, path = 1, tmp_path / "full.zarr"
    while True:
        said = ""
        with monkeypatch.context() as patched:
            written = faulty(patched, at, full)
            try:
                quick(**asked, output=path)
            except InputError as error:
                said = str(error)
            if len(written) < at:
                break
        assert "No space left on device" in said
        assert "What was stored before is kept" in said
        quick(**asked, output=path)
        assert set(content(path)) == files, f"write {at}: {written[at - 1]}"
        assert_same(open_study(path), reference, str(written[at - 1]))
        shutil.rmtree(path)
        at += 1
    assert at > 15


def test_files_and_folders_that_a_kill_left_are_removed_or_used(quick, ended, path, tmp_path):
    ended(path)
    (path / "checkpoint" / "x.0123.partial").write_text("half")
    (path / "y.0123.partial").write_text("half")
    quick(n=5000, output=path)
    assert not list(path.rglob("*.partial"))
    assert not (path / "checkpoint").exists()
    (path / "checkpoint").mkdir()  # killed between the mark of completeness and the removal
    quick(n=5000, output=path)
    assert not (path / "checkpoint").exists()
    empty = tmp_path / "empty.zarr"
    empty.mkdir()
    for name in (".lock", "zarr.0123.partial"):
        (empty / name).write_text("")
    assert quick(n=10, output=empty).attrs["fingers"] == 10
    assert not list(empty.glob("*.partial"))


def test_more_than_disk_or_memory_hold_is_refused_and_leaves_no_folder(quick, path, tmp_path, monkeypatch):
    for memory, asked, words in (
        ("200 kB", {"records": True}, "give an output"),
        ("100 kB", {}, r"ask for fewer time\.samples"),
    ):
        with pytest.raises(InputError, match=words):
            quick(n=9000, budget_memory=memory, **asked)
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("Usage", (), {"free": 1000})())
    with pytest.raises(InputError, match="omit --records"):
        quick(n=5000, records=True, output=path)
    assert not list(tmp_path.iterdir())


def test_percentiles_take_a_quarter_of_the_memory_allowed(quick):
    """Of 9000 fingers with seven samples, which take 252 kB."""
    for memory, way in (("1.1 MB", "exact"), ("0.9 MB", "histogram")):
        with budget(memory=memory):
            assert way in quick(n=9000).attrs["percentiles_from"]
    assert quick(n=10).attrs["percentiles_from"].startswith("exact")


def test_a_store_is_locked_until_its_study_has_ended_and_one_being_written_is_refused(quick, path):
    """However it ends: complete, ended by its caller, or refused."""
    seen = []

    def progress(done, _):
        with pytest.raises(HeldError), held(path / ".lock"):
            pass
        seen.append(done)
        return done >= 1

    with pytest.raises(StudyCancelledError):
        quick(n=5000, output=path, progress=progress)
    assert seen
    with held(path / ".lock") as left:
        assert left == ""
        with pytest.raises(InputError, match=r"another process \(process \d+ on .*\) is writing"):
            quick(n=5000, output=path)
    assert quick(n=5000, output=path).attrs["fingers"] == 5000
    assert not list(path.glob(".lock*"))


REFUSED = {
    "fingers": ({"n": 10**12}, "for 1e.12 fingers; allowed are 10 min and 4 GB. Draw fewer fingers"),
    "records": ({"n": 10**12, "records": True}, "for 1e.12 fingers; allowed are 10 min"),
    "many workers": ({"workers": 10**5}, "25 TB, for 100000 workers; allowed .* Start fewer workers"),
    "memory": ({"budget_memory": 1}, "the signals of a block"),
    "scheduler": ({"workers": "tcp://127.0.0.1:9"}, r"workers = tcp://127.0.0.1:9: no answer"),
    "no worker": ({"workers": 0}, "workers = 0: expected a number of processes"),
    "no number": ({"workers": True}, "workers = True"),
    "no address": (
        {"workers": "nowhere"},
        "workers = nowhere: expected a number of processes, 1 or more, or the address",
    ),
    "seed": ({"seed": -1}, "seed = -1: expected a whole number"),
}


@pytest.mark.parametrize("case", REFUSED)
@pytest.mark.usefixtures("impatient")
def test_a_refused_study_leaves_nothing(quick, path, tmp_path, case):
    asked, words = REFUSED[case]
    with pytest.raises(InputError, match=words):
        quick(**{"n": 100} | asked, output=path)
    assert not [*tmp_path.iterdir()]


@pytest.mark.usefixtures("impatient")
def test_a_refused_study_leaves_what_is_not_its_own(quick, ended, content, tmp_path):
    """An empty folder of the user stays, and so do the fingers of an earlier call."""
    (tmp_path / "empty.zarr").mkdir()
    begun = ended(tmp_path / "begun.zarr", n=100)
    before = content(begun)
    for path in (tmp_path / "empty.zarr", begun):
        with pytest.raises(InputError, match="no answer"):
            quick(n=100, output=path, workers="tcp://127.0.0.1:9")
    assert content(begun) == before
    assert not [*(tmp_path / "empty.zarr").iterdir()]
