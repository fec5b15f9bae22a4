"""The Examples of public functions run, and print what stands below them; `ev` is electrovib."""

import doctest
import inspect

import pytest
from matplotlib import pyplot as plt

import electrovib as ev

ELSEWHERE = (
    "electrovib.apps.",
    "electrovib.recordings.",
    "electrovib.studies.design.",
    "electrovib.solve.prepare",
)
"""Where functions take recordings or search: guides show them with their files."""
LONG = {"reproduce", "compare_surfaces"}
"""A whole paper takes ten seconds, and results of two others are those of `design` and of its module."""
CALLED = {name: getattr(ev, name) for name in dir(ev)} | {
    f"plot.{name}": getattr(ev.plot, name) for name in ev.plot.__all__
}
FUNCTIONS = {name: inspect.unwrap(each) for name, each in CALLED.items() if inspect.isfunction(each)}
TESTS = {
    name: doctest.DocTestParser().get_doctest(inspect.getdoc(each), {"ev": ev}, name, None, None)
    for name, each in FUNCTIONS.items()
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=pytest.mark.slow if name == "report" else ())
        for name, test in TESTS.items()
        if test.examples
    ],
)
def test_an_example_prints_what_stands_below_it(name, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    told = []
    failed, tried = doctest.DocTestRunner(verbose=False).run(TESTS[name], out=told.append)
    plt.close("all")
    assert (failed, tried) == (0, len(TESTS[name].examples)), "".join(told)


def test_every_function_for_which_a_scenario_is_enough_has_a_short_example():
    bare = {name for name, test in TESTS.items() if not test.examples}
    assert {name for name in bare if not FUNCTIONS[name].__module__.startswith(ELSEWHERE)} <= LONG
    long = {name for name, test in TESTS.items() if test.docstring.count("\n>>>") > 4}
    assert not long
