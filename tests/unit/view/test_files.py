"""Documents as files: figures of a journal, tables as LaTeX, and what replaces what."""

import re
import zlib
from dataclasses import replace

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.answer import Answer, Curve, Document, Drawing, Panel, Table
from electrovib.core.errors import InputError
from electrovib.data.atomic import Form
from electrovib.view import style as figures
from electrovib.view.files import written
from electrovib.view.pages import drawn

QUICK = {"time.samples": 21, "frequency.samples": 3}
PULSE = ev.load("vezzoli_2014/fig6", changes=QUICK)
SINE = ev.load("bau_2010/sine")
LONG = "a label of the axis that is far too long for one line of one column of a journal"
ROW = ("50 % & more", "$x_1$ of {a_b}", "µm·Ω² ≤ #1")


class Sketch(Answer):
    FILES = {"a.csv": Form.TABLE, "b.csv": Form.TABLE}  # noqa: RUF012

    @property
    def document(self):
        figure = Drawing(id="f", title="Its figure", plot="stack", of=SINE, size=(3.0, 2.0))
        x = np.linspace(1.0, 9.0, 9)
        curves = tuple(Curve(label=f"{LONG} {n}", x=x, y=n * x) for n in range(1, 8))
        many = Panel(id="many", title=LONG, caption="", x=(LONG, "s"), y=(LONG, "N"), curves=curves)
        table = Table("Numbers", ("a", "b", "c"), (ROW,), caption="Said.")
        return Document(title="t", sentences=["one"], figures=[figure, many], tables=[table], alone="many")

    def content(self, name):
        return name


class Words(Answer):
    document = Document(title="t", sentences=["one"])


def sketched(figure):
    """Three Axes side by side with names along one, twins, and a legend beside each."""
    left, middle, right = figure.subplots(1, 3)
    left.set_yticks([0, 1], [LONG.replace(" ", "."), "short"])
    middle.twinx().set_ylabel(LONG)
    for ax in (middle, right):
        ax.plot([0, 1], label=LONG)
        ax.legend(loc="upper left", bbox_to_anchor=(1, 1))


SHOWN = {
    "run": lambda: ev.simulate(PULSE),
    "map": lambda: ev.sweep(PULSE, {"drive.high": [10.0, 20.0], "drive.rise": [1e-3, 2e-3]}),
    "check": lambda: ev.check(PULSE),
    "design": lambda: ev.find_value(PULSE, want="peak electrostatic_force = 1 mN", free="drive.high"),
    "laws": lambda: ev.compare(PULSE, models=["Vezzoli2014Causal", "MaxwellStressInInsulator"]),
    "coatings": lambda: ev.compare_materials(SINE, materials=["silica", "pet"]),
    "sketch": Sketch,
}


@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=() if name in {"run", "check", "sketch"} else pytest.mark.slow)
        for name in SHOWN
    ],
)
def test_a_figure_of_a_journal_is_85_mm_wide_with_letters_of_8_points_in_it(name, tmp_path):
    (path,) = ev.save(SHOWN[name](), tmp_path / "x.PDF", style="journal")
    content = path.read_bytes()
    width = float(re.search(rb"/MediaBox \[ ?0 0 ([\d.]+)", content)[1])
    assert width == pytest.approx(85 / 25.4 * 72, abs=0.01)
    assert b"/FontFile2" in content  # TrueType, embedded
    assert b"/Type3" not in content
    streams = re.findall(rb"stream\r?\n(.*?)\r?\nendstream", content, re.DOTALL)
    written = b"".join(zlib.decompress(each) for each in streams if each[:1] == b"x")
    sizes = {float(size) for size in re.findall(rb"/F\S+ ([\d.]+) Tf", written)}
    assert 8.0 in sizes
    assert sizes <= {8.0, 7.0, 5.6, 3.92, 4.9}  # the others are indices and exponents


@pytest.mark.parametrize("shown", [*Sketch().document.figures, Drawing(id="s", title="", plot=sketched)])
def test_nothing_of_it_is_cut_or_covered(shown):
    figure = drawn(shown)
    figures.one_column(figure)
    figure.draw_without_rendering()
    figure.draw_without_rendering()
    assert figure.get_figwidth() == pytest.approx(85 / 25.4)
    box = figure.get_tightbbox()
    assert -0.03 < box.x0 < box.x1 < figure.get_figwidth() + 0.03
    assert -0.03 < box.y0 < box.y1 < figure.get_figheight() + 0.03
    assert {text.get_fontsize() for text in figure.findobj(figures._is_text)} <= {8.0, 7.0}
    places = {tuple(np.round(ax.get_position().bounds, 3)) for ax in figure.axes}
    assert len({place[0] for place in places}) == 1  # below each other
    whole = [ax.get_window_extent() for ax in figure.axes]
    for legend in figure.legends:
        assert not any(legend.get_window_extent().overlaps(each) for each in whole)


