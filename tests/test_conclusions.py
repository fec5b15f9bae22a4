"""What README, guides and paper conclude from the evidence holds in every set of draws, and without any one group."""

from __future__ import annotations

import functools
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.studies.evidence.measurement import QUOTED
from electrovib.studies.evidence.predicted import predict
from electrovib.studies.evidence.score import log_odds, standings

ROOT = Path(__file__).parent.parent
README, LANDING, PAPER = "README.md", "docs/index.md", "paper/paper.md"
DIFFER, UNKNOWN = "docs/explanation/2_why_forces_differ.md", "docs/explanation/4_unknowns.md"
SEEDS = range(5)
GAP, INSULATOR, CAUSAL = "MaxwellStressInGap", "MaxwellStressInInsulator", "Vezzoli2014Causal"
MEDIUM, ROUGH = "EffectiveMedium", "Persson2018RoughGap"
PASSAGES = {
    README: r"\*\*The laws\.\*\*.*?(?=\n- )",
    PAPER: r"\*\*Laws beside what was measured\.\*\*.*?(?=\n\n)",
    DIFFER: r"(?<=## What measurements say\n).*?(?=\n## )",
    UNKNOWN: r"On a clutch with a metal pin.*?(?=\n\n)",
}
"""Passages all of whose numbers are conclusions."""
WORDS = {"two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7}
NUMBER = rf"(\d+(?:\.\d+)?|{'|'.join(WORDS)})"
TABLE = re.compile(r"<!-- evidence -->\n(.*?)<!-- end -->", re.DOTALL)


def text_of(page):
    return (ROOT / page).read_text(encoding="utf-8")


def number(word):
    return float(WORDS.get(word.lower(), word))


MEASURED = ev.measurements()
FORCES = {name: each for name, each in MEASURED.items() if each.judges == "force"}


def count(known):
    """Return measurements, numbers and groups."""
    return (
        len(known),
        sum(len(each.values) for each in known.values()),
        len({each.group for each in known.values()}),
    )


@functools.cache
def runs():
    """Return the evidence of every set of draws."""
    return [ev.evidence(seed=seed) for seed in SEEDS]


def tried_by_all():
    """Return the measurements that the laws with a skin predict."""
    names = {each.measurement for each in runs()[0].judging("force") if each.model == MEDIUM}
    return {name: FORCES[name] for name in names}


@functools.cache
def left_out(*, every_law=False):
    """Return for every set of draws, with all groups and without each one: this group, and the standings of the laws.

    Of all measurements of forces, or of those that every law can be tried on.
    """
    chosen, found = tried_by_all() if every_law else FORCES, []
    for one in runs():
        own = [each for each in one.judging("force") if each.measurement in chosen]
        groups = ["", *sorted({each.group for each in own})]
        found += [(out, standings([each for each in own if each.group != out])) for out in groups]
    return found


def of_law(model, standing):
    return next((each for each in standing if each.model == model), None)


def in_range(low, high, values, *, idle=1.6):
    """Values lie in a printed range, to its rounding, which is not much wider than they are (`idle`, a factor)."""
    values = np.array(values)
    assert low * 0.95 <= values.min(), (low, values.min())
    assert values.max() <= high * 1.05, (high, values.max())
    assert values.min() <= low * idle, (low, values.min())
    assert values.max() >= high / idle, (high, values.max())


def pads(*numbers):
    for model, ends in ((GAP, numbers[:2]), (INSULATOR, numbers[2:])):
        in_range(*ends, [of_law(model, standing).off for _, standing in left_out()])


def closest(low, high):
    """Of the laws that more than one of the groups judges."""
    tried = left_out(every_law=True)
    in_range(low, high, [min(each.off for each in standing if each.groups > 1) for _, standing in tried])


def best_odds():
    expected = {"Northwestern (Colgate and Peshkin)": CAUSAL, "Vezzoli, Amberg and Giraud (Lille)": INSULATOR}
    for out, standing in left_out(every_law=True):
        assert standing[0].model == expected.get(out, GAP), out


def beaten(least):
    """Whichever group is left out, of all measurements."""
    beaten_by = [set(of_law(MEDIUM, standing).beaten_by) for _, standing in left_out()]
    assert min(map(len, beaten_by)) == least
    assert set.intersection(*beaten_by) == {GAP, CAUSAL}


def beaten_with_all_groups(most):
    """Without the ratio of thresholds fewer beat it."""
    for out, standing in left_out():
        beaten_by = of_law(MEDIUM, standing).beaten_by
        assert len(beaten_by) == most or out, beaten_by
        assert len(beaten_by) < most or not out.startswith("Koc"), beaten_by
    assert [name for name, each in FORCES.items() if each.group.startswith("Koc")] == [
        "vardar_2017/alike_at_60Hz"
    ]


def failed(low, high, *rest):
    in_range(low, high, [len(found.failures) for found in runs()])


def undecided():
    """One group turns the odds of the gap against the insulator."""
    groups, signs = sorted({each.group for each in FORCES.values()}), set()
    for found in runs():
        scores = {(each.model, each.measurement): each for each in found.judging("force")}
        for out in groups:
            gap, insulator = (
                {name: each for (model, name), each in scores.items() if model == law and each.group != out}
                for law in (GAP, INSULATOR)
            )
            signs.add(log_odds(gap, insulator) > 0)
    assert signs == {True, False}


def wide(factor):
    """Of the predictions of forces that contain every value, the narrowest, the median over the points."""
    widths = [
        np.median(each.band[-1] / each.band[0])
        for found in runs()
        for each in found.judging("force")
        if each.covered == 1
    ]
    assert factor <= min(widths) <= 1.6 * factor


def forces_of_a_person(expected):
    assert expected == sum(each.on == "finger" and each.unit == "N" for each in FORCES.values())


def counted(total, measured, numbers, groups):
    assert (measured, numbers, groups) == count(FORCES)
    assert total == len(MEASURED)


def few(laws, all_laws, numbers, groups):
    names = tried_by_all()
    assert (numbers, groups) == count(names)[1:]
    of_model = {}
    for each in runs()[0].judging("force"):
        of_model.setdefault(each.model, set()).add(each.measurement)
    assert all_laws == len(of_model)
    assert laws == sum(found <= names.keys() for found in of_model.values())


def of_the_script(numbers):
    quoted = [each for each in FORCES.values() if each.how == QUOTED and "script of figure 1" in each.source]
    assert numbers == sum(len(each.values) for each in quoted)


def swing(*ends):
    for place, law in enumerate((CAUSAL, GAP, MEDIUM)):
        scores = [each for found in runs() for each in found.of("vezzoli_2014/swing") if each.model == law]
        in_range(*ends[2 * place : 2 * place + 2], [each.ratio for each in scores])


@functools.cache
def further_draws():
    """Return 400 draws of the change of the lateral force, by law [N]."""
    return {each.model: each.values for each in predict(MEASURED["vezzoli_2014/swing"], n=400, seed=11)[0]}


def reached(laws, all_laws):
    found = {law for law, each in further_draws().items() if each.min() <= 5e-3 and each.max() >= 2e-3}
    assert found == {CAUSAL, GAP}
    assert (laws, all_laws) == (2, len(further_draws()))


def as_small_as_measured(share):
    assert 100 * np.mean(further_draws()[GAP] <= 5e-3) == pytest.approx(share, abs=3)


def clutch(low, high):
    scores = [each for found in runs() for each in found.scores if each.model == GAP]
    in_range(
        low,
        high,
        [1 / each.ratio for each in scores if re.match(r"rauf_2025/(voltage|freq)", each.measurement)],
    )
    for found in runs():
        surfaces = {each.model: each for each in standings(found.judging("contact.surface"))}
        assert min(surfaces["PerssonSurface"].shape, surfaces["BearingArea"].shape) > 0
        assert surfaces["LinearSpring"].shape < 0


def over_the_heights(height, low, high):
    """The law of rough gaps with the roughness that the authors fit, which the measurement does not declare."""
    assert height == 2.8
    gaps = {"force.mean_gap": (3.9e-6, 8.4e-6), "force.rms_gap": (2.6e-6, 2.9e-6)}
    fitted = {"model": "LogUniform", "choice": "of the fit"}
    own = {
        "stack.gap": None,
        **{path: fitted | {"low": least, "high": most} for path, (least, most) in gaps.items()},
    }
    tried = {"clutch": replace(MEASURED["rauf_2025/voltage"], of_model={ROUGH: own})}
    scores = [each for seed in SEEDS for each in ev.evidence(tried, n=12, seed=seed).scores]
    in_range(low, high, [each.ratio for each in scores if each.model == ROUGH])


def pen(low, high):
    in_range(low, high, [13 * found.of("israr_2006/pen_slope")[0].ratio for found in runs()])


CLAIMS = [
    (
        README,
        r"N of N published measurements judge them: N numbers of N groups",
        lambda a, b, c, d: counted(b, a, c, d),
    ),
    (README, r"N of N laws meet only N numbers of N groups", few),
    (README, r"the closest misses by a typical factor of N to N,", closest),
    (README, r"which has the best odds changes with one group less", best_odds),
    (README, r"has odds of 20 against it from at least N\.", beaten),
    (README, r"N to N of the N, by the draws, are reached whole by no model", failed),
    (
        LANDING,
        r"N published laws and N measurements on fingers\..*? N rows are forces on a person's finger",
        lambda _, a, b: picture(a, b),
    ),
    (
        PAPER,
        r"N published measurements, N numbers of N groups",
        lambda *numbers: same(numbers, count(MEASURED)),
    ),
    (
        PAPER,
        r"N measurements, N numbers of N groups, judge force laws",
        lambda *numbers: same(numbers, count(FORCES)),
    ),
    (PAPER, r"N numbers of N groups judge N of the N laws", lambda a, b, c, d: few(c, d, a, b)),
    (PAPER, r"the closest law misses by a typical factor of N to N,", closest),
    (PAPER, r"the best odds change with one group less", best_odds),
    (PAPER, r"has odds of 20 or more against it from N rivals at least", beaten),
    (PAPER, r"N to N measurements are reached whole by no model", failed),
    (PAPER, r"N of N laws reach the measured 2 to 5 mN of lateral force in some draws", reached),
    (
        DIFFER,
        r"N of its N measurements judge the force laws: N numbers of N groups",
        lambda a, b, c, d: counted(b, a, c, d),
    ),
    (DIFFER, r"one script that quotes others gives N,", of_the_script),
    (DIFFER, r"misses by a typical factor of N to N, that in the insulator by one of N to N;", pads),
    (DIFFER, r"the other N laws need a skin", lambda laws: few(laws, 7, 7, 3)),
    (DIFFER, r"tried on N numbers of N groups alone", lambda *numbers: few(5, 7, *numbers)),
    (DIFFER, r"N of them forces on a person's finger", forces_of_a_person),
    (
        DIFFER,
        r"the stress in the gap has the best odds; without that of Northwestern .*? insulator\.",
        best_odds,
    ),
    (DIFFER, r"With all N groups", lambda groups: same([groups], [3])),
    (DIFFER, r"closest law misses by a typical factor of N to N,", closest),
    (DIFFER, r"every interval that contains what was measured spans a factor of N or more", wide),
    (DIFFER, r"has odds of 20 against it from N laws at least", beaten),
    (DIFFER, r"from N only with one ratio of thresholds", beaten_with_all_groups),
    (DIFFER, r"the odds turn when one group is left out", undecided),
    (UNKNOWN, r"shear force is N to N times that of one gap", clutch),
    (UNKNOWN, r"N um as the authors fit them, the stress comes to N to N of the force", over_the_heights),
    (UNKNOWN, r"N of N laws reach the measured 2 to 5 mN", reached),
    (UNKNOWN, r"which is that small in N % of the draws", as_small_as_measured),
    (
        UNKNOWN,
        r"whose median is N to N times as large, .*? median is N to N times .*? medium is N to N times",
        swing,
    ),
    (UNKNOWN, r"falls by N to N dB per octave", pen),
]
"""Page, sentence with N for each number, and what holds: called with the evidence of every set of draws and the numbers."""


def same(numbers, expected):
    assert tuple(numbers) == tuple(expected)


def picture(rows, forces):
    forces_of_a_person(forces)
    assert rows == len(tried_by_all())


def matched(page, sentence):
    """Return the only place of a sentence."""
    pattern = re.sub(r"\bN\b", lambda _: NUMBER, sentence)
    found = list(re.finditer(pattern, " ".join(text_of(page).split()), re.IGNORECASE))
    assert len(found) == 1, (page, sentence)
    return found[0]


@pytest.mark.parametrize("page", PASSAGES)
def test_every_number_of_a_passage_on_the_evidence_is_a_claim(page):
    (passage,) = re.findall(PASSAGES[page], text_of(page), re.DOTALL)
    rest = " ".join(TABLE.sub("", passage).split())
    for own, sentence, _ in CLAIMS:
        if own == page:
            rest = rest.replace(matched(page, sentence)[0], "")
    rest = re.sub(r"\[[^]]*\]\([^)]*\)|`[^`]*`|90 %|odds of 20|et al\. 2014|pin 2 mm", "", rest)
    assert not re.findall(rf"\b{NUMBER}\b", rest), rest


@pytest.mark.slow
def test_what_is_concluded_from_the_evidence_holds_in_every_set_of_draws_and_without_any_one_group():
    """Every claim, and the table of the laws; all that is wrong is named at once."""
    wrong = []
    for page, sentence, holds in CLAIMS:
        try:
            holds(*map(number, matched(page, sentence).groups()))
        except AssertionError as error:
            wrong.append(f"{page}: {sentence}: {error}")
    assert not wrong, "\n".join(wrong)
    table = TABLE.search(text_of(DIFFER))[1]
    rows = {
        cells[0]: cells[1:] for cells in (line.strip("| ").split(" | ") for line in table.splitlines()[2:])
    }
    cases = left_out(every_law=True)
    found = {law: [(out, one) for out, standing in cases if (one := of_law(law, standing))] for law in rows}
    assert rows.keys() == {each.model for each in runs()[0].judging("force")}
    for law, (alone, without, covered, beaten_by) in rows.items():
        numbers = [
            list(map(float, re.findall(r"[\d.]+", cell))) for cell in (alone, without, covered, beaten_by)
        ]
        in_range(*numbers[0], [each.off for out, each in found[law] if not out], idle=2.2)
        if numbers[1]:
            in_range(*numbers[1], [each.off for _, each in found[law]], idle=2.2)
        in_range(numbers[2][0], numbers[2][-1], [100 * each.covered for _, each in found[law]], idle=3)
        counts = [len(each.beaten_by) for _, each in found[law]]
        assert (min(counts), max(counts)) == (numbers[3][0], numbers[3][-1]), law
