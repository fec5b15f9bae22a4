"""Comparison of force laws, and of one scenario with several materials."""

import math
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.discovery import find_members
from electrovib.core.errors import InputError
from electrovib.physics.force import ForceLaw
from electrovib.scenario import load
from electrovib.studies.compare import compare
from electrovib.studies.compare.laws import insulating, static_force
from electrovib.studies.compare.materials import AS_IT_IS
from electrovib.studies.compare.result import explain

FIG6, BEHIND_GAP = load("vezzoli_2014/fig6"), load("vezzoli_2014/fig6_gap")
PLANE = "MaxwellStressInGap"
COATING = {
    "stack.insulator.thickness": 1e-6,
    "stack.insulator.material.permittivity": 3.9,
    "stack.stratum_corneum.material.permittivity": 1650.0,
    "drive": {"model": "Step", "level": 100.0},
}


@pytest.fixture(scope="module")
def leaky():
    return compare(BEHIND_GAP, over={"stack.gap.thickness": np.geomspace(1e-7, 1e-4, 3)})


@pytest.fixture(scope="module")
def coating():
    """31 N on 1 cm2: 265 MV/m in a gap that is no layer of the stack."""
    return compare(FIG6.replace(COATING), over={"drive.level": np.array([10.0, 100.0])})


def by_name(found):
    return {entry.name: entry for entry in found.entries}


def told(found, page=0):
    return " ".join(found.pages[page].paragraphs)


def lines(panel):
    return {curve.label: curve for curve in panel.curves if curve.kind != "points"}


def test_every_law_is_compared_and_explained_in_order_or_says_why_not(leaky):
    found = by_name(leaky)
    assert set(found) | set(leaky.left_out) == set(find_members(ForceLaw))
    forces = [entry.static for entry in leaky.entries]
    assert forces == sorted(forces, reverse=True)
    for name, words in {
        "MaxwellStressInStratumCorneum": "permittivity 1560",
        "EffectiveMedium": "effective permittivity 10.74",
        "MaxwellStressInInsulator": "rises",
        PLANE: "falls",
    }.items():
        assert words in found[name].why
    assert not any("further terms" in entry.why for entry in leaky.entries)
    literal = found["Vezzoli2014PerFrequency"]
    assert len(literal.step) == 0, "a law of magnitudes has a static force but no step"
    assert literal.static == pytest.approx(found["Vezzoli2014Causal"].static, rel=1e-9)
    change = {entry.name: entry.late / entry.early for entry in leaky.entries if len(entry.step)}
    assert change["EffectiveMedium"] == pytest.approx(1.0, abs=1e-2)
    assert change[PLANE] < 1e-4
    assert change["MaxwellStressInInsulator"] > 1.05


def test_the_answer_names_the_law_to_believe_and_why(leaky, coating):
    assert leaky.headline == (
        "Believe MaxwellStressInGap here, 564.9 mN at 1 kV: plate and finger separate only in the gap, so the stress there is"
        " the force between them; the other laws give 0.000641 to 0.299 of it."
    )
    beyond = "31.05 N at 100 V (beyond breakdown of the air, so no force that would be measured)"
    assert beyond in coating.headline
    film = compare(FIG6, models=[PLANE])
    assert "(an upper limit: the stack has no gap, and any gap lowers it)" in film.headline
    assert "other laws" not in film.headline
    without = compare(FIG6, models=["EffectiveMedium"])
    assert without.headline.startswith("None of these laws evaluates the stress in the gap")
    rough = {"force": {"model": "Persson2018RoughGap", "mean_gap": 10e-6, "rms_gap": 5e-6}}
    found = compare(FIG6.replace(rough), models=[PLANE, "Persson2018RoughGap"])
    assert found.headline.startswith("Believe Persson2018RoughGap here")


