"""``electrovib study``, with its sensitivity: what is printed and written, refused, interrupted and shown meanwhile."""

import io
import os
import signal
import sys
from types import SimpleNamespace

import pytest
from stand_in_population import SPACE, StandInPopulation, stand_in

import electrovib as ev
from electrovib.apps.progress import items_shown, progress_words
from electrovib.core.budget import computed, each_item, items_heard
from electrovib.core.errors import InputError
from electrovib.core.paths import words_at
from electrovib.data.atomic import Form
from electrovib.studies.population.run import _where
from electrovib.view import pages as page

pytestmark = pytest.mark.usefixtures("blank_pictures")

STUDY = "study vezzoli_2014/fig6 --space space.toml"
FIVE = f"{STUDY} -n 5 --seed 1 -o a.zarr"


@pytest.fixture
def closed(here, monkeypatch):
    """A folder with a space, and fingers in closed form."""
    monkeypatch.setattr("electrovib.solve.population.Population", stand_in)
    (path, distribution), *_ = SPACE.items()
    lines = [f'[space."{path}"]', *(f"{name} = {value!r}" for name, value in distribution.items())]
    (here / "space.toml").write_text("\n".join(lines))
    return here


def test_the_command_prints_bands_and_writes_them(closed, said):
    asked = "-n 200 --seed 1 --exceed '1 mN' --percentiles 10,50"
    out = said(f"{STUDY} {asked} -o study.zarr -o a.csv -o a.html")
    for words in (
        "Electrostatic force at 50 ms, where its median is largest: 10th percentile",
        "above 1 mN at some time",
        "200 fingers, seed 1; in closed form; kernel: stand-in",
        "Scenario: Vezzoli 2014, figure 6",
        "warnings are of the scenario with its own values; single fingers are not judged",
        "written: a.html",
    ):
        assert words in out
    assert ev.open_study(closed / "study.zarr")["percentile"].values.tolist() == [10, 50]
    assert {each.name for each in closed.iterdir()} == {"space.toml", "study.zarr", "a.csv", "a.html"}


@pytest.mark.parametrize(
    ("line", "words"),
    [
        (
            f"{STUDY} -n 0 --seed -1 -o a.zarr --quantity forse --percentiles 100",
            ["n = 0: expected a number of", "seed = -1", "forse: not a signal", "percentiles = 100"],
        ),
        (
            f"{FIVE} --exceed '5 V' --budget-memory much",
            ["exceed = 5 V: expected a value in N", "budget_memory = much: expected an amount of memory"],
        ),
        (f"{FIVE} --quantity mean_force --quantity lateral_force", ["expected signals over the same axis"]),
        (f"{FIVE} -o a.xyz", ["name one folder DIR.zarr"]),
    ],
)
def test_all_mistakes_are_told_at_once_before_the_study(line, words, closed, refused, monkeypatch):
    monkeypatch.setattr(StandInPopulation, "signals", None)
    err = refused(line)
    assert all(word in err for word in words), err


def test_an_interrupted_command_says_how_far_it_came(closed, cli, said, monkeypatch):
    evaluated, original = [], StandInPopulation.signals

    def interrupted(self, draws):
        evaluated.append(1)
        if len(evaluated) == 2:
            signal.raise_signal(signal.SIGINT)
        return original(self, draws)

    monkeypatch.setattr(StandInPopulation, "signals", interrupted)
    # four tiles, however quick the first is
    monkeypatch.setattr("electrovib.studies.population.tiles._FIRST", 1000)
    monkeypatch.setattr("electrovib.studies.population.tiles.TileSizes.measured", lambda *_: None)
    asked = f"{STUDY} -n 4000 --seed 1 -o a.zarr"
    code, out, err = cli(asked)
    assert code == 130
    assert "of 4000 fingers are complete; the same command continues with the next" in out + err
    assert not (closed / "a.zarr" / ".lock").exists()
    said(asked)


def test_workers_are_a_number_or_the_address_of_a_scheduler():
    assert _where(None) is None
    assert _where("4") == {"workers": 4, "scheduler": None}
    assert _where("tcp://10.0.0.1:8786") == {"workers": None, "scheduler": "tcp://10.0.0.1:8786"}


SCENARIO, QUANTITY = "vezzoli_2014/fig6_gap", "peak electrostatic_force"
INDICES = f"study --sensitivity {SCENARIO} --space fingers --quantity '{QUANTITY}' -n 4"


@pytest.fixture(scope="module")
def found():
    return ev.sensitivity(SCENARIO, "fingers", quantity=QUANTITY, n=4, seed=1)


