"""The file of a publication: whoever edits it needs no Python, and each mistake is named with its path."""

import re
from pathlib import Path

import pytest

from electrovib.core.errors import InputError
from electrovib.papers import nakamura_2017, read_published

SHIPPED = Path(nakamura_2017.__file__).with_name("published")
HEAD = 'schema = 1\nstatus = "abstract"\ncitations = [{ kind = "misc", title = "x", year = 2099 }]\n'
FIRST = '[scenarios.first]\ntitle = "Own 2099"\nchanges = { "drive.level" = "20 V" }\n'


@pytest.fixture
def written(tmp_path):
    def write(text):
        path = tmp_path / "own_2099.toml"
        path.write_text(text, encoding="utf-8")
        read_published.cache_clear()
        return read_published(path)

    return write


def test_an_edited_copy_has_the_edited_numbers_in_all_that_begin_with_them(written):
    text = (SHIPPED / "nakamura_2017.toml").read_text(encoding="utf-8")
    found = written(text.replace('"drive.level" = "100 V"', '"drive.level" = "50 V"')).scenarios()
    shipped = nakamura_2017.scenarios()
    assert list(found) == list(shipped)
    for name, each in found.items():
        assert each.drive.level == 50.0
        assert each.replace({"drive.level": 100.0}) == shipped[name]
        assert each.sources == shipped[name].sources


def test_what_a_file_states_is_offered(written):
    skin = '[skins.arm]\nname = "an arm"\nstatus = "derived"\nnote = "y"\nmaterial = { model = "Constant", permittivity = 9.0 }\n'
    number = '[values]\ntau = { value = 2e-3, unit = "s", meaning = "z" }\nends = { value = [1, 3], unit = "1", meaning = "z" }\n'
    found = written(f"{HEAD}{number}{skin}{FIRST}")
    arm = found.skins()["arm"]
    assert (arm.material.permittivity, arm.source) == (9.0, found.declared.citation)
    assert (found.number("tau"), found.interval("ends")) == (2e-3, (1.0, 3.0))
    assert found.declared.status == "abstract"
    assert list(found.declared.presets) == ["first"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (HEAD.replace("status", "statsu"), "own_2099.toml.statsu: no entry of a publication. Did you mean 'status'?"),
        (HEAD.replace("status", "statsu"), "own_2099.toml.status: missing"),
        (HEAD.replace("= 1", "= 2", 1), "own_2099.toml.schema = 2"),
        (f"{HEAD}defects = 3\n", "own_2099.toml.defects = 3: expected a list"),
        (f"{HEAD}[scenarios.first]\nchanges = 3\n", "own_2099.toml.scenarios.first.changes = 3: expected a table"),
        (f"{HEAD}[scenarios.first]\n", "own_2099.toml.scenarios.first.title: missing"),
        (f'{HEAD}[[checks]]\nname = "a"\nexpect = "b"\nsource = "c"\ncompute = "d"\n',
            "own_2099.toml.checks.0.expect = 'b'"),
        (f"{HEAD}[skins.arm\n", "own_2099.toml: "),
        (HEAD + FIRST.replace("level", "levle"), "own_2099.scenarios.first.drive.levle: "),
        (HEAD + FIRST.replace("20 V", "20 N"), "own_2099.scenarios.first.drive.level = '20 N': expected a voltage"),
        (f'{HEAD}{FIRST}sources = {{ "drive.levle" = "x" }}\n', "own_2099.scenarios.first.sources.drive.levle: no parameter"),
        (f'{HEAD}{FIRST}scenario = "first"\n', "own_2099.scenarios.first.scenario: it begins with itself"),
        (f'{HEAD}{FIRST}scenario = "vezzoli_2014/fig66"\n', "has no scenario 'fig66'"),
    ],
)  # fmt: skip
def test_each_mistake_is_named_with_its_path(text, words, written):
    with pytest.raises(InputError, match=re.escape(words)):
        dict(written(text).scenarios())


def test_what_is_not_asked_for_is_not_built(written):
    found = written(HEAD + FIRST.replace("level", "levle")).scenarios()
    assert "first" in found
    assert "second" not in found
    assert len(found) == 1
    with pytest.raises(KeyError, match="second"):
        found["second"]


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(InputError, match=r"none_2099\.toml: .*No such file"):
        read_published(tmp_path / "none_2099.toml")


def test_a_check_is_a_number_of_the_file_and_a_function_of_the_module(written):
    def both(*, factor):
        return factor, 3 * factor

    check = (
        '[[checks]]\nname = "three"\nexpect = 6.0\nwithin = 0.05\nsource = "table 1"\n'
        'compute = "both"\ngiven = { factor = 2.0 }\npart = 1\n'
    )
    (found,) = written(HEAD + check).checks(both)
    assert (found.value(), found.expect, found.status) == (6.0, 6.0, "derived")
    assert found.accepts(6.049)
    assert not found.accepts(6.051)
    with pytest.raises(InputError, match=r"checks\.three\.compute = both: the module has no such"):
        written(HEAD + check).checks(max)
    with pytest.raises(InputError, match=r"checks\.three: it takes one of rtol and within"):
        written(HEAD + check.replace("within", "rtol = 0.1\nwithin")).checks(both)