def test_defects_of_the_papers_compared_come_first(leaky):
    text = " ".join(told(leaky, page) for page in range(len(leaky.pages)))
    for word in ("10.74", "1.0096", "falling edges", "responds before the pulse"):
        assert word in text
    assert leaky.pages[1].title == "Where the papers of these laws contradict themselves or others"
    assert all(text.startswith(("Vezzoli 2014", "Persson")) for text in leaky.pages[1].paragraphs)
    for word in ("250 Hz is a fit of the leak", "rho_g > eps_d rho_d", "positive pulses"):
        assert word in told(leaky, 2)


def test_mistakes_and_laws_that_cannot_run_here_are_refused():
    for models, words in (
        (["MaxwellStressInGp"], "Did you mean 'MaxwellStressInGap'"),
        (["Persson2018RoughGap"], "mean_gap: missing"),
        ([], "names no force law"),
    ):
        with pytest.raises(InputError, match=words):
            compare(FIG6, models=models)
    with pytest.raises(InputError, match="drive = Trapezium: it stays at 0 V"):
        compare(BEHIND_GAP.replace({"drive.high": 0.0}))


def test_an_entry_beyond_breakdown_carries_its_diagnostic(coating):
    broken = {entry.name: entry.breakdown for entry in coating.entries}
    assert "265 MV/m" in broken.pop(PLANE)
    assert not any(broken.values())
    rows = {row[0]: row for row in coating.tables[0].rows}
    assert "(beyond breakdown)" in rows[PLANE][3]
    assert "(beyond breakdown)" not in rows["MaxwellStressInInsulator"][3]
    laws = {what: law for law, what in coating.tables[1].rows}
    field = next(law for what, law in laws.items() if "static: the field of a vanishing gap" in what)
    assert field == PLANE
    assert not any("across 'stratum_corneum'" in what for what in laws), "it holds whatever the law"
    assert any("across 'stratum_corneum'" in each.text for each in coating.diagnostics)
    marks = [curve for curve in coating.panels[-1].curves if curve.kind == "points"]
    expected = [(f"{PLANE}: air breaks down", [100.0])]
    assert [(curve.label, list(curve.x)) for curve in marks] == expected
    found = by_name(coating)
    assert found["Vezzoli2014PerFrequency"].warnings == found["MaxwellStressInStratumCorneum"].warnings != ()


def test_a_law_pulls_as_the_gap_plane_at_some_gap(coating):
    """Each law equals V^2/(K + g)^2 at some gap g: 8 and 15 um on the coating."""
    electrical = 1e-6 / 3.9 + 200e-6 / 1650
    for name, ratio in {
        "EffectiveMedium": electrical / 201e-6,
        "MaxwellStressInStratumCorneum": 1 / 1650,
    }.items():
        gap = electrical * (1 / math.sqrt(ratio) - 1)
        assert f"Maxwell stress in the gap at a gap of {1e6 * gap:.2g} um" in by_name(coating)[name].why


def test_leak_time_and_polarity_are_told(coating, leaky):
    for words in ("no gap that could leak", "from 18.66 mN to", "No law can show an effect of polarity"):
        assert words in told(coating)
    assert "this law counts charge that has crossed as lost" in told(coating)
    assert "The gap leaks" in told(leaky)
    still = FIG6.replace({"stack.stratum_corneum.material.conductivity": 0.0})
    text = told(compare(still, models=[PLANE]))
    assert "nothing conducts" in text
    assert "differ by a factor" not in text
    rectifying = compare(load("kaczmarek_2006/skin_positive"))
    polarity = {entry.name: entry.polarity for entry in rectifying.entries}
    # the skin's own voltage decays 7.7/2.5 times faster in one direction, and so does the integral of its square
    assert polarity["MaxwellStressInStratumCorneum"] == pytest.approx(2.5 / 7.7, rel=2e-2)
    assert polarity[PLANE] == pytest.approx(1.0, abs=1e-2)
    assert "The response of a layer depends on the polarity" in told(rectifying)


