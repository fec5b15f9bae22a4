"""Comparison of force laws."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

from electrovib.core.discovery import find_members, papers
from electrovib.core.errors import InputError
from electrovib.physics.force import ForceLaw
from electrovib.scenario import load
from electrovib.study import catalogue
from electrovib.study.compare import compare
from electrovib.study.compare.static import static_force
from electrovib.study.explain import explain


@pytest.fixture(scope="module")
def leaky():
    return compare(load("vezzoli_2014/fig6_gap"), over={"stack.gap.thickness": np.geomspace(1e-7, 1e-4, 3)})


def test_every_law_is_compared_or_says_why_not(leaky):
    assert {entry.name for entry in leaky.entries} | set(leaky.left_out) == set(find_members(ForceLaw))


def test_entries_are_ordered_and_explained(leaky):
    forces = [entry.static for entry in leaky.entries]
    assert forces == sorted(forces, reverse=True)
    why = {entry.name: entry.why for entry in leaky.entries}
    assert "permittivity 1560" in why["MaxwellStressInStratumCorneum"]
    assert "effective permittivity 10.74" in why["EffectiveMedium"]
    assert "rises" in why["MaxwellStressInInsulator"]
    assert "falls" in why["MaxwellStressInGap"]
    assert not any("further terms" in entry.why for entry in leaky.entries)


def test_the_answer_names_the_law_to_believe_and_why(leaky, coating):
    assert leaky.answer == (
        "Believe MaxwellStressInGap here, 564.9 mN at 1 kV: plate and finger separate only in the gap, so the stress there is"
        " the force between them; the other laws give 0.000641 to 0.299 of it."
    )
    assert (
        "31.05 N at 100 V (beyond breakdown of the air, so no force that would be measured)" in coating.answer
    )
    film = compare(load("vezzoli_2014/fig6"), models=["MaxwellStressInGap"])
    assert "(an upper limit: the stack has no gap, and any gap lowers it)" in film.answer
    assert "other laws" not in film.answer
    without = compare(load("vezzoli_2014/fig6"), models=["EffectiveMedium"])
    assert without.answer.startswith("None of these laws evaluates the stress in the gap")


def test_the_rough_gap_comes_before_the_smooth_one():
    rough = {"force": {"model": "Persson2018RoughGap", "mean_gap": 10e-6, "rms_gap": 5e-6}}
    found = compare(
        load("vezzoli_2014/fig6").replace(rough), models=["MaxwellStressInGap", "Persson2018RoughGap"]
    )
    assert found.answer.startswith("Believe Persson2018RoughGap here")


def test_planes_differ_in_time_as_well_as_in_size(leaky):
    change = {entry.name: entry.late / entry.early for entry in leaky.entries if len(entry.step)}
    assert change["EffectiveMedium"] == pytest.approx(1.0, abs=1e-2)
    assert change["MaxwellStressInGap"] < 1e-4
    assert change["MaxwellStressInInsulator"] > 1.05


def test_a_law_of_magnitudes_has_a_static_force_but_no_step(leaky):
    found = {entry.name: entry for entry in leaky.entries}
    literal = found["Vezzoli2014PerFrequency"]
    assert len(literal.step) == 0
    assert literal.static == pytest.approx(found["Vezzoli2014Causal"].static, rel=1e-9)


def test_defects_of_vezzoli_2014_are_listed(leaky):
    text = " ".join(paragraph for page in leaky.pages for paragraph in page.paragraphs)
    for word in ("10.74", "1.0096", "falling edges", "responds before the pulse"):
        assert word in text


def test_defects_of_the_papers_compared_come_first(leaky):
    titles = [page.title for page in leaky.pages]
    assert titles[1] == "Where the papers of these laws contradict themselves or others"
    assert all(text.startswith(("Vezzoli 2014", "Persson")) for text in leaky.pages[1].paragraphs)
    others = " ".join(leaky.pages[2].paragraphs)
    for word in ("250 Hz is a fit of the leak", "rho_g > eps_d rho_d", "positive pulses"):
        assert word in others


def test_the_static_force_is_drawn_over_a_parameter(leaky):
    panel = leaky.panels[-1]
    assert panel.x == ("stack.gap.thickness", "m")
    assert all(len(curve.x) == 3 for curve in panel.curves)


def test_an_unknown_law_is_refused_with_the_nearest_name():
    with pytest.raises(InputError, match="Did you mean 'MaxwellStressInGap'"):
        compare(load("vezzoli_2014/fig6"), models=["MaxwellStressInGp"])


COATING = {
    "stack.insulator.thickness": 1e-6,
    "stack.insulator.material.permittivity": 3.9,
    "stack.stratum_corneum.material.permittivity": 1650.0,
    "drive": {"model": "Step", "level": 100.0},
}


@pytest.fixture(scope="module")
def coating():
    """31 N on 1 cm2: 265 MV/m in a gap that is no layer of the stack."""
    return compare(load("vezzoli_2014/fig6").replace(COATING), over={"drive.level": np.array([10.0, 100.0])})


def test_an_entry_beyond_breakdown_carries_its_diagnostic(coating):
    broken = {entry.name: entry.breakdown for entry in coating.entries}
    assert "265 MV/m" in broken.pop("MaxwellStressInGap")
    assert not any(broken.values())
    rows = {row[0]: row for row in coating.tables[0].rows}
    assert "(beyond breakdown)" in rows["MaxwellStressInGap"][3]
    assert "(beyond breakdown)" not in rows["MaxwellStressInInsulator"][3]
    told = {what: law for law, what in coating.tables[1].rows}
    assert (
        next(law for what, law in told.items() if "static: the field of a vanishing gap" in what)
        == "MaxwellStressInGap"
    )
    assert not any(
        "across 'stratum_corneum'" in what for what in told
    )  # which holds for the scenario, whatever its law
    assert any("across 'stratum_corneum'" in each.text for each in coating.diagnostics)


def test_diagnostics_of_a_law_without_a_response_in_time_are_those_of_the_stack(coating):
    found = {entry.name: entry for entry in coating.entries}
    assert found["Vezzoli2014PerFrequency"].warnings == found["MaxwellStressInStratumCorneum"].warnings != ()


def test_air_that_breaks_down_is_marked_in_the_figure(coating):
    marks = [curve for curve in coating.panels[-1].curves if curve.kind == "points"]
    assert [(curve.label, list(curve.x)) for curve in marks] == [
        ("MaxwellStressInGap: air breaks down", [100.0])
    ]


def test_a_law_pulls_as_the_gap_plane_at_some_gap(coating):
    """Each law equals V^2/(K + g)^2 at some gap g: 8 and 15 um on the coating."""
    why = {entry.name: entry.why for entry in coating.entries}
    electrical = 1e-6 / 3.9 + 200e-6 / 1650
    for name, ratio in (
        ("EffectiveMedium", electrical / 201e-6),
        ("MaxwellStressInStratumCorneum", 1 / 1650),
    ):
        gap = electrical * (1 / math.sqrt(ratio) - 1)
        assert f"Maxwell stress in the gap at a gap of {1e6 * gap:.2g} um" in why[name]


def test_leak_time_and_polarity_are_told(coating, leaky):
    said = coating.pages[0].paragraphs
    assert any("no gap that could leak" in text for text in said)
    assert any("from 18.66 mN to" in text for text in said)
    assert any("No law can show an effect of polarity" in text for text in said)
    assert any("The gap leaks" in text for text in leaky.pages[0].paragraphs)
    assert "this law counts charge that has crossed as lost" in " ".join(said)


def test_a_rectifying_layer_shows_polarity():
    found = compare(load("kaczmarek_2006/skin_positive"))
    polarity = {entry.name: entry.polarity for entry in found.entries}
    # the skin's own voltage decays 7.7/2.5 times faster in one direction, and so does the integral of its square
    assert polarity["MaxwellStressInStratumCorneum"] == pytest.approx(2.5 / 7.7, rel=2e-2)
    assert polarity["MaxwellStressInGap"] == pytest.approx(1.0, abs=1e-2)
    assert any(
        "The response of a layer depends on the polarity" in text for text in found.pages[0].paragraphs
    )


def test_nothing_that_conducts_keeps_every_force():
    still = {"stack.stratum_corneum.material.conductivity": 0.0}
    found = compare(load("vezzoli_2014/fig6").replace(still), models=["MaxwellStressInGap"])
    text = " ".join(found.pages[0].paragraphs)
    assert "nothing conducts" in text
    assert "differ by a factor" not in text


def test_a_law_looks_the_same_in_every_figure_and_none_hides_another(coating):
    looks = [
        {curve.label: curve.look for curve in panel.curves if curve.kind != "points"}
        for panel in coating.panels
    ]
    for look in looks:
        assert look.items() <= looks[0].items()
    kinds = {curve.label: curve.kind for curve in coating.panels[-1].curves}
    assert [kinds[name] for name in ("EffectiveMedium", "Vezzoli2014Causal", "Vezzoli2014PerFrequency")] == [
        "line", "dashed", "dotted",
    ]  # fmt: skip


def test_a_parameter_of_one_law_moves_no_other():
    scenario = load("persson_2018/coating")
    over = {"force.mean_gap": np.array([5e-6, 20e-6])}
    found = compare(scenario, models=["Persson2018RoughGap", "MaxwellStressInGap"], over=over)
    forces = {curve.label: curve.y for curve in found.panels[-1].curves if curve.kind != "points"}
    assert forces["Persson2018RoughGap"][0] > 2 * forces["Persson2018RoughGap"][1]
    assert forces["MaxwellStressInGap"][0] == forces["MaxwellStressInGap"][1]


def test_laws_that_cannot_run_here_leave_nothing_to_compare():
    with pytest.raises(InputError, match="mean_gap: missing"):
        compare(load("vezzoli_2014/fig6"), models=["Persson2018RoughGap"])
    with pytest.raises(InputError, match="names no force law"):
        compare(load("vezzoli_2014/fig6"), models=[])


def test_catalogue_lists_everything_found_with_status_and_checks():
    listed = {entry.name: entry for entry in catalogue.models()}
    assert set(find_members(ForceLaw)) | set(papers()) <= set(listed)
    assert listed["Vezzoli2014Causal"].paper == "vezzoli_2014"
    assert listed["Vezzoli2014Causal"].status == "full text"
    assert listed["vezzoli_2014"].checks == 3


def test_one_model_can_be_asked_for():
    assert catalogue.models("MaxwellStressInGap")[0].group == "attraction of the finger"
    with pytest.raises(InputError, match="Did you mean 'MaxwellStressInGap'"):
        catalogue.models("MaxwellStressInGp")


@pytest.mark.parametrize("name", list(papers()))
def test_every_paper_says_what_it_claims_and_what_not(name):
    said = catalogue.claims(papers()[name])
    assert said["claims"]
    assert said["does not claim"]


def test_what_is_computed_here_is_not_told_as_what_a_paper_does_not_claim():
    said = catalogue.claims(papers()["nakamura_2017"])
    assert said["does not claim"].endswith("a spring constant.")
    assert said["here"].startswith("The electrics are two leaky layers")


MODELS = {name: kind for family in catalogue.families() for name, kind in find_members(family).items()}


@pytest.mark.parametrize("name", MODELS)
def test_every_parameter_has_a_meaning_and_a_default_or_none_with_its_source(name):
    table = catalogue.parameters(MODELS[name])
    assert table.headings == ("name", "unit", "range", "default", "meaning", "source")
    for _, _, _, default, meaning, source in table.rows:
        assert len(meaning) > 3
        assert default
        assert (source == "no default") == (default == "required")
        assert source


def test_a_default_that_is_no_definition_names_its_source():
    rows = {row[0]: row for row in catalogue.parameters(MODELS["Grounded"]).rows}
    assert "IEEE" in rows["resistance"][-1]
    rows = {row[0]: row for row in catalogue.parameters(MODELS["Persson2018RoughGap"]).rows}
    assert rows["mean_gap"][3:6:2] == ("required", "no default")
    assert rows["spots"][3] == "PullingSpots"


def test_a_paper_shows_its_values_with_their_sources():
    rows = {row[0]: row[1:] for row in catalogue.values(papers()["kim_2015"]).rows}
    assert rows["stack.insulator.thickness"] == ("90 um", "not read; as in vezzoli_2014, section 3.1")
    assert catalogue.values(papers()["ciavarella_2020"]) is None


def test_values_of_one_parameter_with_different_sources_are_told_apart():
    """1 um is a choice for a figure whose film Vezzoli et al. 2014 does not print; 90 um is printed."""
    rows = catalogue.values(papers()["vezzoli_2014"]).rows
    films = [row[1:] for row in rows if row[0] == "stack.insulator.thickness"]
    assert films == [
        ("90 um", "Vezzoli 2014, section 3.1"),
        ("1 um", "not printed: only that C_i is comparable with C_s"),
    ]
    places = [row[0] for row in rows]
    assert all(
        places.count(path) == 1 or places[i + 1] == path or places[i - 1] == path
        for i, path in enumerate(places)
    )


def test_an_unknown_name_is_refused():
    with pytest.raises(InputError, match="neither a model nor a paper"):
        catalogue.find("MaxwellStressInGp")


def test_parts_without_a_choice_are_found_too():
    from electrovib.physics.amplifier import Amplifier
    from electrovib.study.catalogue import find

    assert find("Amplifier") is Amplifier


@pytest.mark.parametrize(
    "law",
    ["MaxwellStressInInsulator", "MaxwellStressInStratumCorneum", "EffectiveMedium", "MaxwellStressInGap"],
)
def test_a_filled_gap_is_accounted_for(law):
    """The field in a gap decreases with the permittivity of its filling, its stress with the square: no further terms."""
    filled = {"stack.gap.material.permittivity": 2.5, "force": {"model": law}}
    scenario = load("vezzoli_2014/fig6_gap").replace(filled)
    plane = static_force(scenario.replace({"force": {"model": "MaxwellStressInGap"}}), voltage=100.0)
    words = explain(scenario, ratio=static_force(scenario, voltage=100.0) / plane)
    assert "would give" not in words
    air = re.search(r"Maxwell stress in the gap at a gap of ([0-9.]+) um", words)
    if air is not None:
        changes = {"stack.gap.material.permittivity": 1.0, "stack.gap.thickness": f"{air[1]} um"}
        same = static_force(
            scenario.replace(changes | {"force": {"model": "MaxwellStressInGap"}}), voltage=100.0
        )
        assert same == pytest.approx(
            static_force(scenario, voltage=100.0), rel=0.1
        )  # two digits of the gap are printed


def test_a_drive_at_0_volts_is_told_and_a_swipe_is_compared_under_its_full_load():
    scenario = load("vezzoli_2014/fig6_gap")
    with pytest.raises(InputError, match="drive = Trapezium: it stays at 0 V"):
        compare(scenario.replace({"drive.high": 0.0}))
    growing = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
    pressed = scenario.replace({"contact": growing})
    swiped = pressed.replace({"load.time_profile": {"model": "Swipe", "rise": 0.1, "hold": 0.5, "fall": 0.1}})
    ours, theirs = (
        compare(each, models=["MaxwellStressInGap", "MaxwellStressInInsulator"]).entries
        for each in (swiped, pressed)
    )
    assert [entry.static for entry in ours] == [entry.static for entry in theirs]


def test_limits_of_an_amplifier_leave_the_held_voltage():
    laws, over = ["MaxwellStressInGap"], {"drive.high": np.array([500.0, 1000.0])}
    plain = load("vezzoli_2014/fig6").replace({"force.model": "MaxwellStressInGap"})
    limited = plain.replace(
        {"circuit.amplifier": {"gain": 2.0, "source_current": 1e-6, "saturation": 1000.0}}
    )
    found = compare(limited, models=laws, over=over)
    (reference,) = compare(plain, models=laws).entries
    assert found.voltage == 500
    assert found.entries[0].static == pytest.approx(reference.static, rel=1e-9)  # 1 kV at the plate
    assert found.panels[-1].curves[0].y == pytest.approx([reference.static] * 2, rel=1e-9)


def test_a_friction_with_memory_does_not_prevent_a_comparison():
    steady = {"model": "Coulomb", "coefficient": 0.5}
    bristles = {
        "model": "LuGre",
        "steady": steady,
        "stiffness": 5e3,
        "static_ratio": 1.5,
        "stribeck_speed": 5e-3,
    }
    sliding = load("vezzoli_2014/fig6_gap").replace({"friction": bristles, "motion.speed": 30e-3})
    (entry,) = compare(sliding, models=["MaxwellStressInGap"]).entries
    (reference,) = compare(load("vezzoli_2014/fig6_gap"), models=["MaxwellStressInGap"]).entries
    assert entry.static == reference.static
    assert entry.late == reference.late