def test_a_figure_carries_a_mark_and_no_style_of_an_earlier_one(tmp_path):
    for suffix, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")):
        (path,) = ev.save(Sketch(), tmp_path / f"f{suffix}")
        first = path.read_bytes()
        assert first.startswith(start)
        ev.save(Sketch(), path, style="journal")  # ours
        assert path.read_bytes() != first
        ev.save(Sketch(), path)
        assert path.read_bytes() == first
        path.write_bytes(first[:-9] + b"y" + first[-8:])
        with pytest.raises(InputError, match="is no figure that electrovib wrote"):
            ev.save(Sketch(), path)


@pytest.mark.usefixtures("blank_pictures")
def test_a_folder_has_every_figure_and_a_name_the_first_file_of_its_suffix(tmp_path):
    written = ev.save(Sketch(), tmp_path / "all")
    assert [path.name for path in written] == [
        "report.html",
        "a.csv",
        "b.csv",
        "f.pdf",
        "many_1.pdf",
        "many_2.pdf",
    ]
    assert ev.save(Sketch(), tmp_path / "x.csv")[0].read_text() == "a.csv"
    names = {path.name for path in ev.save(ev.simulate(PULSE), tmp_path / "run")}
    assert names == {"report.html", "trace.nc", "time.pdf", "frequency.pdf", "stack0.pdf"}
    assert ev.load(tmp_path / "run" / "trace.nc") == PULSE


def test_a_file_with_one_of_several_figures_or_tables_says_so():
    document = Sketch().document
    one, two = (
        replace(document, figures=document.figures[:1]),
        replace(document, figures=document.figures[:1] * 2),
    )
    assert written("x.png", lambda: one) == "written: x.png"
    assert written("x.PNG", lambda: two) == "written: x.PNG, one of 2 figures; a folder has all of them"
    few = replace(document, tables=document.tables[:1], numbers=())
    more = replace(few, tables=few.tables * 3)
    assert written("x.csv", lambda: few) == "written: x.csv"
    several = "written: x.csv, one of 3 tables; .tex, .html and .txt have all of them"
    assert written("x.csv", lambda: more) == several
    assert written("x.csv", lambda: more, {"a.csv": None}) == "written: x.csv"


def test_tables_as_latex_csv_and_text(tmp_path):
    mark, *lines = ev.save(Sketch(), tmp_path / "x.tex")[0].read_text().splitlines()
    assert mark.startswith("% electrovib tables in LaTeX, checksum ")
    assert lines == [
        *("% Numbers", "% Said.", r"\begin{tabular}{lll}", r"\hline", r"a & b & c \\", r"\hline"),
        r"50 \% \& more & $x_1$ of \{a\_b\} & $\mu$m$\cdot$$\Omega$$^2$ $\leq$ \#1 \\",
        *(r"\hline", r"\end{tabular}"),
    ]
    table = ev.save(ev.compare_materials(SINE, materials=["pet"]), tmp_path / "x.csv")[0].read_text()
    assert "\npet,3.15,no conduction,373.6 mN," in table
    (path,) = ev.save(Words(), tmp_path / "x.txt")
    assert path.read_text().startswith("t\n\none\n\nelectrovib text, checksum")


def test_what_has_no_figure_no_table_or_no_style_is_refused(tmp_path):
    trace = ev.simulate(PULSE)
    for found, name, style, words in (
        (Words(), "x.pdf", "", "x.pdf: this result has no figure; write it as .html"),
        (Words(), "x.tex", "", "this result has no table"),
        (trace, "x.nc", "journal", "--style = journal: belongs to a figure, '-o figure.pdf' or .svg or .png"),
        (trace, "x.pdf", "poster", "--style = poster: expected journal"),
        (trace, "gone/x.pdf", "", "the folder '.*gone' does not exist"),
        (trace, "x.jpg", "", r"saved as \.nc, .*\.pdf, .* not as '\.jpg'"),
    ):
        with pytest.raises(InputError, match=words):
            ev.save(found, tmp_path / name, style=style)
    assert not list(tmp_path.iterdir())