def test_a_law_looks_the_same_in_every_figure_and_a_parameter_of_one_moves_no_other(coating, leaky):
    looks = [{label: curve.look for label, curve in lines(panel).items()} for panel in coating.panels]
    assert all(look.items() <= looks[0].items() for look in looks)
    last = lines(coating.panels[-1])
    kinds = [last[name].kind for name in ("EffectiveMedium", "Vezzoli2014Causal", "Vezzoli2014PerFrequency")]
    assert kinds == ["line", "dashed", "dotted"]
    assert leaky.panels[-1].x == ("thickness of the gap", "m")
    assert all(len(curve.x) == 3 for curve in leaky.panels[-1].curves)
    models, over = ["Persson2018RoughGap", PLANE], {"force.mean_gap": np.array([5e-6, 20e-6])}
    forces = lines(compare(load("persson_2018/coating"), models=models, over=over).panels[-1])
    assert forces["Persson2018RoughGap"].y[0] > 2 * forces["Persson2018RoughGap"].y[1]
    assert forces[PLANE].y[0] == forces[PLANE].y[1]


LAWS = [PLANE, "MaxwellStressInInsulator", "MaxwellStressInStratumCorneum", "EffectiveMedium"]


@pytest.mark.parametrize("law", LAWS)
def test_a_filled_gap_is_accounted_for(law):
    """The field in a gap decreases with the permittivity of its filling, its stress with the square: no further terms."""

    scenario = BEHIND_GAP.replace({"stack.gap.material.permittivity": 2.5, "force": {"model": law}})

    def force(changes):
        return static_force(scenario.replace(changes), voltage=100.0)

    plane = {"force": {"model": PLANE}}
    words = explain(scenario, ratio=force({}) / force(plane))
    assert "would give" not in words
    air = re.search(r"Maxwell stress in the gap at a gap of ([0-9.]+) um", words)
    if air is not None:  # two digits of the gap are printed
        gap = {"stack.gap.material.permittivity": 1.0, "stack.gap.thickness": f"{air[1]} um"}
        assert force(gap | plane) == pytest.approx(force({}), rel=0.1)


def test_an_amplifier_leaves_the_held_voltage():
    plain = FIG6.replace({"force.model": PLANE})
    amplifier = {"gain": 2.0, "source_current": 1e-6, "saturation": 1000.0}
    over = {"drive.high": np.array([500.0, 1000.0])}
    found = compare(plain.replace({"circuit.amplifier": amplifier}), models=[PLANE], over=over)
    (reference,) = compare(plain, models=[PLANE]).entries
    assert found.voltage == 500
    assert found.entries[0].static == pytest.approx(reference.static, rel=1e-9)  # 1 kV at the plate
    assert found.panels[-1].curves[0].y == pytest.approx([reference.static] * 2, rel=1e-9)


@pytest.mark.slow
def test_a_swipe_leaves_its_full_load_and_a_memory_its_steady_law():
    growing = {"model": "GrowingArea", "area": 1e-4, "at_force": 0.5, "exponent": 0.5}
    pressed = BEHIND_GAP.replace({"contact": growing})
    swiped = pressed.replace({"load.time_profile": {"model": "Swipe", "rise": 0.1, "hold": 0.5, "fall": 0.1}})
    (ours,), (theirs,) = (compare(each, models=[PLANE]).entries for each in (swiped, pressed))
    assert ours.static == theirs.static
    steady = {"model": "Coulomb", "coefficient": 0.5}
    bristles = {
        "model": "LuGre",
        "steady": steady,
        "stiffness": 5e3,
        "static_ratio": 1.5,
        "stribeck_speed": 5e-3,
    }
    sliding = BEHIND_GAP.replace({"friction": bristles, "motion.speed": 30e-3})
    (entry,), (reference,) = (compare(each, models=[PLANE]).entries for each in (sliding, BEHIND_GAP))
    assert (entry.static, entry.late) == (reference.static, reference.late)


