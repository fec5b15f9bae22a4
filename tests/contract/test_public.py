"""What the last release had, as `docs/api.md` lists it, is still there, or warns until the version in which it goes."""

import importlib
from pathlib import Path

import pytest

import electrovib as ev
from electrovib.core import deprecation
from electrovib.core.deprecation import Former
from electrovib.core.discovery import find_members
from electrovib.physics.force import ForceLaw
from electrovib.studies.catalogue.items import everything

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "api.md").read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def api():
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(DOCS / "_ext"))
        yield importlib.import_module("api")


@pytest.fixture(scope="module")
def now(api):
    return api.read(api.as_markdown())


def test_nothing_that_the_last_release_had_is_lost(api, now):
    """A name that is meant to go is deprecated first (CONTRIBUTING.md); a new one joins the page with the next release."""
    before = api.read(PAGE)
    assert sum(map(len, before.values())) > 300
    assert not api.lost(before, now, at=api.version())


def test_the_lists_hold_every_public_name_every_model_and_every_option(api, now):
    assert now == {title: entries for title, entries in api.public().items() if entries}
    functions = {each.name for each in now["Functions"]}
    assert functions > set(dir(ev)) - {"plot", "__version__"}
    assert functions > {f"plot.{name}" for name in ev.plot.__all__}
    assert {each.name for each in now["ForceLaw"]} == {
        name for name, law in find_members(ForceLaw).items() if law.__module__.startswith("electrovib.")
    }
    models = {each.name for entries in now.values() for each in entries if each.is_called}
    assert models > {item.name for item in everything(own=True) if isinstance(item.thing, type)}
    lines = api.as_markdown().splitlines()
    for line in (
        "- `simulate(scenario, *, time=, signals=)`",
        "- `Coulomb(*, coefficient)`",
        "- `Sine(*, amplitude, offset=, frequency, phase=, high=, low=)`",
        "- `LogNormal(*, median, factor)`",
        "- `electrostatic_force [N]`",
        "- `electrovib: --version, --models, --budget`",
        "- `electrovib list: QUERY, --all, --bibtex`",
        "- `3 MISFIT`",
        "- `electrovib.physics.force: ForceLaw`",
    ):
        assert line in lines
    (answer,) = (each for each in now["Attributes of classes and results"] if each.name == "FitResult")
    assert {"best", "document", "posterior"} <= set(answer.parts)


BEFORE = """
## Functions

- `simulate(scenario, signals=, *, time=)`
- `save(trace, path)`

## Drive

- `Sine(*, amplitude, offset=)`

## Commands

- `electrovib run: SCENARIO, --set`

## Deprecated

- `simulate_scenario: now simulate, since 1.1.0, goes in 2.0.0`
"""
CHANGES = {
    "nothing": ("", "", []),
    "a function": ("- `save(trace, path)`\n", "", ["save is gone"]),
    "a parameter": ("time=", "at=", ["simulate: time is gone"]),
    "a name in place of a place": (
        "scenario, signals=, *",
        "scenario, *, signals=",
        ["simulate: another order of scenario, signals"],
    ),
    "another order": ("trace, path", "path, trace", ["save: another order of trace, path"]),
    "one more with a default": ("time=", "time=, seed=", []),
    "one more to be given": ("time=", "time=, seed", ["simulate: seed has to be given"]),
    "any more by name": ("trace, path", "trace, path, **more", []),
    "a default": ("offset=", "offset", ["Sine: offset has to be given"]),
    "a new default": ("amplitude,", "amplitude=,", []),
    "a model": ("Sine(", "Wave(", ["Sine is gone"]),
    "a family": ("## Drive", "## Source", ["Sine is gone"]),
    "an option": (", --set", "", ["electrovib run: --set is gone"]),
    "a new option": (", --set", ", --set, --over", []),
    "a former name": (
        "- `simulate_scenario: now simulate, since 1.1.0, goes in 2.0.0`\n",
        "",
        ["simulate_scenario is gone"],
    ),
}


@pytest.mark.parametrize("what", CHANGES)
def test_what_a_user_would_miss_is_said(what, api):
    old, new, told = CHANGES[what]
    assert old in BEFORE
    assert api.lost(api.read(BEFORE), api.read(BEFORE.replace(old, new, 1)), at="1.9.0") == told


@pytest.mark.parametrize(("at", "told"), [("2.0.0rc1", ["old is gone"]), ("2.0.0", []), ("2.1.0", [])])
def test_a_former_name_goes_in_its_version_and_not_before(at, told, api):
    before = api.read("\n## Deprecated\n\n- `old: now new, since 1.1.0, goes in 2.0.0`\n")
    assert api.lost(before, {}, at=at) == told


def test_a_name_that_warns_is_not_lost(api, monkeypatch):
    former = Former("simulate", since="1.1.0", goes="2.0.0")
    monkeypatch.setitem(deprecation.FORMER, "save", former)
    monkeypatch.setattr(ForceLaw, "former", {"StressInGap": former, "pull": former})
    known = list(map(api.of_former, *zip(*api.former(), strict=True)))
    assert [str(each) for each in known if each.parts[0] == "now simulate"] == [
        f"{name}: now simulate, since 1.1.0, goes in 2.0.0"
        for name in ("save", "ForceLaw.StressInGap", "ForceLaw.pull")
    ]
    before = api.read(
        "\n## Functions\n\n- `save(trace)`\n\n## ForceLaw\n\n- `StressInGap()`\n- `ForceLaw(*, pull, push)`\n"
    )
    now = api.read("\n## ForceLaw\n\n- `ForceLaw(*, push)`\n") | {api.DEPRECATED: known}
    assert api.lost(before, now, at="1.1.0") == []
    assert api.lost(before, api.read("\n## ForceLaw\n\n- `ForceLaw(*, push)`\n"), at="1.1.0") == [
        "save is gone",
        "StressInGap is gone",
        "ForceLaw: pull is gone",
    ]


def test_the_promise_stands_before_the_lists(api):
    promise, mark, lists = PAGE.partition(api.MARK)
    assert mark
    assert "at least one minor version" in promise
    assert lists.lstrip().startswith("Version ")
