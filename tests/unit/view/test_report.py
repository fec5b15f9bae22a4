"""The report of a run: one file, whole or not there."""

import functools
import re
from html.parser import HTMLParser

import numpy as np
import pytest

from electrovib.core.errors import ElectrovibError, InputError
from electrovib.scenario import scenario_of
from electrovib.scenario.toml import to_toml
from electrovib.solve.simulate import simulate
from electrovib.studies.sweep import sweep
from electrovib.view import report as module
from electrovib.view.report import report, reported

VOID = {"meta", "link", "br", "wbr"}


class Page(HTMLParser):
    """Collects what a browser would fetch or run, and checks that tags close."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.fetched, self.names, self.words, self.open = [], [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        if tag not in VOID:
            self.open.append(tag)
        for name, value in attrs:
            loads = name in {"src", "href", "data", "action", "srcset", "xlink:href"}
            self.fetched += [value] if loads and not value.startswith(("#", "data:,")) else []
            self.names += [value] if name == "id" else []
            assert not name.startswith("on")

    def handle_startendtag(self, tag, attrs):
        self.handle_starttag(tag, attrs)
        if tag not in VOID:
            self.open.pop()

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.words.append(" ".join(data.split()))


def written(tmp_path, traces, **more):
    path = report(traces, tmp_path / "report.html", **more)
    text = path.read_text(encoding="utf-8")
    page = Page(text)
    assert page.open == []
    return text, page


@pytest.fixture(scope="module")
def pages(tmp_path_factory, trace, other, swept, measured):
    """Return a function that writes the report of some Traces once: text and parsed page."""
    traces = {"run": trace, "swept": swept, "measured": measured}
    traces["two"] = {"Maxwell stress in the gap": trace, "effective medium": other}
    return functools.cache(lambda name: written(tmp_path_factory.mktemp("pages"), traces[name]))


def test_a_page_needs_nothing_from_elsewhere_and_is_the_same_twice(tmp_path, pages, trace):
    for name in ("run", "two", "swept", "measured"):
        text, page = pages(name)
        assert page.fetched == []
        assert not {"script", "iframe", "object", "img", "embed"} & set(page.tags)
        for address in ("http://", "https://", "@import"):
            assert address not in text
        assert not re.search(r"url\((?!#)", text)
        assert set(re.findall(r"url\(#([^)]*)\)", text)) <= set(page.names)
        assert len(page.names) == len(set(page.names))
    assert written(tmp_path, trace)[0] == pages("run")[0]


def test_what_a_report_of_a_run_holds(tmp_path, pages, trace, blank):
    """It opens with the result and its validity."""
    text, page = pages("run")
    headings = {"Validity", "Key numbers", "Stack", "Over time", "Over frequency", "Parameters", "Models"}
    shown = {"Glass & <film>", "warning", "ok", "90 µm", "data sheet of the film", "pressure = ε₀·E²/2"}
    assert headings | shown | {trace.attrs["scenario_hash"]} <= set(page.words)
    assert any(word.startswith("Python 3") for word in page.words)
    assert page.tags.count("svg") == 3
    assert '<span class="word warning">warning</span>' in text
    assert "effective voltage" not in page.words
    numbers, validity, stack = (page.words.index(word) for word in ("Key numbers", "Validity", "Stack"))
    assert numbers < validity < stack
    before = " ".join(page.words[:numbers])
    peak = float(trace.electrostatic_force.max())
    for words in (
        f"Largest electrostatic force: {peak / 1e-3:.4g} mN. Validity: ",
        "warning (",
        "electrowetting",
    ):
        assert words in before
    thinner = scenario_of(trace).replace({"stack.gap.thickness": "4 um"})
    with blank():
        _, page = written(tmp_path, simulate(thinner, time=np.linspace(0, 0.1, 11)))
    assert "unknown" in page.words, "Paschen's law says nothing of it"


def test_several_traces_show_first_what_differs(tmp_path, pages, other):
    """An effective voltage stands where the law has one."""
    text, page = pages("two")
    assert "2 Traces compared" in page.words
    assert sum(word.startswith("effective medium: Largest") for word in page.words) == 1
    differs, same = page.words.index("Parameters: what differs"), page.words.index("What is the same")
    between = page.words[differs:same]
    assert {"5 µm", "1 µm", "MaxwellStressInGap", "EffectiveMedium"} <= set(between)
    assert "90 µm" not in between
    assert "90 µm" in page.words[same:]
    assert page.tags.count("svg") == 4
    assert text.count("<summary>Scenario of") == 2
    assert 'aria-label="Over time: drive, effective voltage,' in written(tmp_path, other)[0]
    assert 'aria-label="Over time: drive, voltage across each layer,' in pages("run")[0]


def test_a_sweep_says_what_was_swept(pages):
    """A curve over the parameter, never records on top of each other."""
    _, page = pages("swept")
    for words in (
        "Each diagnostic is that of the case nearest to its limit, or furthest beyond it.",
        "Over the thickness of the gap",
        "Taken over the whole time.",
        "100 nm … 100 µm (15 values)",
    ):
        assert words in page.words
    assert "Over time" not in page.words
    assert page.tags.count("svg") == 2


def test_a_measurement_shows_what_there_is_and_its_text_stays_text(tmp_path, pages, measured):
    _, page = pages("measured")
    assert page.tags.count("svg") == 1
    assert "N. N." in page.words
    assert "Parameters" not in page.words
    evil = measured.copy()
    evil.attrs |= {"title": "<script>alert(1)</script>", "note": '"><img src=x>'}
    text, page = written(tmp_path, evil)
    assert not {"script", "img"} & set(page.tags)
    assert "&lt;script&gt;" in text
    _, page = written(tmp_path, measured.drop_vars(["lateral_force", "drive_voltage"]), title="nothing")
    assert "nothing" in page.words
    assert "svg" not in page.tags
    _, page = written(tmp_path, measured.assign_attrs(scenario='{"schema": 0}'))
    assert any("is shown without its parameters: schema" in word for word in page.words)


@pytest.mark.usefixtures("blank_pictures")
def test_files_scenarios_and_labels(tmp_path, scenario, measured):
    file = tmp_path / "film.toml"
    file.write_text(to_toml(scenario), encoding="utf-8")
    page = tmp_path / "page.html"
    found = reported([str(file), file, measured, scenario], page)
    assert list(found.judged) == ["film", "film (2)", "tribometer", "Glass & <film>"]
    assert found.sentences[0].startswith("film: Largest electrostatic force: ")
    assert list(reported({"mine": measured}, page).judged) == ["mine"]
    assert list(reported(measured, page).judged) == ["tribometer"]


def test_what_cannot_be_loaded_or_written_is_refused_before_the_work(tmp_path, monkeypatch, trace):
    monkeypatch.setattr(module, "document_of", lambda *_, **__: pytest.fail("drawn in vain"))
    with pytest.raises(InputError) as caught:
        report([trace, "missing_2099/nothing", str(tmp_path / "gone.toml")], tmp_path / "r.html")
    assert len(caught.value.problems) == 2
    for name in ("no/such/folder/r.html", "r.xyz"):
        with pytest.raises(ElectrovibError):
            report(trace, tmp_path / name)
    assert list(tmp_path.iterdir()) == []


def test_a_sweep_over_three_parameters_draws_maps_at_the_ends_of_the_first(tmp_path, scenario):
    over = {"drive.high": [10.0, 20.0, 30.0], "stack.gap.thickness": [1e-6, 5e-6], "drive.rise": [1e-3, 2e-3]}
    cube = sweep(scenario, over, quantity=["mean electrostatic_force"])
    _, page = written(tmp_path, {"cube": cube, "one": sweep(scenario, {}, quantity=["peak current"])})
    text = " ".join(page.words)
    title = "Over the thickness of the gap and the rise of the drive: cube"
    assert all(words in text for words in (title, "at drive.high = 10 V.", "at drive.high = 30 V."))
    assert "drive.high = 20 V" not in text
