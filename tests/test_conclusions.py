"""What README, guides and paper conclude from the evidence holds in every set of draws."""

import functools
import re
from pathlib import Path

import numpy as np
import pytest

import electrovib as ev
from electrovib.studies.evidence.measurement import QUOTED, numbers_of
from electrovib.studies.evidence.predicted import predict

ROOT = Path(__file__).parent.parent
README, LANDING, PAPER = "README.md", "docs/index.md", "paper/paper.md"
DIFFER, UNKNOWN = "docs/explanation/2_why_forces_differ.md", "docs/explanation/4_unknowns.md"
SEEDS = range(2)
GAP, INSULATOR, CAUSAL = "MaxwellStressInGap", "MaxwellStressInInsulator", "Vezzoli2014Causal"
MEDIUM, ROUGH = "EffectiveMedium", "Persson2018RoughGap"
PASSAGES = {
    README: r"\*\*The laws\.\*\*.*?(?=\n- )",
    PAPER: r"\*\*Laws beside what was measured\.\*\*.*?(?=\n\n)",
    DIFFER: r"(?<=## What measurements say\n).*?(?=\n## )",
    UNKNOWN: r"On a clutch with a metal pin.*?(?=\n\n)",
}
"""Passages all of whose numbers are conclusions."""
WORDS = {"two": 2, "three": 3, "four": 4, "five": 5, "six": 6, "seven": 7, "eight": 8, "eleven": 11}
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
    numbers = {key for name, each in known.items() for key in numbers_of(name, each)}
    return len(known), len(numbers), len({each.group for each in known.values()})


@functools.cache
def runs():
    """Return the evidence of every set of draws."""
    return [ev.evidence(seed=seed) for seed in SEEDS]


def of_force(found):
    """Return the comparisons of force laws, the most laws first."""
    return [each for each in found.comparisons if each.place == "force"]


def of_six(found):
    """Return the comparison of the laws that meet on whole fingers; a seventh has numbers of two groups alone."""
    (six,) = (each for each in of_force(found) if len(each.standings) == 6)
    return six


def in_range(low, high, values, *, idle=1.6):
    """Values lie in a printed range, to its rounding, which is not much wider than they are (`idle`, a factor)."""
    values = np.array(values)
    assert low * 0.95 <= values.min(), (low, values.min())
    assert values.max() <= high * 1.05, (high, values.max())
    assert values.min() <= low * idle, (low, values.min())
    assert values.max() >= high / idle, (high, values.max())


def no_skill():
    """Of no law, on no common set, in no set of draws; this is the sentence of the answer too."""
    for found in runs():
        for each in of_force(found):
            assert not any(one.has_skill for one in each.standings)
        assert not any("skill over" in text and "no skill" not in text for text in found.document.sentences)


def below_the_null():
    """The skill itself, with the stated ranges and with others, on sets of more than two groups."""
    for found in runs():
        for each in (one for one in of_force(found) if one.groups > 2):
            for one in each.standings:
                assert max(one.skill, one.narrow, one.wide) < 0, (each.names, one)


def ranks(first):
    for found in runs():
        standings = of_six(found).standings
        assert sum(each.first == 1 for each in standings) >= first


def medium_is_last(laws):
    """Of all groups; with one less it is third at best."""
    for found in runs():
        standings = of_six(found).standings
        assert standings[-1].model == MEDIUM
        assert (standings[-1].first, standings[-1].last, len(standings)) == (3, laws, laws)


def square_of_the_voltage():
    for found in runs():
        assert {each.null for each in of_force(found)} == {"a constant times V^2"}


def common(two, three, six, groups, seven, fewer):
    sets = {len(each.standings): (each.numbers, each.groups) for each in of_force(runs()[0])}
    assert len(sets) == 4
    assert sets[2][0] == two
    assert sets[3][0] == three
    assert sets[6] == (six, groups)
    assert sets[7] == (seven, fewer)
    assert two == count(FORCES)[1]


def counted(total, measured, numbers, groups):
    assert (measured, numbers, groups) == count(FORCES)
    assert total == len(MEASURED)


def meet(laws, numbers, groups):
    first = of_six(runs()[0])
    assert (laws, numbers, groups) == (len(first.standings), first.numbers, first.groups)


def missed(numbers, of):
    """In the first set of draws; another one moves it by a few."""
    assert of == count(FORCES)[1]
    for found in runs():
        forces = [each for each in found.judging("force") if each.width < 1]
        known = {key for each in forces for key in each.numbers}
        assert len(known) == pytest.approx(numbers, abs=3)
        assert sum(key[0].startswith("rauf_2025/") for key in known) > len(known) / 2


def decide_nothing(number, of):
    assert of == len(FORCES)
    for found in runs():
        assert len(FORCES.keys() & {*found.decides_nothing}) == pytest.approx(number, abs=1)


def failed(number, total):
    assert total == len(MEASURED)
    for found in runs():
        assert len(found.failures) == pytest.approx(number, abs=1)


def wide(factor):
    """Of the predictions of forces in newtons that contain every value, the narrowest, the median over the points."""
    widths = [
        10**each.width
        for found in runs()
        for each in found.judging("force")
        if each.covered == 1 and not FORCES[each.measurement].bound and FORCES[each.measurement].unit != "1"
    ]
    assert factor <= min(widths) <= 1.6 * factor


