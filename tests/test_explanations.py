"""The numbers in the explanations of the documentation are those that the toolkit computes."""

import base64
import importlib
import re
import textwrap
import tomllib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

import electrovib as ev
from electrovib.core.discovery import papers
from electrovib.papers.vezzoli_2014.compute import causality_residual
from electrovib.studies.evidence.measurement import numbers_of

FOLDER = Path(__file__).parent.parent / "docs" / "explanation"


@pytest.fixture
def computed(monkeypatch):
    """Return the part of the build of the documentation that computes its figures."""
    monkeypatch.syspath_prepend(str(FOLDER.parent / "_ext"))
    return importlib.import_module("computed")


def page(name):
    (found,) = FOLDER.glob(f"*_{name}.md")
    return found.read_text(encoding="utf-8")


def section(name, title):
    """Return one section of a page."""
    return page(name).partition(f"## {title}\n")[2].partition("\n## ")[0]


def one(pattern, text):
    """Return the only number that a pattern finds in a text, line breaks ignored."""
    (found,) = re.findall(pattern, " ".join(text.split()))
    return float(found)


def test_what_a_held_voltage_does_depends_on_what_conducts():
    """The table of the page: nothing in the gap conducts, or the gap conducts, or the insulator more than the gap."""
    base = ev.load("vezzoli_2014/fig6_gap").replace({"drive": {"model": "Step", "level": "100 V"}})
    air = {"model": "Constant", "permittivity": 1.0}
    film = {"model": "Constant", "permittivity": 3.35, "conductivity": "10 nS/m"}
    times = [1e-6, 0.3]
    cases = {
        "kept": {"stack.gap.material": air},
        "lost": {},
        "raised": {"stack.gap.material": air, "stack.insulator.material": film},
    }
    late_over_early = {}
    for name, change in cases.items():
        force = ev.simulate(base.replace(change), time=times).electrostatic_force
        late_over_early[name] = float(force[1] / force[0])
    assert 1 <= late_over_early["kept"] < 1.02
    assert late_over_early["lost"] < 1e-6
    assert late_over_early["raised"] > 100


def test_the_figure_of_the_mechanism_is_that_of_the_text(computed):
    """The law of Vezzoli et al. 2014; `test_numbers_by_hand` holds the numbers of the text against closed forms."""
    text = section("how_it_works", "Why the attraction fades after a step, and grows with frequency")
    tau = computed.time_constant()
    assert 1e3 * tau == pytest.approx(one(r"which is ([\d.]+) ms", text), abs=0.005)
    half, share = one(r"within ([\d.]+) ms", text), one(r"to ([\d.]+) % of its first value", text)
    law, leaky, sealed = computed.responses().values()
    assert 100 * np.interp(half * 1e-3, law.time, law.force) == pytest.approx(share, abs=0.5)
    closed = 1 / (1 + 1 / (2 * np.pi * tau * law.frequency) ** 2)
    assert law.mean == pytest.approx(closed, abs=0.006)
    # the leaking gap of 1 um has nearly the same time constant; without a leak the force rises by 1 %
    assert np.max(np.abs(leaky.force - law.force)) < 0.02
    rise = one(r"it rises by (\d+) %", section("how_it_works", "What has to conduct"))
    assert 100 * (sealed.force[-1] - 1) == pytest.approx(rise, abs=0.1)
    assert 0 < sealed.mean[0] - 1 < 0.011


def test_the_laws_without_a_gap_give_the_force_of_some_gap(computed):
    text = page("why_forces_differ")
    table = text.partition("<!-- equivalent gaps -->")[2].partition("<!-- end -->")[0]
    lines = [line.strip("| ").split(" | ") for line in table.split("\n")[3:-1]]
    rows = {cells[0]: cells[1:] for cells in lines}
    assert len(rows) == 3
    micro = {"um": 1.0, "mm": 1e3}
    for place, found in enumerate(computed.forces()):
        at_five = computed.static(found.stack.scenario("MaxwellStressInGap", gap=5e-6))
        for place_in_curve, gap in ((0, 0.1e-6), (-1, 100e-6)):
            there = found.stack.scenario("MaxwellStressInGap", gap=gap)
            assert found.in_gap[place_in_curve] == pytest.approx(computed.static(there), rel=1e-9)
        for law, cells in rows.items():
            ratio, (gap, unit) = cells[2 * place], cells[2 * place + 1].split()
            assert found.others[law] / at_five == pytest.approx(float(ratio), rel=5e-3)
            there = found.stack.scenario("MaxwellStressInGap", gap=float(gap) * micro[unit] * 1e-6)
            assert computed.static(there) == pytest.approx(found.others[law], rel=1e-2)
        largest = one(r"a factor of up to (\d+)", text)
        assert max(found.others.values()) / min(found.others.values()) <= largest * (1 + 1e-9)
    gap, skin = (found.others[f"MaxwellStressIn{name}"] for name in ("Gap", "StratumCorneum"))
    assert gap / skin == pytest.approx(largest)