def test_the_command_prints_the_answer_first_and_its_folder_holds_what_the_function_returns(
    found, here, said, cli, table
):
    out = said(f"{INDICES} --seed 1 -o out")
    assert out.startswith(found.headline)
    assert out.startswith("Measure ")
    assert all(line in out for line in repr(found).splitlines())
    assert "stack.gap.thickness: the distribution is unverified, cited from memory" in " ".join(out.split())
    assert "written: out" in out
    rows = table(here / "out" / "indices.csv")
    assert [(row["input"], float(row["total"])) for row in rows] == [(e.name, e.total) for e in found.indices]
    elasticities = {each.path: each.value for each in found.elasticities}
    rows = table(here / "out" / "elasticities.csv")
    assert {row["parameter"]: float(row["elasticity"]) for row in rows} == elasticities
    assert ev.read_space(SCENARIO, here / "out" / "space.toml").distributions == found.space.distributions
    text = (here / "out" / "report.html").read_text()
    for words in ("<svg", "unverified, cited from memory", str(Form.PAGE)):
        assert words in text
    changed = said(f"{INDICES} --seed 1 --set 'drive.high=1 kV' --set 'drive.rise=0 s'")
    assert not changed.startswith(found.headline)
    assert cli(INDICES)[0] == 2  # without a seed


def test_the_figure_shows_both_indices_of_every_input_with_their_intervals(found):
    axes = ev.plot.indices(found)
    assert [label.get_text() for label in axes.get_yticklabels()] == [
        words_at(found.scenario, each.name) for each in found.indices
    ]
    widths = [bar.get_width() for bar in axes.patches]
    assert widths == [each.total for each in found.indices] + [each.first for each in found.indices]
    ends = [tuple(line.get_xdata()) for line in axes.lines]
    assert ends == [e.total_interval for e in found.indices] + [e.first_interval for e in found.indices]
    assert found._repr_html_().count("<table") == 2


def test_files_of_somebody_else_are_not_replaced(found, tmp_path):
    (tmp_path / "indices.csv").write_text("mine")
    (tmp_path / "file").write_text("")
    for output, words in ((tmp_path, r"indices\.csv"), (tmp_path / "file", "is a file")):
        with pytest.raises(InputError, match=words):
            ev.save(found, output)
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ((0, None, None, None), ""),
        ((0, 100, None, None), "0 of 100"),
        ((20480, 100000, 51000.0, 1.6), "20480 of 100000, 5.1e+04/s, 1.6 s left"),
        ((50, 100, 0.5, 7200.0), "50 of 100, 0.5/s, 2 h left"),
    ],
)
def test_progress_in_words(given, words):
    assert progress_words(*given) == words


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.mark.parametrize(
    ("stream", "columns", "lines"),
    [
        (
            Terminal,
            80,
            ["", "a paper, after 0 s: 1 of 2, numbers", "a paper, after 0 s: 2 of 2, figures", ""],
        ),
        (Terminal, 30, ["", "a paper, after 0 s: 1 of 2, n", "a paper, after 0 s: 2 of 2, f", ""]),
        (io.StringIO, 80, [""]),
    ],
)
def test_each_item_replaces_the_line_of_the_one_before_on_a_terminal(monkeypatch, stream, columns, lines):
    monkeypatch.setattr(sys, "stderr", written := stream())
    monkeypatch.setattr("shutil.get_terminal_size", lambda *_, **__: os.terminal_size((columns, 24)))
    with items_shown("a paper"):
        assert computed([("numbers", lambda: [1, 2]), ("figures", list)]) == [(1, 2), ()]
    list(each_item(["after the end"]))
    assert written.getvalue().split("\r\x1b[K") == lines


def test_the_line_is_removed_after_an_error(monkeypatch):
    monkeypatch.setattr(sys, "stderr", stream := Terminal())

    def interrupted():
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt), items_shown("reproducing a paper"):
        computed([("numbers", interrupted)])
    assert stream.getvalue().endswith("numbers\r\x1b[K")


def test_the_figures_of_a_reproduction_are_items(monkeypatch):
    heard, found = [], SimpleNamespace(panels=[SimpleNamespace(id="decay"), SimpleNamespace(id="thresholds")])
    monkeypatch.setattr("electrovib.view.pages.drawn", lambda panel: pytest.fail(panel.id))
    with items_heard(lambda *item: heard.append(item)), pytest.raises(pytest.fail.Exception):
        page.contents_of(found)
    assert heard == [("drawing of decay", 1, 2)]
