"""A contact that a scenario declares is solved once, and a run, a study and an answer of it are those of `rough_contact`."""

import json
import tomllib

import numpy as np
import pytest

import electrovib as ev
from electrovib.core.constants import eps0
from electrovib.core.diagnostics import diagnostics_of
from electrovib.core.errors import ElectrovibError, InputError
from electrovib.physics.contact import RoughContact
from electrovib.solve.population.fingers import TOGETHER, Population
from electrovib.solve.rough_contact import Loaded
from electrovib.solve.rough_contact.solved import STEP, SolvedContact, solved_contact

SINE = "bau_2010/sine"
ROUGH = {"rms": 2e-6, "hurst": 0.8, "longest": 1e-3, "roll_off": 2.5e-4, "shortest": 1.25e-4}
BODY = {"model": "Elastic", "modulus": "10 MPa"}
SURFACE = {"model": "RoughContact", "roughness": {"model": "SelfAffine"} | ROUGH, "body": BODY}
SOLVED = {"force": {"model": "TabulatedAttraction"}, "contact.surface": SURFACE}
BETWEEN = 5e-3
"""Relative error of an attraction between two voltages of the ladder, as it is stated."""


def scenario(level=20.0, /, **surface):
    held = {"drive": {"model": "Step", "level": level}}
    return ev.load(SINE).replace(SOLVED | held | {"contact.surface": SURFACE | surface})


def contact(body=BODY, **surface):
    given = RoughContact.model_validate(SURFACE | {"body": body} | surface)
    return SolvedContact(given, pressure=5e3, electrical_thickness=2.5e-7)


def answer(known, voltage):
    return ev.rough_contact(known, voltage=voltage)


@pytest.mark.parametrize("spots", ["PullingSpots", "IdleSpots"])
def test_a_run_has_the_attraction_and_the_real_contact_of_the_answer(spots):
    known = scenario(spots={"model": spots}, seed=3)
    volts = [10.0, 20.0, 30.0]
    found, surface = answer(known, volts), known.contact.surface
    given = {"roughness": surface.roughness, "body": surface.body, "seed": 3, "spots": surface.spots}
    assert ev.rough_contact(SINE, voltage=volts, **given).force.tolist() == found.force.tolist()
    assert ev.rough_contact(known, voltage=volts, seed=4).force[0] != found.force[0]
    for level, force, share in zip(volts, found.force, found.contact_share, strict=True):
        run = ev.run(known, set={"drive.level": level})
        assert float(run.electrostatic_force[-1]) == pytest.approx(force, rel=BETWEEN)
        # spots grow by whole points of the grid, of which some hundred touch
        assert float(run.real_contact_area[-1]) == pytest.approx(share * found.stack.area, rel=0.03)


def test_at_a_voltage_of_the_ladder_nothing_is_interpolated():
    known = scenario()
    solved, _ = solved_contact(known), ev.run(known)
    volts = [row.voltage for row in solved.rows]
    assert np.array(volts[2:]) / np.array(volts[1:-1]) == pytest.approx(STEP, rel=1e-12)
    found = answer(known, volts)
    assert [row.attraction for row in solved.rows] == pytest.approx(found.attraction, rel=1e-9)
    assert [row.contact_share for row in solved.rows] == pytest.approx(found.contact_share, rel=1e-9)
    assert solved.attraction(np.array(volts)) == pytest.approx(found.attraction, rel=1e-9)
    whole = solved.pressure + found.attraction
    assert solved.contact_share(whole) == pytest.approx(found.contact_share, rel=1e-9)


def test_between_voltages_of_the_ladder_the_error_is_the_stated_one():
    known = scenario()
    volts = np.linspace(5.0, 40.0, 16)
    found = answer(known, volts)
    assert solved_contact(known).attraction(-volts) == pytest.approx(found.attraction, rel=BETWEEN)


def test_even_faces_attract_as_plates_and_touch_everywhere():
    flat = {"model": "MeasuredHeights", "values": np.zeros((4, 4)), "spacing": 1e-4}
    known = scenario(roughness=flat)
    run, thickness = ev.run(known), solved_contact(known).electrical_thickness
    stress = eps0 * 20.0**2 / (2 * thickness**2)
    assert float(run.electrostatic_force[-1]) == pytest.approx(stress * known.contact_area, rel=1e-5)
    assert run.real_contact_area.values == pytest.approx(known.contact_area)


def test_a_number_does_not_depend_on_what_was_asked_before():
    volts = np.array([3.0, 17.0])
    climbed, fresh = contact(), contact()
    climbed.attraction(np.array([25.0]))
    assert climbed.attraction(volts) == pytest.approx(fresh.attraction(volts), rel=1e-12)
    assert len(climbed.rows) > len(fresh.rows)


