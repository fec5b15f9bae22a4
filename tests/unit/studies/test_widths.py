"""Widths of answers about people at every door: which are named, which are not included and why, and where they are recorded."""

import json
import math

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.explorer.computed import FREQUENCY, Further, compute, slices
from electrovib.apps.explorer.page.plots import answer_words, law_words
from electrovib.studies import widths
from electrovib.studies.population.answer import study_document
from electrovib.studies.widths import Width

SINE, VOLTS = "bau_2010/sine", "drive.amplitude"
LEVEL = "detection level = 0 dB"


def by_name(found):
    return {each.name: each for each in found.widths}


def test_a_level_of_one_finger_is_designed_at_the_ends_of_the_thresholds_and_of_the_law():
    found = ev.find_value(SINE, want=LEVEL, free=VOLTS)
    names = by_name(found)
    percept = ev.perceive(SINE, set={VOLTS: found.value})
    ends = [found.value * 10 ** (sign * percept.uncertainty / 40) for sign in (-1, 1)]
    assert names[widths.THRESHOLDS].interval == pytest.approx(ends, rel=1e-6)
    root = math.sqrt(widths.TYPICAL_FACTORS["MaxwellStressInGap"])
    assert names[widths.LAW].interval == pytest.approx((found.value / root, found.value * root), rel=1e-6)
    assert names[widths.TOGETHER].interval == pytest.approx((ends[0] / root, ends[1] * root), rel=1e-6)
    assert [each.name for each in found.widths if each.interval is None] == [widths.SAMPLING, widths.PEOPLE]
    levels = ["lowest detection level", "highest detection level"]
    at_ends = ev.sweep(SINE, {VOLTS: ends[::-1]}, quantity=[*levels, "mean electrostatic_force"])
    for place, name in enumerate(levels):  # 40 dB for ten times the voltage: 1e-6 of it
        assert float(at_ends[name][place]) == pytest.approx(0, abs=1.7e-5)


@pytest.mark.slow
def test_a_value_that_falls_with_the_quantity_and_an_end_outside_the_range():
    thickness = "stack.gap.thickness"
    found = ev.find_value(SINE, want=LEVEL, free=f"{thickness} = 100 nm:1 mm", set={VOLTS: 20.0})
    low, high = by_name(found)[widths.THRESHOLDS].interval
    assert low < found.value < high
    for at, sign in ((low, -1), (high, 1)):
        percept = ev.perceive(SINE, set={VOLTS: 20.0, thickness: at})
        assert percept.sensation + sign * percept.uncertainty == pytest.approx(0.0, abs=1e-4)
    near = ev.find_value(SINE, want=LEVEL, free={thickness: (found.value / 1.2, 1e-3)}, set={VOLTS: 20.0})
    low, high = by_name(near)[widths.THRESHOLDS].interval
    assert math.isnan(low)
    assert high == pytest.approx(by_name(found)[widths.THRESHOLDS].interval[1], rel=1e-5)
    assert "no value in the range to " in by_name(near)[widths.THRESHOLDS].sentence
    kept = json.loads(json.dumps(near.to_dict(), allow_nan=False))["widths"]
    assert next(each for each in kept if each["name"] == widths.THRESHOLDS)["interval"][0] is None


def test_a_threshold_and_a_skin_of_ones_own_leave_their_uncertainty():
    own = {
        "threshold": 1e-7,
        "threshold_uncertainty": 6.0,
        "compliance": {"model": "ElasticSkin", "stiffness": 400.0},
    }
    found = ev.perceive(SINE, set={"perception": own})
    low, high = by_name(found)[widths.THRESHOLDS].interval
    assert (low, high) == pytest.approx([found.sensation + each for each in (-6, 6)], abs=1e-6)
    assert "the uncertainty of perception.threshold, common" in by_name(found)[widths.THRESHOLDS].sentence


@pytest.mark.parametrize(
    ("changes", "quantity", "factor"),
    [
        ({}, "detection level", 11.0),
        ({}, "swing lateral_force", 11.0),
        ({}, "mean electrostatic_force", 11.0),
        ({}, "electrostatic_force at 2 ms", 11.0),
        ({"force": {"model": "EffectiveMedium"}}, "mean_force", 14.0),
        ({}, "relative level", None),
        ({}, "peak lateral_force", None),
        ({}, "peak current", None),
        (
            {"friction": {"model": "PowerLaw", "coefficient": 0.5, "exponent": 0.8, "at_force": 0.5}},
            "detection level",
            None,
        ),
    ],
)
def test_the_factor_of_a_law_stands_where_the_quantity_is_proportional_to_the_attraction(
    changes, quantity, factor
):
    assert widths.factor_of(ev.load(SINE, changes=changes), quantity) == factor


def test_a_quantity_that_no_law_scales_says_that_this_is_not_included():
    found = ev.value_for_share(
        SINE, want="peak lateral_force = 0.4 N", free=VOLTS, space="fingers", share=0.5, seed=1, n=20
    )
    (law,) = (each for each in found.widths if each.name == widths.LAW)
    assert law.interval is None
    assert law.sentence.startswith(
        "Not included: force law: no measured force says how far MaxwellStressInGap is off here"
    )
    assert all(any(each.sentence in line for line in found.document.sentences) for each in found.widths)
    assert by_name(found)[widths.SAMPLING].interval
    assert widths.TOGETHER not in by_name(found)