def test_the_response_to_a_step_is_that_behind_the_amplifier_with_its_limits():
    """Charged with its largest current; a time of its own, not a line between two others."""
    amplifier = {"gain": 2.0, "source_current": 1e-4, "stray_capacitance": 1e-9, "bandwidth": 1e5}
    plain = BEHIND_GAP.replace({"drive": {"model": "Step", "level": 500.0}, "force.model": PLANE})
    slow = plain.replace({"circuit.amplifier": amplifier})
    found = compare(slow, models=[PLANE])
    (entry,) = found.entries
    trace = ev.simulate(slow, time=[0.0, 50e-6, 0.05])
    assert [entry.early, entry.late] == pytest.approx(trace.electrostatic_force.values[1:].tolist(), rel=1e-9)
    quick = compare(plain.replace({"circuit.amplifier": {"gain": 2.0}}), models=[PLANE]).entries[0]
    assert entry.early < 1e-3 * quick.early
    assert entry.static == pytest.approx(quick.static, rel=1e-9)
    assert "while the amplifier still charges the plate" in entry.why
    assert "still charges" not in quick.why
    assert any("the amplifier limits" in each for each in entry.warnings)
    assert found.scenario == slow
    saturated = {"circuit.amplifier.saturation": np.array([200.0, 400.0])}
    curve = (
        compare(slow.replace({"circuit.amplifier.saturation": 400.0}), models=[PLANE], over=saturated)
        .panels[-1]
        .curves[0]
    )
    assert curve.y[1] == pytest.approx(4 * curve.y[0])


def test_a_bridged_gap_that_conducts_is_compared():
    """Without conduction its bridges are only missing area."""
    bridged = {"model": "BridgedAir", "bridged_share": 0.1, "spot_conductivity": 1e-6}
    (entry,) = compare(BEHIND_GAP.replace({"stack.gap.material": bridged}), models=[PLANE]).entries
    blocking = bridged | {"spot_conductivity": 0.0}
    (reference,) = compare(BEHIND_GAP.replace({"stack.gap.material": blocking}), models=[PLANE]).entries
    assert entry.static == pytest.approx(reference.static, rel=1e-12)
    assert entry.late < 0.9 * reference.late
    assert reference.late == pytest.approx(reference.static, rel=1e-2)


# materials

SLAB = {"thickness": 10e-6, "material": {"model": "Constant", "permittivity": 3.0}}
STEPPED = {"drive": {"model": "Step", "level": 100.0}, "force": {"model": PLANE}, "time.samples": 3}
STEPPED |= {"circuit.return_path.resistance": 0.0, "stack": {"insulator": SLAB}}
FILM = load("vezzoli_2014/fig6_static").replace(STEPPED)


def test_the_attraction_of_a_single_layer_is_that_of_its_displacement_in_every_material():
    """E = V/T in every material; the stress in a vanishing gap is (eps E)^2 eps0/2."""
    found = ev.compare_materials(FILM, materials=["PTFE", "silica", "pvdf"])
    assert [entry.name for entry in found.entries] == [AS_IT_IS, "pvdf", "silica", "ptfe"]
    for entry in found.entries:
        assert entry.field == pytest.approx(1e7, rel=1e-6)
        assert entry.margin == pytest.approx(entry.strength / 1e7, rel=1e-6)
    own, pvdf, silica, ptfe = found.entries
    for entry in (own, ptfe):
        expected = eps0 * (entry.permittivity * 1e7) ** 2 / 2 * FILM.contact_area
        assert entry.force == pytest.approx(expected, rel=1e-6)
    assert (own.strength, own.status) == (118e6, "of the scenario")
    assert (pvdf.strength, pvdf.breakdown) == (80e6, "ok")
    assert pvdf.status == "derived: permittivity; full text: conductivity, strength"
    assert (silica.breakdown, ptfe.breakdown) == ("unknown", "ok")
    assert "a thickness that its source does not state" in silica.why
    assert silica.status == "full text: permittivity, conductivity; abstract: strength"
    assert silica.relaxation_time == pytest.approx(3.9 * eps0 / 1e-14, rel=1e-9)
    assert math.isinf(ptfe.relaxation_time)
    table = found.tables[0]
    assert table.title == "Materials of the layer 'insulator', 10 um thick"
    row = dict(zip(table.headings, table.rows[2], strict=True))
    assert (row["material"], row["strength"], row["margin"]) == ("silica", "660 MV/m", "66")
    assert "abstract: strength" in row["source status"]


