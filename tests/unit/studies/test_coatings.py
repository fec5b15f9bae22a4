"""Which coating to take: the numbers by another route, and what is recommended."""

import numpy as np
import pytest

import electrovib as ev
from electrovib.studies.compare import materials
from electrovib.studies.compare.materials import recommended, with_material

PULSE = ev.load(
    "vezzoli_2014/fig6_gap",
    changes={
        "stack.insulator.thickness": "25 um",
        "limits": {"voltage": "1.1 kV", "current": "1 mA"},
        "circuit.amplifier": {"saturation": "1.2 kV", "source_current": "40 uA", "sink_current": "40 uA"},
        "time.samples": 41,
    },
)
NAMES = ["silica", "pet"]
STRENGTH = 115e6
"""Of PET, as the library has it [V/m]."""


@pytest.fixture(scope="module")
def found():
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(materials, "DRAWS", 30)
        return ev.compare_materials(PULSE, materials=NAMES)


def test_force_and_margins_are_those_of_single_runs(found):
    by_name = {each.name: each for each in found.coatings}
    assert list(by_name) == NAMES  # from the largest force on
    bare = PULSE.replace({"circuit.amplifier": None, "time.samples": 401})
    draws = ev.read_space(bare, "fingers").draw(0, 0, 30)
    for name, each in by_name.items():
        case = with_material(bare, "insulator", name)
        fingers = [
            case.replace({path: float(values[n]) for path, values in draws.items()}) for n in range(30)
        ]
        peaks = [float(ev.simulate(finger).electrostatic_force.max()) for finger in fingers]
        assert each.for_most[1] == pytest.approx(np.quantile(peaks, 0.1), rel=0.01)
        assert each.for_most[0] <= each.for_most[1] <= each.for_most[2]
        assert each.margins[2] == pytest.approx(1.2)  # of 1.2 kV, the voltage being 1 kV
    open_gap, closed_gap, _ = by_name["pet"].margins
    assert closed_gap == pytest.approx(STRENGTH * 25e-6 / 1e3)
    field = float(
        abs(ev.simulate(with_material(bare, "insulator", "pet")).field.sel(layer="insulator")).max()
    )
    assert open_gap == pytest.approx(STRENGTH / field, rel=1e-3)
    assert open_gap > 0.999 * closed_gap


def test_a_gap_that_is_open_takes_a_part_of_the_voltage(monkeypatch):
    monkeypatch.setattr(materials, "DRAWS", 20)
    (sine,) = ev.compare_materials("bau_2010/sine", materials=["pet"]).coatings
    open_gap, closed_gap, amplifier = sine.margins
    assert closed_gap == pytest.approx(STRENGTH * 1e-6 / 100.0)  # all of 100 V across 1 um
    divider = 1e-6 / 3.15 + 3e-6  # electrical thickness of film and gap; the skin adds a few per cent
    assert open_gap == pytest.approx(STRENGTH * 3.15 * divider / 100.0, rel=0.05)
    assert np.isnan(amplifier)


def test_the_page_says_first_what_to_take_and_why(found, tmp_path):
    head, reason, other, law = found.document.sentences
    assert head == "Take pet: the only one within all limits."
    assert "pet, chosen: 90 % of the people have at least" in reason
    assert "gap closed 2.88, amplifier 1.2." in reason
    assert "finger of the scenario. The force is without the limits of the amplifier." in reason
    assert other.startswith("silica gives ")
    assert "but is not shown to be safe: film strength" in other
    assert "by a factor of 11 typically" in law
    page = ev.save(found, tmp_path / "materials.html")[0].read_text()
    assert page.index("Take pet") < page.index("gap closed") < page.index("<svg") < page.index("<details>")
    assert page.count("<svg") == 2
    assert page.index("<svg") < page.index("Materials of the layer")
    for text in found.document.warnings:
        assert page.index(text.split(":")[0]) < page.index("<svg")


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"limits": {}}, "Take none yet: no coating is shown to be safe."),
        ({"limits": {"voltage": "900 V", "current": "1 mA"}}, "Take none: each exceeds a limit."),
    ],
)
def test_nothing_is_recommended_that_is_not_shown_to_be_safe(changes, words, monkeypatch):
    monkeypatch.setattr(materials, "DRAWS", 20)
    head, reason, *_ = recommended(ev.compare_materials(PULSE.replace(changes), materials=NAMES).coatings)
    assert head == words
    assert "silica, with the most force" in reason
    assert "It is " in reason


def test_where_a_force_is_not_known_there_is_no_number_for_people(monkeypatch):
    monkeypatch.setattr(materials.Prepared, "__call__", lambda *_: {materials.FORCE: np.array([1.0, np.nan])})
    compared = ev.compare_materials(PULSE, materials=NAMES)
    assert not compared.coatings
    assert "silica: the force is not known of 1 of 200 fingers" in compared.left_out[materials.OF_PEOPLE]
    assert materials.OF_PEOPLE in str(compared.tables[-1].rows)


def test_where_people_do_not_differ_the_table_says_so():
    film = {"insulator": {"thickness": "1 um", "material": "silica"}}
    scenario = PULSE.replace({"stack": film, "force": {"model": "MaxwellStressInInsulator"}})
    compared = ev.compare_materials(scenario, materials=NAMES)
    assert (len(compared.entries), compared.coatings) == (3, ())
    assert "has no layer 'stratum_corneum'" in compared.left_out[materials.OF_PEOPLE]


def test_the_whole_library_is_a_table(found):
    assert found.document.one_screen
    library = ["pet", "silica", "parylene C", "su8", "ptfe", "soda_lime_glass"]
    assert not ev.compare_materials(PULSE, materials=library).coatings