def test_a_contact_is_solved_once_for_all_drives_and_kept(monkeypatch):
    known = scenario(30.0, seed=11)
    ev.run(known)
    kept, rests = solved_contact(known), []
    monkeypatch.setattr(Loaded, "rest", lambda *_, **__: rests.append(1))
    for level in (30.0, 12.0):
        ev.run(scenario(level, seed=11))
    assert solved_contact(scenario(1.0, seed=11)) is kept
    assert not rests
    assert solved_contact(ev.load(SINE)) is None


def test_many_fingers_have_the_contact_of_each():
    """Together where they share it, one by one where the load of each asks for its own."""
    known, volts = (
        scenario().replace({"drive": {"model": "Sine", "amplitude": 20, "frequency": 100}}),
        [10.0, 25.0],
    )
    many = Population(known, free=("drive.amplitude",), signals=("electrostatic_force", "lateral_force"))
    assert many.method == TOGETHER
    found = many.signals({"drive.amplitude": volts})
    for at, amplitude in enumerate(volts):
        run = ev.run(known, set={"drive.amplitude": amplitude})
        for name in ("electrostatic_force", "lateral_force"):
            assert found[name][at] == pytest.approx(run[name].values, rel=1e-9, abs=1e-12)
    for path, value in (("load.normal_force", 0.3), ("stack.insulator.thickness", 2e-6)):
        each = Population(scenario(), free=(path,))
        assert each.method == f"one by one: {path} changes the rough contact, which is solved for each finger"
        force = each.signals({path: [value]})["electrostatic_force"][0, -1]
        assert force == pytest.approx(answer(scenario().replace({path: value}), 20.0).force[0], rel=BETWEEN)
    assert Population(scenario(), free=("stack.gap.thickness",)).method == TOGETHER


def test_friction_by_shear_takes_the_real_contact_of_the_solver():
    shear = {"friction": {"model": "AdhesiveShear", "shear_strength": 1e6}, "motion.speed": 0.03}
    run = ev.run(scenario(), set=shear)
    assert run.lateral_force.values == pytest.approx(1e6 * run.real_contact_area.values, rel=1e-9)
    found = answer(scenario(), [0.0, 20.0])
    assert float(run.lateral_force[-1]) == pytest.approx(1e6 * found.contact_share[1] * 1e-4, rel=0.03)


@pytest.mark.parametrize("strength", ["15 MV/m", "5 MV/m", "0.1 MV/m"])
def test_a_check_states_the_area_above_the_strength_of_the_contact_that_is_solved(strength):
    known = scenario().replace({"stack.insulator.breakdown_field": strength})
    (closed,) = (row for row in ev.check(known).rows if row.quantity.endswith("gap closed"))
    assert "by contact.surface, which is solved" in closed.text
    found = answer(known, 20.0)
    # at the next voltage of the ladder, up to a tenth above
    assert found.area_beyond["insulator"][0] * 0.999 <= closed.area <= 1.3 * found.area_beyond["insulator"][0]


WAVES = {"model": "SelfAffine"} | ROUGH | {"roll_off": 1e-3, "shortest": 5e-4}
SOFT = {"roughness": WAVES, "points": 64, "body": {"model": "Elastic", "modulus": "1 MPa"}}


def test_a_result_beyond_pull_in_says_so():
    known = scenario(8.0, **SOFT)
    names = [each.name for each in diagnostics_of(ev.run(known))]
    assert "rough contact" in names
    assert "pull-in" not in names
    beyond = ev.run(known, set={"drive.level": 12.0})
    (said,) = (each for each in diagnostics_of(beyond) if each.name == "pull-in")
    solved = solved_contact(known)
    assert (said.state, said.limit) == ("warning", solved.fall)
    assert said.value == pytest.approx(12.0, rel=BETWEEN)
    assert "stays shut while the voltage falls again" in said.text
    at = [row.voltage for row in solved.rows].index(solved.fall)
    before, after = solved.rows[at : at + 2]
    assert after.voltage == pytest.approx(before.voltage, rel=2e-3)
    assert after.attraction > 1.05 * before.attraction
    # a smaller step from the same rest passes the same state that is not stable
    rests = answer(known, [row.voltage for row in solved.rows[: at + 2]])
    assert rests.attraction[-2:] == pytest.approx([before.attraction, after.attraction], rel=1e-9)
    last = [each for each in rests.diagnostics if each.name == "pull-in"][-1]
    assert (last.state, last.limit) == ("warning", before.voltage)


@pytest.mark.slow
def test_a_grid_that_is_too_coarse_for_the_attraction_is_told():
    known = scenario(60.0, points=64)
    said = [each.text for each in diagnostics_of(ev.run(known)) if each.name == "rough contact"]
    assert any("the grid does not resolve" in each for each in said)
    steep = {"roughness.rms": 2e-5, "body.modulus": 1e8}
    said = ev.run(known, set={f"contact.surface.{path}": value for path, value in steep.items()})
    assert "but slopes are taken as small" in said.attrs["validity"]