def test_the_breakdown_field_of_the_scenario_is_that_of_its_own_material_alone():
    weak = FILM.replace({"stack.insulator.breakdown_field": 50e6})
    own, pvdf = ev.compare_materials(weak, materials=["pvdf"]).entries
    assert (own.strength, pvdf.strength) == (50e6, 80e6)


def test_all_of_the_library_what_a_law_refuses_and_a_layer_without_a_known_strength():
    """The law of Vezzoli et al. 2014 has one permittivity of the insulator."""
    compared = ev.compare_materials("vezzoli_2014/fig6")
    assert {entry.name for entry in compared.entries} >= {AS_IT_IS, "pet", "silica", "hafnia"}
    assert set(compared.left_out) == {"parylene_c", "pvdf", "p_vdf_trfe_cfe"}
    assert "one permittivity" in compared.left_out["pvdf"]
    assert compared.tables[1].title == "Not in this comparison"
    changed = FILM.replace({"stack.insulator.material.permittivity": 50.0})
    found = ev.compare_materials(changed, materials=["pet"])
    own, _ = found.entries
    assert np.isnan([own.margin, own.strength, own.field]).all()
    assert own.breakdown == "unknown"
    assert found.tables[0].rows[0][5:9] == ("not known", "not known", "not known", "unknown")


def test_mistakes_are_answered_and_several_layers_of_the_plate_need_a_name():
    two = FILM.replace({"stack": {name: SLAB | {"role": "plate"} for name in ("lower", "upper")}})
    for scenario, wrong, words in (
        (
            FILM,
            {"materials": ["silika", "kaptan"]},
            r"(?s)'silika'. Nearest: silica.*'kaptan'. Nearest: polyimide",
        ),
        (FILM, {"materials": []}, "no material is named; known: alumina,"),
        (
            FILM,
            {"layer": "insulater", "materials": ["pet"]},
            "layer 'insulater': .* Did you mean 'insulator'",
        ),
        (two, {"materials": ["pet"]}, "has 2 layers of the plate: name the layer"),
    ):
        with pytest.raises(InputError, match=words):
            ev.compare_materials(scenario, **wrong)
    compared = ev.compare_materials(two, layer="upper", materials=["pet"])
    assert (compared.layer, len(compared.entries)) == ("upper", 2)


def test_a_rough_contact_that_is_solved_stands_beside_laws_of_the_declared_gap():
    """Its own law has the attraction of `rough_contact`; the others take the gap of the stack, as without it."""
    rough = {
        "model": "RoughContact",
        "roughness": {
            "model": "SelfAffine",
            "rms": 2e-6,
            "hurst": 0.8,
            "longest": 1e-3,
            "roll_off": 2.5e-4,
            "shortest": 1.25e-4,
        },
        "body": {"model": "Elastic", "modulus": "10 MPa"},
    }
    held = load("bau_2010/sine").replace({"drive": {"model": "Step", "level": 20.0}})
    solved = held.replace({"force": {"model": "TabulatedAttraction"}, "contact.surface": rough})
    found = compare(solved, over={"contact.surface.roughness.rms": [1e-6, 2e-6]})
    entries, without = by_name(found), by_name(compare(held))
    assert {name: each.static for name, each in entries.items() if name != "TabulatedAttraction"} == {
        name: each.static for name, each in without.items()
    }
    alone = ev.rough_contact(insulating(solved), voltage=[20.0]).force[0]
    assert entries["TabulatedAttraction"].static == pytest.approx(alone, rel=5e-3)
    over = lines(next(panel for panel in found.panels if panel.id.startswith("static_over_contact_surface")))
    assert over["TabulatedAttraction"].y[1] == pytest.approx(alone, rel=5e-3)
    assert over["TabulatedAttraction"].y[0] > over["TabulatedAttraction"].y[1]
    assert np.ptp(over[PLANE].y) == 0
