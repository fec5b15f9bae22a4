"""What `view/style.py` says of every figure, of every answer, paper, report and plot: points, colours, axes, captions."""

import functools
import re

import numpy as np
import pytest
from matplotlib.colors import to_rgb

import electrovib as ev
from electrovib.core.answer import REFERENCE, Panel
from electrovib.core.discovery import offers, papers
from electrovib.core.paths import words_at
from electrovib.view.pages import drawn, few_curves
from electrovib.view.report import document_of
from electrovib.view.style import MOST, PALETTE

from .test_answers import ANSWERS, SINE, answer

GAP = "stack.gap.thickness"


def reports():
    """Figures of a run, of two, of sweeps over one and two parameters, and of a study."""
    one = ev.load(SINE)
    runs = {"one": ev.simulate(one), "other": ev.simulate(one.replace({"drive.amplitude": 50.0}))}
    over = {"drive.amplitude": [10.0, 20.0, 30.0], GAP: [1e-6, 2e-6, 4e-6]}
    yield from document_of(runs).figures
    yield from document_of({"run": runs["one"]}).figures
    yield from document_of({"curve": ev.sweep(one, {GAP: over[GAP]})}).figures
    yield from document_of({"map": ev.sweep(one, over)}).figures
    yield from document_of({}, studied=ev.study(one, "fingers", n=8, seed=1)).figures


SOURCES = {
    **{name: lambda name=name: answer(name).document.figures for name in ANSWERS},
    "laws over a parameter": lambda: ev.compare(SINE, over=[f"{GAP}=1um:9um:3"]).document.figures,
    "all evidence": lambda: ev.evidence(n=4).document.figures,
    "reports": reports,
    **{
        name: lambda module=module: module.reproduce(skin=None).panels
        for name, module in papers().items()
        if hasattr(module, "reproduce")
    },
}


@functools.cache
def figures(source):
    return tuple(SOURCES[source]())


LONG = {"all evidence", *(name for name in SOURCES if name in papers())}
"""A whole paper or all that was measured takes seconds to tens of seconds."""


@pytest.fixture(
    scope="module",
    params=[pytest.param(name, marks=[pytest.mark.slow] if name in LONG else []) for name in SOURCES],
)
def shown(request):
    return figures(request.param)


def panels(shown):
    """Return every panel, also those below another one."""
    return [part for each in shown if isinstance(each, Panel) for part in (each, *each.below)]


def test_measured_points_are_drawn_in_every_part_and_a_band_with_its_line(shown):
    for panel in panels(shown):
        parts = few_curves(panel)
        wanted = [curve for curve in panel.curves if curve.drawn]
        kept = {id(curve.y) for part in parts for curve in part.curves}
        for curve in wanted:
            merged = any(curve.label in each.label.split(",\n") for part in parts for each in part.curves)
            assert id(curve.y) in kept or merged, f"{panel.id}: '{curve.label}' is lost"
            if curve.background:
                continue
            of_a_line = [other for other in wanted if other.look == curve.look and other is not curve]
            if curve.kind == "points" and (curve.look == REFERENCE or not of_a_line):
                alone = not any(each.kind != "points" and each.look != REFERENCE for each in wanted)
                assert alone or all(any(each.y is curve.y for each in part.curves) for part in parts)
            if curve.kind == "band" and of_a_line:
                (part,) = [part for part in parts if any(each.y is curve.y for each in part.curves)]
                assert any(each.kind != "band" and each.look == curve.look for each in part.curves), panel.id


def test_few_things_in_a_figure_each_in_its_colour_and_one_grey(shown):
    for panel in panels(shown):
        for part in few_curves(panel):
            own = [each for each in part.curves if not each.background]
            lines = [each for each in own if each.kind not in {"band", "points"}]
            looks = [each.look for each in lines]
            own = {each.look for each in own} - {REFERENCE}
            assert len(set(looks)) == len(looks), f"{part.id}: two lines of one colour"
            assert len(own) <= MOST, f"{part.id}: {len(own)} things"
            assert all(look < len(PALETTE) for look in own)
            assert {each.look for each in part.curves}, f"{part.id}: nothing is drawn"


def words_of(axes):
    """Texts on the axes, of the title and of the legend."""
    return [axes.get_xlabel(), axes.get_ylabel(), axes.get_title(), axes.get_title(loc="left")]


def test_axes_are_in_words_with_a_unit_and_a_legend_has_one_grey(shown):
    for each in shown:
        for part in few_curves(each) if isinstance(each, Panel) else (each,):
            for axes in drawn(part).axes:
                for text in words_of(axes):
                    assert not re.search(
                        r"\b[a-z]+\.[a-z]|(?<!\$)_|^value( \[|$)", re.sub(r"\$.*?\$", "", text)
                    ), text
                legend = axes.get_legend()
                names = [text.get_text() for text in legend.texts] if legend else []
                assert len(set(names)) == len(names), names
                handles = legend.legend_handles if legend else []
                greys = [sign for each in handles if (sign := grey_sign(each))]
                assert len(set(greys)) == len(greys), (part.id, greys)


def grey_sign(handle):
    """Return the marker of a grey entry of a legend, or what has none; empty for a colour."""
    while isinstance(handle, tuple):
        handle = handle[0]
    has_face = hasattr(handle, "get_facecolor") and len(handle.get_facecolor())
    colour = np.ravel(handle.get_facecolor()) if has_face else to_rgb(handle.get_color())
    marker = getattr(handle, "get_marker", lambda: "None")()
    return marker if np.ptp(colour[:3]) < 0.05 else ""


def test_a_caption_says_what_one_sees(shown):
    for each in shown:
        assert not re.search(r"\w\.(csv|toml|json|svg|png)\b", each.caption), each.caption
        assert each.title


@pytest.mark.parametrize(
    ("path", "words"),
    [
        ("drive.amplitude", "drive voltage"),
        (GAP, "thickness of the gap"),
        ("stack.insulator.material.permittivity", "relative permittivity of the insulator"),
        ("stack.insulator.breakdown_field", "field at which the insulator breaks down"),
        ("load.normal_force", "normal force on the finger"),
        ("drive.phase", "phase of the drive"),
        ("limits.rms_current", "rms current of the limits"),
        ("mean electrostatic_force", "mean electrostatic force"),
        ("groups of moisture", "groups of moisture"),
    ],
)
def test_a_parameter_has_one_name_in_words(path, words):
    assert words_at(ev.load(SINE), path) == words


def test_no_two_parameters_have_one_name():
    """Of one scenario, so that both axes of a map are told apart."""
    for name, scenario in offers(("scenarios",)).items():
        names = [words_at(scenario, path) for path, *_ in scenario.parameters()]
        assert len(set(names)) == len(names), name


def test_friction_over_time_stands_beside_the_forces_of_a_swipe():
    forces, friction = answer("Swipes")[0], figures("Swipes")[1]
    (quotient, mean) = friction.curves
    assert friction.y == ("friction", "1")
    assert np.mean(quotient.y) == pytest.approx(0.4, rel=0.01)
    assert mean.y[0] == forces.friction.value


def test_a_single_abscissa_is_seen():
    """A threshold at one frequency has a mark, and its spread a bar."""
    (panel,) = (
        each
        for each in ev.evidence("israr_2006/cylinder", n=4).document.figures
        if each.id == "israr_2006_cylinder"
    )
    (axes,) = drawn(panel).axes
    assert axes.collections
    assert all(line.get_marker() not in {"", "None", None} for line in axes.lines)