def test_beyond_what_is_solved_nothing_is_extrapolated(monkeypatch):
    found = contact()
    known, rest = found.attraction(np.array([10.0])), Loaded.rest

    def failing(*given, **more):
        raise ElectrovibError("the contact did not come to rest")

    monkeypatch.setattr(Loaded, "rest", failing)
    assert found.attraction(np.array([10.0])) == known
    with pytest.raises(
        InputError, match=r"contact.surface: it is known up to 1\d.* V, and at 1.* did not come to rest"
    ):
        found.attraction(np.array([20.0]))
    with pytest.raises(InputError, match="it is known up to"):
        found.contact_share(np.array([found.pressure + 2 * found.rows[-1].attraction]))
    monkeypatch.setattr(Loaded, "rest", rest)
    assert found.attraction(np.array([20.0])) > 4 * known


@pytest.mark.slow
def test_spots_that_idle_are_refused_once_more_voltage_attracts_less():
    """A contact that is shut everywhere has no field that attracts."""
    idle = contact(body=SOFT["body"], roughness=WAVES, points=64, spots={"model": "IdleSpots"})
    with pytest.raises(
        InputError, match=r"beyond \d.* V the attraction does not rise .* give spots that pull"
    ):
        idle.attraction(np.array([60.0]))
    known = idle.rows[-1].voltage
    assert np.all(np.diff([row.attraction for row in idle.rows]) > 0)
    assert idle.attraction(np.array([known])) == pytest.approx(idle.rows[-1].attraction)


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({"force": {"model": "MaxwellStressInGap"}}, "force = MaxwellStressInGap: .* give force = "),
        ({"contact.surface": None}, "there is no table; give a file"),
        (
            {"contact.surface": SURFACE | {"spots": {"model": "LeakingSpots", "resistivity": 1e8}}},
            "depends on the frequency",
        ),
        ({"contact.surface.points": 16}, "points = 16"),
        ({"contact.closing": {"damping": 1e6}}, "contact.closing: .* no gap moves"),
        ({"motion.distance": {"model": "HeldOff"}}, "motion.distance: .* no gap moves"),
        ({"load.normal_force": 0}, "load.normal_force = 0"),
        (
            {"load.time_profile": {"model": "Press", "rise": 0.01}},
            "load.time_profile: .* constant load",
        ),
        (
            {
                "contact": {
                    "model": "GrowingArea",
                    "area": 1e-4,
                    "at_force": 0.5,
                    "exponent": 0.5,
                    "surface": SURFACE,
                }
            },
            "grows",
        ),
        ({"circuit.return_path": {"model": "Floating", "capacitance": 1e-10}}, "Grounded"),
        ({"stack.gap.material.conductivity": 1e-9}, "stack.gap conducts"),
    ],
)
def test_what_one_solved_contact_does_not_describe_is_refused(changes, said):
    with pytest.raises(InputError, match=said):
        ev.run(scenario(), set=changes)


def test_a_measured_map_is_read_from_a_file_and_written_with_the_scenario(tmp_path):
    rough = ev.SelfAffine(**ROUGH).heights((32, 32), (1e-3, 1e-3), seed=1)
    rows = "\n".join(f"{1e6 * height!r}" for height in rough.ravel().tolist())
    (tmp_path / "map.csv").write_text(f"z [um]\n{rows}\n")
    table = {
        "model": "MeasuredHeights",
        "file": str(tmp_path / "map.csv"),
        "columns": 32,
        "spacing": 3.125e-5,
    }
    read, given = scenario(roughness=table), ev.MeasuredHeights(values=rough, spacing=3.125e-5)
    assert read.contact.surface.roughness.level() == pytest.approx(given.level(), abs=1e-15)
    assert ev.load(json.loads(read.to_json())) == read
    assert ev.load(tomllib.loads(scenario().to_toml())) == scenario()
    found = ev.rough_contact(read, roughness=given, voltage=20.0)
    with pytest.raises(InputError, match=r"body: not given, and contact\.surface is no RoughContact"):
        ev.rough_contact(SINE, roughness=given, voltage=20.0)
    assert float(ev.run(read).electrostatic_force[-1]) == pytest.approx(found.force[0], rel=BETWEEN)


def test_the_law_in_its_place_has_its_roughness_and_stiffness():
    law = scenario().contact.surface.law
    assert law.modulus == pytest.approx(1e7 / (1 - 0.5**2))
    assert (law.rms_height, law.rms_slope) == (
        2e-6,
        pytest.approx(ev.SelfAffine(**ROUGH).rms_slope((1e-3, 1e-3))),
    )
    coated = {"model": "Coated", "film": {"modulus": 1e7}, "thickness": 1.0, "below": {"modulus": 1e5}}
    assert scenario(body=coated).contact.surface.law.modulus == pytest.approx(law.modulus)
    assert ev.equilibrium(scenario(), voltage=20.0).stable
