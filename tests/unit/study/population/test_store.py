"""The store of a study: what it refuses, what it survives, and what it leaves."""

from __future__ import annotations

import errno

import numpy as np
import pytest
from stand_in_population import StandInPopulation
from zarr.storage import LocalStore

from electrovib.core.errors import InputError
from electrovib.data import atomic
from electrovib.data.lock import HeldError, held
from electrovib.study.population import StudyCancelledError, open_study


def content(folder):
    return {each.relative_to(folder): each.read_bytes() for each in folder.rglob("*") if each.is_file()}


def ended(quick, path, after=1, **asked):
    """Begin a study and end it after some fingers."""
    with pytest.raises(StudyCancelledError):
        quick(**{"n": 5000} | asked, output=path, progress=lambda done, _: done >= after)
    return path


def test_a_complete_study_is_returned_without_being_computed(quick, tmp_path, monkeypatch):
    quick(n=100, output=tmp_path / "a.zarr")
    monkeypatch.setattr(StandInPopulation, "signals", None)
    assert quick(n=100, output=tmp_path / "a.zarr").attrs["fingers"] == 100


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"n": 101}, "n is 100 there and 101 here"),
        ({"seed": 4}, "seed is 3 there and 4 here"),
        ({"percentiles": [50]}, "percentiles is"),
        ({"draws": True}, "draws is false there and true here"),
        ({"exceed": "2 mN"}, "exceed is"),
        ({"signal": "lateral_force"}, "signal is"),
    ],
)
def test_another_study_is_refused_and_nothing_is_changed(quick, tmp_path, change, words):
    quick(n=100, output=tmp_path / "a.zarr")
    before = content(tmp_path)
    with pytest.raises(InputError, match=words):
        quick(**{"n": 100} | change, output=tmp_path / "a.zarr")
    assert content(tmp_path) == before


def test_another_scenario_or_space_is_refused_but_not_another_title(quick, tmp_path):
    from stand_in_population import PATH, SPACE

    from electrovib.scenario import load
    from electrovib.study.population import study

    quick(n=100, output=tmp_path / "a.zarr")
    scenario = load("vezzoli_2014/fig6")
    with pytest.raises(InputError, match="its scenario is not the same"):
        study(scenario.replace({"drive.high": "10 V"}), SPACE, n=100, seed=3, output=tmp_path / "a.zarr")
    with pytest.raises(InputError, match="its space is not the same"):
        study(scenario, {PATH: SPACE[PATH] | {"factor": 1.6}}, n=100, seed=3, output=tmp_path / "a.zarr")
    other = scenario.model_copy(update={"title": "another title"})
    source = {PATH: SPACE[PATH] | {"source": "a book"}}
    assert study(other, source, n=100, seed=3, output=tmp_path / "a.zarr").attrs["fingers"] == 100


@pytest.mark.parametrize("name", ["a.csv", "study", "a.nc"])
def test_a_name_that_is_not_of_a_store_is_refused(quick, tmp_path, name):
    with pytest.raises(InputError, match=r"ends in \.zarr"):
        quick(n=10, output=tmp_path / name)


def test_what_is_no_study_is_not_touched(quick, tmp_path):
    (tmp_path / "file.zarr").write_text("text")
    (tmp_path / "folder.zarr").mkdir()
    (tmp_path / "folder.zarr" / "mine.txt").write_text("text")
    (tmp_path / "other.zarr").mkdir()
    (tmp_path / "other.zarr" / "zarr.json").write_text('{"attributes": {}}')
    (tmp_path / "broken.zarr").mkdir()
    (tmp_path / "broken.zarr" / "zarr.json").write_text('{"attri')
    before = content(tmp_path)
    for name, words in (
        ("file", "is a file"),
        ("folder", "no study of electrovib"),
        ("other", "no study of electrovib"),
        ("broken", "is damaged"),
    ):
        with pytest.raises(InputError, match=words):
            quick(n=10, output=tmp_path / f"{name}.zarr")
        with pytest.raises(InputError, match="no study of electrovib"):
            open_study(tmp_path / f"{name}.zarr")
    assert content(tmp_path) == before


