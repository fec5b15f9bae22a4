"""The tree holds nothing of one machine, no index of packages, and no file too long to read."""

import re
import subprocess

import pytest
from source import ROOT, SOURCE, text_of

LONGEST = 500


def spelled(text):
    """Take the tildes out, with which this file keeps from finding itself."""
    return text.replace("~", "")


PLACES = re.compile(spelled(r"(?<![\w.>/])/(?:ho~me|Us~ers|ro~ot|wo~rk|mnt|sr~v)/|[A-Z]:\\+Us~ers"))
INDEXES = re.compile(
    spelled(r"py~pi\.(?:org|python)|py~thonhosted|test\.py~pi|ana~conda\.(?:org|com)|index[-_]~url")
)
GENERATED = {".git", ".venv", "build", "dist", "__pycache__", ".hypothesis"}


def tracked_files():
    """Files under version control and new ones that are not ignored; all files where git is absent."""
    command = ["git", "ls-files", "--cached", "--others", "--exclude-standard"]
    try:
        done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=60, check=True)
        found = [ROOT / line for line in done.stdout.splitlines()]
    except (OSError, subprocess.CalledProcessError):
        found = []
    if not found:
        found = [path for path in ROOT.rglob("*") if not GENERATED & set(path.relative_to(ROOT).parts)]
    return sorted(path for path in found if path.is_file() and path.suffix not in {".pyc", ".partial"})


def texts():
    for path in tracked_files():
        try:
            yield path, text_of(path)
        except UnicodeDecodeError:  # a picture
            continue


def lines_with(pattern):
    for path, text in texts():
        for number, line in enumerate(text.splitlines(), 1):
            if pattern.search(line):
                yield f"{path.relative_to(ROOT)}:{number}: {line.strip()[:80]}"


def test_folders_of_unit_tests_are_those_of_the_source():
    """One that holds tests of a single module may have the name of the module."""
    tests = ROOT / "tests" / "unit"
    folders = {path.parent.relative_to(tests) for path in tracked_files() if path.is_relative_to(tests)}
    assert len(folders) > 20
    strange = {
        str(each)
        for each in folders
        if not (SOURCE / each).is_dir() and not (SOURCE / each).with_suffix(".py").is_file()
    }
    assert not strange


def test_no_file_names_a_place_on_one_machine_or_an_index_of_packages_and_there_is_no_lock_file():
    assert not [*lines_with(PLACES), *lines_with(INDEXES)]
    locks = {"poetry.lock", "uv.lock", "pdm.lock", "Pipfile.lock", "requirements.txt", "pylock.toml"}
    names = {path.relative_to(ROOT).as_posix() for path in tracked_files()}
    assert not locks & {name.rpartition("/")[2] for name in names}
    assert {"pyproject.toml", "src/electrovib/core/units.py", "tests/architecture/test_tree.py"} <= names


@pytest.mark.parametrize(
    ("line", "pattern", "found"),
    [
        ("see /ho~me/someone/x", PLACES, True),
        ("cd '/ro~ot/x'", PLACES, True),
        (r"open(C:\Us~ers\x)", PLACES, True),
        ("papers/ho~me/x and https://a.example/ro~ot/x", PLACES, False),
        ("https://py~pi.org/simple", INDEXES, True),
        ("pip --index-~url x", INDEXES, True),
        ("a copy in a venv", INDEXES, False),
    ],
)
def test_the_search_can_find(line, pattern, found):
    assert bool(pattern.search(spelled(line))) == found


def test_files_can_be_read_in_one_sitting():
    sizes = {path: len(text_of(path).splitlines()) for path in SOURCE.rglob("*.py")}
    long = {str(path.relative_to(SOURCE)): size for path, size in sizes.items() if size > LONGEST}
    assert not long
    assert sizes