def test_the_gap_of_a_rough_contact_depends_on_what_is_asked(computed):
    """Plates with the same capacitance or attraction by their closed forms, from the maps of gap and attraction."""
    found, text = computed.gaps().found, page("which_gap")
    last, thickness, eps0 = found.rests[-1], found.stack.electrical_thickness, 8.8541878128e-12
    near = last.gap < 0.5e-6
    share = [100 * float(np.mean(rest.pressure > 0)) for rest in (found.rests[0], last)]
    attraction = float(last.attraction.mean())
    mean = eps0 * 40**2 / 2 / (last.gap.mean() + thickness) ** 2
    square = 40**2 * np.sin(np.pi * (np.arange(2000) + 0.5) / 4000) ** 2
    sine, slow = (np.interp(each, found.voltage**2, found.attraction) for each in (square, 40**2 / 2))
    shown = {
        r"mean distance \| ([\d.]+) µm": 1e6 * last.gap.mean(),
        r"same capacitance \| ([\d.]+) µm": 1e6 * (1 / np.mean(1 / (last.gap + thickness)) - thickness),
        r"same attraction \| ([\d.]+) µm": 1e6 * (np.sqrt(eps0 * 40**2 / 2 / attraction) - thickness),
        r"is ([\d.]+) µm here": 1e6 * thickness,
        r"µm are ([\d.]+) % of": 100 * near.mean(),
        r"carry ([\d.]+) % of": 100 * last.attraction[near].sum() / last.attraction.sum(),
        r"attraction is ([\d.]+) times that": attraction / mean,
        r"attraction, ([\d.]+) kPa": 1e-3 * attraction,
        r"grows from ([\d.]+) %": share[0],
        r"grows from [\d.]+ % to ([\d.]+) %": share[1],
        r"power ([\d.]+)\.": np.polyfit(*np.log([found.voltage[10:], found.attraction[10:]]), 1)[0],
        r"125 µm ([\d.]+) % of": 100 * found.smoother[0, -1],
        r"would be ([\d.]+) times": found.smoother[1, -1] / attraction,
        r"less than ([\d.]+) MV/m in the film": 1e-6 * np.median(40 / (1e-6 + 3.9 * last.gap)),
        r"the spots ([\d.]+) MV/m": 1e-6 * 40 / 1e-6,
        r"40 V falls to ([\d.]+) kPa": 1e-3 * last.with_field_share(0.0).mean_attraction,
        r"smaller by a factor of ([\d.]+),": np.mean(sine) / slow,
        r"the peak by ([\d.]+)\.": attraction / (2 * slow),
    }
    for pattern, value in shown.items():
        number = re.findall(pattern, " ".join(text.split()))[0]
        half = 0.5 * 10.0 ** -len(number.partition(".")[2])
        assert float(number) == pytest.approx(value, abs=1.001 * half), pattern


def test_the_scenario_of_the_rough_contact_runs_it(computed):
    found, text = computed.gaps().found, page("which_gap")
    tables = tomllib.loads(textwrap.dedent(re.search(r"    force = \{.*?\n\n(?!    )", text, re.DOTALL)[0]))
    held = {"drive": {"model": "Step", "level": 40.0}, "contact.surface": tables["contact"]["surface"]}
    run = ev.run("bau_2010/sine", set={"force": tables["force"]} | held)
    assert float(run.electrostatic_force[-1]) == pytest.approx(found.force[-1], rel=5e-3)