def test_an_incomplete_study_is_not_opened(quick, tmp_path):
    path = ended(quick, tmp_path / "a.zarr")
    with pytest.raises(InputError, match="is not complete; the command that began it continues it"):
        open_study(path)


def test_another_kernel_continues_with_the_same_numbers(quick, tmp_path, monkeypatch):
    expected = quick(n=5000)
    path = ended(quick, tmp_path / "a.zarr")
    monkeypatch.setattr(StandInPopulation, "kernel", "another stand-in")
    found = quick(n=5000, output=path)
    for name in expected.variables:
        np.testing.assert_allclose(found[name], expected[name], rtol=1e-12)


def test_another_method_is_refused_while_incomplete(quick, tmp_path, monkeypatch):
    path = ended(quick, tmp_path / "a.zarr")
    monkeypatch.setattr(StandInPopulation, "method", "another method")
    with pytest.raises(InputError, match=r"begun with method 'in closed form', here 'another method'"):
        quick(n=5000, output=path)
    monkeypatch.setattr(StandInPopulation, "method", "in closed form")
    quick(n=5000, output=path)
    monkeypatch.setattr(StandInPopulation, "method", "another method")
    quick(n=5000, output=path)  # complete


def test_another_version_is_refused_while_incomplete(quick, tmp_path, monkeypatch):
    path = ended(quick, tmp_path / "a.zarr")
    versions = {"electrovib": "0.1.0", "numpy": "1.0"}
    monkeypatch.setattr("electrovib.study.population.result.computing_versions", lambda: versions)
    with pytest.raises(InputError, match=r"begun with numpy '.*', here '1.0'"):
        quick(n=5000, output=path)


def test_another_memory_that_changes_the_percentiles_is_refused(quick, tmp_path):
    path = ended(quick, tmp_path / "a.zarr", budget_memory="1 GB")
    with pytest.raises(InputError, match="percentiles from 'exact"):
        quick(n=5000, output=path, budget_memory="120 kB")


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
def test_a_full_disk_at_any_write_loses_nothing(quick, tiles, tmp_path, monkeypatch, memory, draws):
    tiles(1024)
    monkeypatch.setattr("electrovib.study.population.run.PAUSE", 0.0)  # a checkpoint after every tile
    monkeypatch.setattr("electrovib.study.population.run._SHARE", 0.0)
    asked = {"n": 4500, "draws": draws, "budget_memory": memory}
    quick(**asked, output=tmp_path / "reference.zarr")
    reference, files = open_study(tmp_path / "reference.zarr"), set(content(tmp_path / "reference.zarr"))
    full = OSError(errno.ENOSPC, "No space left on device")
    at, path = 1, tmp_path / "full.zarr"
    while True:
        with monkeypatch.context() as patched:
            written = faulty(patched, at, full)
            said = ""
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
        found = open_study(path)
        for name in reference.variables:
            np.testing.assert_allclose(found[name], reference[name], rtol=1e-12, err_msg=str(written[at - 1]))
        for each in sorted(path.rglob("*"), reverse=True):
            each.rmdir() if each.is_dir() else each.unlink()
        path.rmdir()
        at += 1
    assert at > 15


def test_files_that_a_kill_left_are_removed(quick, tmp_path):
    path = ended(quick, tmp_path / "a.zarr")
    (path / "checkpoint" / "x.0123.partial").write_text("half")
    (path / "y.0123.partial").write_text("half")
    quick(n=5000, output=path)
    assert not list(path.rglob("*.partial"))
    assert not (path / "checkpoint").exists()
    (path / "checkpoint").mkdir()  # killed between the mark of completeness and the removal
    quick(n=5000, output=path)
    assert not (path / "checkpoint").exists()