def forces_of_a_person(expected):
    assert expected == sum(each.on == "finger" and each.unit == "N" for each in FORCES.values())


def of_the_script(numbers):
    quoted = {
        name: each
        for name, each in FORCES.items()
        if each.how == QUOTED and "script of figure 1" in each.source
    }
    assert numbers == count(quoted)[1]
    assert sum(bool(each.bound) for each in quoted.values()) > len(quoted) / 2


def swing(*ends):
    for place, law in enumerate((CAUSAL, GAP, MEDIUM)):
        scores = [each for found in runs() for each in found.of("vezzoli_2014/swing") if each.model == law]
        in_range(*ends[2 * place : 2 * place + 2], [each.ratio for each in scores])


@functools.cache
def further_draws():
    """Return 200 draws of the change of the lateral force, by law [N]."""
    return {each.model: each.values for each in predict(MEASURED["vezzoli_2014/swing"], n=200, seed=11)[0]}


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
        (each,) = (each for each in found.comparisons if each.place == "contact.surface")
        shapes = {one.model: one.shape for one in each.standings}
        assert min(shapes["PerssonSurface"], shapes["BearingArea"]) > 0
        assert shapes["LinearSpring"] < 0


def over_the_heights(height, low, high):
    """The law of rough gaps with the roughness that the authors fit."""
    assert height == 2.8
    names = {"rauf_2025/voltage", "rauf_2025/width"}
    scores = [each for found in runs() for each in found.scores if each.measurement in names]
    in_range(low, high, [each.ratio for each in scores if each.model == ROUGH])


def pen(low, high):
    in_range(low, high, [13 * found.of("israr_2006/pen_slope")[0].ratio for found in runs()])


COUNTS = (
    r"N of N published measurements judge them: N numbers of N groups",
    lambda a, b, c, d: counted(b, a, c, d),
)
CLAIMS = [
    (README, r"None has been shown to predict a force better", no_skill),
    (README, *COUNTS),
    (README, r"N laws meet on N numbers of N groups alone", meet),
    (README, r"A law can miss N of the N, where", missed),
    (README, r"N of the N are covered by every law", decide_nothing),
    (README, r"N of the N are reached whole by no model", failed),
    (LANDING, r"no force law has been shown to predict better than a model without physics", no_skill),
    (
        LANDING,
        r"N published laws, the best null model and N measurements on fingers\..*? N rows are forces on a person's finger",
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
    (PAPER, r"N laws meet on N numbers of N groups", meet),
    (PAPER, r"No force law has skill, on any common set of measurements", no_skill),
    (PAPER, r"N of the N are covered by every law and decide nothing", decide_nothing),
    (PAPER, r"N measurements are reached whole by no model", lambda number: failed(number, len(MEASURED))),
    (PAPER, r"N of N laws reach the measured 2 to 5 mN of lateral force in some draws", reached),
    (
        DIFFER,
        r"N of its N measurements judge the force laws: N numbers of N groups",
        lambda a, b, c, d: counted(b, a, c, d),
    ),
    (DIFFER, r"one script that quotes others gives N, most of them bounds", of_the_script),
    (
        DIFFER,
        r"N laws meet on all of them, N on N numbers, N on N numbers of N groups, N on N numbers of N groups alone",
        lambda two, three, b, six, c, d, seven, e, f: (
            same((two, three, six, seven), (2, 3, 6, 7)),
            common(count(FORCES)[1], b, c, d, e, f),
        ),
    ),
    (DIFFER, r"N are forces on a person's finger", forces_of_a_person),
    (DIFFER, r"best null model, which is a constant times V\^2", square_of_the_voltage),
    (DIFFER, r"No law has skill: on no common set", no_skill),
    (
        DIFFER,
        r"on those of more than two groups the skill itself is below 0 for all of them, also with every range of what is not"
        r" printed half or twice as wide",
        below_the_null,
    ),
    (DIFFER, r"with one group less N laws at least come first", ranks),
    (DIFFER, r"is the last of the N, and third at best with one group less", medium_is_last),
    (DIFFER, r"N of the N measurements are covered by every law", decide_nothing),
    (DIFFER, r"contains a measured force spans a factor of N or more", wide),
    (DIFFER, r"N of the N numbers are such that a law can miss them, most of them of one clutch", missed),
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
    """Rows of forces on fingers, one of them an artificial one."""
    forces_of_a_person(forces)
    assert rows == sum("finger" in each.on for each in FORCES.values())


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
    rest = re.sub(
        r"\[[^]]*\]\([^)]*\)|`[^`]*`|90 %|best null model|above 0|below 0|one group less|one clutch|come first|"
        r"et al\. 2014|pin 2 mm",
        "",
        rest,
    )
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
    rows = [tuple(line.strip("| ").split(" | ")) for line in table.splitlines()[2:]]
    assert rows == [
        (
            each.model,
            f"{each.skill:.2f}",
            f"{each.low:.2f} to {each.high:.2f}",
            f"{each.least:.2f} to {each.most:.2f}",
            f"{each.first} to {each.last}",
            f"{each.narrow:.2f}, {each.wide:.2f}",
            f"{each.width:.1f}",
        )
        for each in of_six(runs()[0]).standings
    ]