def test_the_errors_of_the_laws_of_rough_contact_are_those_of_the_benchmark():
    """Every law's median and range, at the digits of the page."""
    measured, text = (FOLDER.parents[1] / "benchmarks" / "rough_laws.md").read_text(), page("which_gap")
    rows = {
        "share in contact": "contact share of the erf law",
        "attraction of Gaussian gaps": "attraction of Gaussian gaps, share of the erf law",
        "attraction of plates": "attraction of plates at the mean gap",
    }
    for words, law in rows.items():
        known = re.search(rf"\| {law} \| ([\d.]+) \(([\d.]+) to ([\d.]+)\)", measured).groups()
        shown = re.search(rf"\| {words}[^|]*\| ([\d.]+) \(([\d.]+) to ([\d.]+)\)", text).groups()
        for number, value in zip(shown, known, strict=True):
            assert float(number) == pytest.approx(float(value), abs=5.1e-3)
    others = re.search(r"\| attraction \|(?:[^|]*\|){2}[^|]*\| (\d+) %", measured).group(1)
    share = re.search(r"\| contact share \|(?:[^|]*\|){2}[^|]*\| (\d+) %", measured).group(1)
    assert f"for {share} % and {others} % of the contacts" in text
    run = re.search(r"\| contact share of a run \|(?:[^|]*\|){2}[^|]*\| (\d+) %", measured).group(1)
    assert f"of the solver for {run} % of the contacts of the ten surfaces" in text
    alone = re.search(r"\| attraction from the load alone \|(?:[^|]*\|){2}[^|]*\| (\d+) %", measured).group(1)
    assert f"within 15 % for {alone} %" in text


LINE = re.compile(r'<g id="line2d_\d+">\s*<path d="([^"]+)"')
NUMBER = re.compile(r"-?\d+(?:\.\d+)?")


def curves(svg):
    """Coordinates of the curves, which have more points than ticks and frames."""
    found = [np.array(NUMBER.findall(path), dtype=float) for path in LINE.findall(svg)]
    return [each for each in found if each.size > 40]


@pytest.mark.parametrize(
    "name",
    [
        "mechanism",
        *(pytest.param(each, marks=pytest.mark.slow) for each in ("gap", "laws", "causality", "tutorial")),
    ],
)
def test_the_figures_of_the_repository_are_those_that_are_computed(name, computed):
    figures = importlib.import_module("figures")
    assert set(figures.FIGURES) == {file.stem for file in figures.FOLDER.glob("*")}
    kept, drawn = (
        curves(each) for each in ((figures.FOLDER / f"{name}.svg").read_text(), figures.drawn(name))
    )
    assert len(kept) == len(drawn) > 1
    for one, other in zip(kept, drawn, strict=True):
        np.testing.assert_allclose(one, other, atol=0.5)


def pixels(svg):
    """Pictures within a figure, as numbers from 0 to 1."""
    coded = re.findall(r'"data:image/png;base64,\s*([^"]+)"', svg)
    return [np.asarray(Image.open(BytesIO(base64.b64decode(each))).convert("RGB")) / 255 for each in coded]


@pytest.mark.slow
def test_the_maps_of_the_repository_are_those_that_are_computed_one_for_each_voltage_of_the_slider(computed):
    del computed  # that puts the parts of the build on the path
    figures = importlib.import_module("figures")
    kept, drawn = (
        pixels(each) for each in ((figures.FOLDER / "maps.svg").read_text(), figures.drawn("maps"))
    )
    assert len(kept) == len(drawn) >= len(figures.MAPS)
    for one, other in zip(kept, drawn, strict=True):
        assert one.shape == other.shape
        assert (
            np.mean(np.abs(one - other).max(axis=2) > 0.05) < 0.01
        )  # a pixel at the rim of a spot may change
    (described,) = re.findall(r"!\[([^]]*)\]\([^)]*maps\.svg\)", page("which_gap"))
    assert [float(each) for each in re.findall(r"(\d+) V", described)] == list(figures.MAPS)