def test_a_value_that_is_not_about_people_has_no_widths():
    assert ev.find_value(SINE, want="mean electrostatic_force = 1 mN", free=VOLTS).widths == ()


def test_a_share_that_is_not_reached_says_at_which_threshold_it_would_be():
    asked = {"want": LEVEL, "free": f"{VOLTS} = 0.1 V:2 V", "space": "fingers", "share": 0.9, "seed": 1}
    found = ev.value_for_share(SINE, **asked, n=20)
    assert found.found is None
    low, high = by_name(found)[widths.THRESHOLDS].interval
    assert low < 2.0
    assert math.isnan(high)
    assert {each.sentence for each in found.widths} <= set(found.document.sentences)
    assert {widths.SAMPLING, widths.LAW, widths.TOGETHER} <= {*by_name(found)}


def test_a_study_states_its_widths_in_words_record_and_table(tmp_path):
    found = ev.study(SINE, "fingers", n=100, seed=1, output=tmp_path / "s.zarr", exceed="500 mN")
    assert found["electrostatic_force_percentile_interval"].dims == ("percentile", "end", "time")
    lines = study_document(found).text.splitlines()
    for words in (
        "Width by sampling, 95 % intervals for 100 fingers: 5th percentile",
        "Width by force law, 1/11 to 11 times the force",
        "Not included: thresholds of perception",
    ):
        assert sum(line.startswith(words) for line in lines) == 1, words
    share = float(found["electrostatic_force_exceedance_anywhere"][0])
    low, high = widths.clopper_pearson(round(100 * share), 100)
    assert any(
        f"(95 % interval for 100 fingers: {100 * low:.3g} to {100 * high:.3g} %)" in line for line in lines
    )
    assert [each["name"] for each in found.attrs["widths"]] == [widths.LAW, widths.THRESHOLDS]
    kept = ev.open_study(tmp_path / "s.zarr")
    assert kept.attrs["widths"] == found.attrs["widths"]
    (path,) = ev.save(found, tmp_path / "s.csv")
    assert "width by force law" in path.read_text()
    few = ev.study(SINE, "fingers", n=5, seed=1)
    assert "no bound (too few draws)" in study_document(few).text


def test_compare_says_how_far_the_law_it_believes_is_off_on_fingers():
    found = ev.compare(SINE)
    assert [each.name for each in found.widths] == [widths.LAW, widths.SAMPLING, widths.THRESHOLDS]
    for each in found.widths:
        assert each.sentence in repr(found)
    assert found.tables[0].headings[-1] == "measured forces missed by"
    assert {row[0]: row[-1] for row in found.tables[0].rows}["EffectiveMedium"] == "14 times"
    alone = ev.compare(SINE, models=["EffectiveMedium"])
    assert [each.name for each in alone.widths] == [widths.SAMPLING, widths.THRESHOLDS]


def test_what_is_felt_has_the_law_and_both_together_and_a_measurement_has_no_law():
    found = ev.perceive(SINE)
    more, names = 20 * math.log10(11.0), by_name(found)
    middle, half = found.sensation, found.uncertainty
    assert names[widths.THRESHOLDS].interval == pytest.approx((middle - half, middle + half))
    assert names[widths.LAW].interval == pytest.approx((middle - more, middle + more))
    assert names[widths.TOGETHER].interval == pytest.approx((middle - half - more, middle + half + more))
    assert found.to_dict()["widths"][1]["interval"] == list(names[widths.LAW].interval)
    measured = ev.simulate(SINE, time=np.arange(4096) * 1e-4)
    measured.attrs = {name: each for name, each in measured.attrs.items() if name not in {"scenario", "over"}}
    assert [each.name for each in ev.perceive(measured).widths] == [
        widths.THRESHOLDS,
        widths.SAMPLING,
        widths.PEOPLE,
    ]


def test_the_page_names_the_widths_beside_the_band_the_laws_and_what_is_felt():
    run = compute(ev.load(SINE))
    known = Further()
    for each in slices(FREQUENCY, run):
        known = each(known)
    assert known.population is not None
    drawn = " ".join(answer_words(known.population))
    assert "Width by force law, 1/11 to 11 times the force" in drawn
    assert "Not included: thresholds of perception" in drawn
    assert "11 times" in law_words(run, Further())
    said = " ".join(answer_words(ev.perceive(SINE).document))
    assert "Width by force law" in said
    assert "Not included: differences of the threshold between people" in said


def test_a_law_that_was_never_compared_is_not_given_a_factor():
    found = widths.law_width("MyOwnLaw", None)
    assert found == Width(name=widths.LAW, text=found.text)
    assert "no measured force says how far MyOwnLaw is off" in found.sentence
    assert widths.missed_by("MyOwnLaw") == "not compared"