def test_a_folder_that_a_kill_left_empty_is_used(quick, tmp_path):
    (tmp_path / "a.zarr").mkdir()
    (tmp_path / "a.zarr" / ".lock").write_text("")
    (tmp_path / "a.zarr" / "zarr.0123.partial").write_text("")
    assert quick(n=10, output=tmp_path / "a.zarr").attrs["fingers"] == 10
    assert not list((tmp_path / "a.zarr").glob("*.partial"))


def test_a_folder_that_cannot_be_made_is_an_error_before_anything_is_computed(quick, tmp_path, monkeypatch):
    monkeypatch.setattr(StandInPopulation, "signals", None)
    with pytest.raises(InputError, match="cannot be written: No such file or directory"):
        quick(n=10, output=tmp_path / "missing" / "a.zarr")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot be written: Not a directory"):
        quick(n=10, output=tmp_path / "file" / "a.zarr")


def test_a_study_that_is_refused_at_once_leaves_no_folder(quick, tmp_path, monkeypatch):
    monkeypatch.setattr("shutil.disk_usage", lambda _: type("Usage", (), {"free": 1000})())
    with pytest.raises(InputError, match="omit --records"):
        quick(n=5000, draws=True, output=tmp_path / "a.zarr")
    assert not list(tmp_path.iterdir())


def test_draws_beyond_the_memory_need_a_store(quick):
    with pytest.raises(InputError, match="give an output"):
        quick(n=9000, draws=True, budget_memory="200 kB")


def test_a_block_beyond_the_memory_is_refused(quick):
    with pytest.raises(InputError, match=r"ask for fewer time\.samples"):
        quick(n=9000, budget_memory="100 kB")


def test_a_store_that_is_being_written_is_refused(quick, tmp_path):
    path = ended(quick, tmp_path / "a.zarr")
    with (
        held(path / ".lock"),
        pytest.raises(InputError, match=r"another process \(process \d+ on .*\) is writing"),
    ):
        quick(n=5000, output=path)
    assert quick(n=5000, output=path).attrs["fingers"] == 5000
    assert not list(path.glob(".lock*"))


def test_a_store_is_locked_until_its_study_has_ended(quick, tmp_path):
    """However it ends: complete, ended by its caller, or refused."""
    path, seen = tmp_path / "a.zarr", []

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


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        ({"n": 10**12}, "for 1e.12 fingers; allowed are 10 min and 4 GB. Draw fewer fingers"),
        ({"n": 10**12, "draws": True}, "for 1e.12 fingers; allowed are 10 min"),
        ({"workers": 10**5}, "25 TB, for 100000 workers; allowed are 10 min and 4 GB. Start fewer workers"),
        ({"budget_memory": 1}, "the signals of a block"),
        ({"scheduler": "tcp://127.0.0.1:9"}, "no answer"),
        ({"seed": -1}, "seed = -1: expected a whole number"),
    ],
)
def test_a_refused_study_leaves_nothing(quick, tmp_path, monkeypatch, asked, words):
    monkeypatch.setattr("electrovib.study.population.tiles._CONNECT", 0.5)
    with pytest.raises(InputError, match=words):
        quick(**{"n": 100} | asked, output=tmp_path / "a.zarr")
    assert not [*tmp_path.iterdir()]


def test_a_refused_study_leaves_what_is_not_its_own(quick, tmp_path, monkeypatch):
    """An empty folder of the user stays, and so do the fingers of an earlier call."""
    monkeypatch.setattr("electrovib.study.population.tiles._CONNECT", 0.5)
    (tmp_path / "empty.zarr").mkdir()
    begun = ended(quick, tmp_path / "begun.zarr", n=100)
    before = content(begun)
    for path in (tmp_path / "empty.zarr", begun):
        with pytest.raises(InputError, match="no answer"):
            quick(n=100, output=path, scheduler="tcp://127.0.0.1:9")
    assert content(begun) == before
    assert not [*(tmp_path / "empty.zarr").iterdir()]