def test_the_laws_differ_in_time(computed):
    text = " ".join(page("why_forces_differ").split())
    skin = ev.load("vezzoli_2014/fig6").stack.layers["stratum_corneum"].material.conductivity
    forces = []
    for law, gap in (("MaxwellStressInStratumCorneum", 0.0), ("MaxwellStressInGap", 5e-6)):
        stack = computed.SCREEN.scenario(law, gap=gap)
        conducting = stack.replace({"stack.stratum_corneum.material.conductivity": skin})
        forces.append(1e3 * ev.simulate(conducting, time=[1e-9, 0.2]).electrostatic_force.values)
    fades, rises = forces
    assert fades[0] == pytest.approx(one(r"falls from ([\d.]+) mN to 0", text), abs=0.05)
    assert fades[1] < 1e-6
    shown = [float(each) for each in re.search(r"rises from (\d+) to (\d+) mN", text).groups()]
    assert list(rises) == pytest.approx(shown, abs=0.5)


def test_the_reading_as_printed_responds_before_its_cause(computed):
    found = computed.readings()
    before = found.time < 0
    early = float(np.interp(-1e-3, found.time, found.as_printed))
    assert 100 * early == pytest.approx(one(r"gives ([\d.]+) % of its largest", page("causality")), abs=0.5)
    skin = ev.load("vezzoli_2014/fig6").replace({"stack.stratum_corneum.material": computed.SKIN})
    material = skin.stack.layers["stratum_corneum"].material
    assert early == pytest.approx(causality_residual(material, ramp=computed.RAMP), rel=1e-2)
    assert np.all(found.causal[before] == 0)
    assert np.all(found.causal[~before][1:] > 0)
    point = computed.readings("vezzoli_2014/point")  # without dispersion both are one equation
    assert point.causal == pytest.approx(point.as_printed, abs=2e-3)
    assert point.as_printed.max() == pytest.approx(1, abs=2e-3)


def test_a_gap_that_breaks_down_is_named_as_such():
    gap = one(r"a gap of (\d+) um is beyond the breakdown of air", page("unknowns"))
    rows = ev.compare_surfaces().rows
    cells = {row[2]: row[3] for row in rows if row[0] == "MaxwellStressInGap" or not row[0]}
    assert "beyond breakdown" in cells[f"{gap:g} um"]
    assert "beyond breakdown" not in cells["10 um"]


SYMBOL = re.compile(r"\\?[A-Za-z]+(?:_\\?[A-Za-z0-9]+)?(?:\^\*)?")
COMMANDS = {"\\frac", "\\left", "\\right", "\\quad", "\\cos", "\\sin"}


def symbols_of(text):
    """Return the symbols in the equations of a text."""
    equations = re.findall(r"\$\$?(.+?)\$\$?", text, re.DOTALL)
    found = {symbol for equation in equations for symbol in SYMBOL.findall(equation.replace("\\,", " "))}
    return found - COMMANDS


def test_every_symbol_of_the_explanations_is_in_the_nomenclature():
    found = symbols_of(r"$E_g$ and $$\frac{\tau s}{2}\,v$$ or $\varepsilon_s^*$")
    assert found == {"E_g", r"\tau", "s", "v", r"\varepsilon_s^*"}
    nomenclature = (FOLDER.parent / "nomenclature.md").read_text(encoding="utf-8")
    listed = symbols_of(nomenclature.partition("<!-- symbols -->")[2].partition("<!-- end -->")[0])
    used = set().union(*(symbols_of(file.read_text(encoding="utf-8")) for file in FOLDER.glob("*.md")))
    assert len(used) > 35
    assert used == listed


PAPER = FOLDER.parent.parent / "paper" / "paper.md"


def test_the_paper_counts_what_there_is():
    """At most 1000 words, as its journal asks."""
    _, _, text = PAPER.read_text(encoding="utf-8").split("---\n", 2)
    assert len(text.split()) <= 1000
    known, words = ev.measurements(), " ".join(text.split())
    assert one(r"(\d+) published measurements, \d+ numbers", words) == len(known)
    numbers = {number for name, each in known.items() for number in numbers_of(name, each)}
    assert one(r"published measurements, (\d+) numbers", words) == len(numbers)
    assert one(r"numbers of (\d+) groups, are declared", words) == len(
        {each.group for each in known.values()}
    )
    assert one(r"experiments of (\d+) publications", words) == len(papers())
    cited = set(re.findall(r"@(\w+)", text))
    assert cited == set(
        re.findall(r"^@\w+\{(\w+),", PAPER.with_suffix(".bib").read_text(encoding="utf-8"), re.MULTILINE)
    )
    assert all(PAPER.with_name(name).is_file() for name in re.findall(r"\]\((\w+\.png)\)", text))
