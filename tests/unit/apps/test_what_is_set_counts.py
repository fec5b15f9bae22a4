"""A parameter that is set has an effect, or is refused; a friction that is unknown stays unknown everywhere."""

import json
import re

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.cli.run import summary
from electrovib.core.errors import InputError

MEAN = "mean electrostatic_force"


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """Return the file of a sweep of two values."""
    path = tmp_path_factory.mktemp("swept") / "swept.nc"
    quick = {"time.samples": 51, "frequency.samples": 3}
    ev.run(set=quick, over={"drive.high": [500.0, 1000.0]}, quantity=[MEAN], output=path)
    return path


def test_a_repeated_sweep_takes_other_parameters_further_ones_and_new_values(swept):
    first = ev.open_trace(swept)
    thick = ev.run(swept, set={"stack.insulator.thickness": "180 um"})
    assert np.all(thick[MEAN].values < first[MEAN].values)
    np.testing.assert_array_equal(thick["drive.high"], first["drive.high"])
    assert ev.scenario_of(thick).stack.insulator.thickness == pytest.approx(180e-6, rel=1e-12)
    both = ev.run(swept, over=["stack.insulator.thickness=90um:180um:2"])
    assert dict(both.sizes) == {"drive.high": 2, "stack.insulator.thickness": 2}
    assert list(json.loads(both.attrs["over"])) == ["drive.high", "stack.insulator.thickness"]
    np.testing.assert_allclose(both[MEAN].values[:, 0], first[MEAN].values, rtol=1e-9)
    again = ev.run(swept, over=["drive.high=100V:300V:3"])
    np.testing.assert_allclose(again["drive.high"], [100, 200, 300])


def test_what_a_repeated_sweep_goes_over_is_not_set(swept):
    words = r"drive\.high: is set, but swept in .*swept\.nc as well.*electrovib init"
    with pytest.raises(InputError, match=words):
        ev.run(swept, set={"drive.high": "5 V"})
    with pytest.raises(InputError, match=r"drive\.high: is set, but swept"):
        ev.run(swept, set={"drive.high": 1.0}, over=["drive.high=100V:300V:3"])


@pytest.mark.parametrize("use", [ev.perceive, ev.compare, ev.load])
@pytest.mark.parametrize("changes", [{}, {"load.normal_force": 1.0}], ids=["as it is", "changed"])
def test_a_sweep_is_not_taken_for_the_scenario_it_began_from(swept, use, changes):
    given = {"changes" if use is ev.load else "set": changes} if changes else {}
    with pytest.raises(InputError, match="sweep"):
        use(swept, **given)
    assert "[load]" in ev.init(swept)


FIG6 = ev.load("vezzoli_2014/fig6")
FILM = {"thickness": "50 um", "material": {"model": "Constant", "permittivity": 2}}


@pytest.mark.parametrize("order", [1, -1])
def test_a_table_and_what_is_set_in_it_count_in_any_order(order):
    def changed(changes):
        return FIG6.replace(dict(list(changes.items())[::order]))

    film = changed({"stack.insulator": FILM, "stack.insulator.initial_charge": 1e-6}).stack.insulator
    assert (film.thickness, film.initial_charge) == pytest.approx((50e-6, 1e-6), rel=1e-12)
    film = changed({"stack.insulator": FILM, "stack.insulator.material.permittivity": 3}).stack.insulator
    assert (film.thickness, film.material.permittivity) == pytest.approx((50e-6, 3), rel=1e-12)
    part = {"stack.insulator": {"thickness": 5e-5}, "stack.insulator.material": FILM["material"]}
    assert changed(part).stack.insulator.material.permittivity == 2
    assert FILM["material"]["permittivity"] == 2  # no table of the caller is changed
    step = {"model": "Step", "level": 5}
    assert changed({"drive": step, "drive.model": "Step"}).drive.level == 5
    for wrong in (
        {"drive": step, "drive.model": "Square"},
        {"stack.insulator": FILM, "stack.insulator.material.model": "ConstantPhase"},
    ):
        with pytest.raises(InputError, match=r"model: is set beside the table .*give one of the two"):
            changed(wrong)


def test_an_entry_of_a_list_has_one_path():
    parts = [{"model": "Step", "level": level} for level in (1, 2)]
    scenario = FIG6.replace({"drive": {"model": "Sum", "drives": parts}})
    assert scenario.replace({"drive.drives.0.level": 3}).drive.drives[0].level == 3
    for number in ("00", "²", "+0", "1" * 5000):
        with pytest.raises(InputError, match="has entries 0 to 1"):
            scenario.replace({f"drive.drives.{number}.level": 3})


@pytest.fixture(scope="module")
def swipe():
    """A finger that rests, swipes and rests again."""
    profile = {"model": "Swipe", "begin": 0.0, "rise": 0.01, "hold": 0.05, "fall": 0.01}
    return FIG6.replace({"motion": {"speed": 0.03, "time_profile": profile}})


@pytest.fixture(scope="module")
def trace(swipe):
    return ev.simulate(swipe, time=np.linspace(0, 0.14, 141))


def test_where_the_finger_rests_its_friction_is_unknown_in_every_file_and_line(trace, tmp_path, said):
    (line,) = [line for line in summary(trace, None, None) if line.startswith("lateral force")]
    assert line.endswith("mN, not known for 50.4 % of the time (the finger rests)")
    for suffix in ("nc", "mat"):
        ev.save(trace, tmp_path / f"trace.{suffix}")
        again = ev.open_trace(tmp_path / f"trace.{suffix}").lateral_force.values
        assert np.isnan(again).sum() == 71
        np.testing.assert_array_equal(again, trace.lateral_force.values)
    out = said("run vezzoli_2014/fig6 --set motion.speed=0.03")
    assert "lateral force: 250 mN to 251.3 mN" in out.splitlines()


def test_how_long_a_friction_is_unknown_depends_on_no_times_of_ours(swipe):
    """The times of a sweep lie closest where the drive bends; the finger rests from 70 ms to the end, at 272 ms."""
    (said,) = re.findall(
        r"lateral force for ([0-9.]+) % of the time",
        ev.sweep(swipe, {"drive.high": [9.0, 10.0]}, quantity="mean lateral_force").attrs["validity"],
    )
    assert float(said) == pytest.approx(100 * (1 - 0.07 / 0.272), rel=0.01)


@pytest.mark.slow
def test_plot_and_report_explain_the_gap(trace, swipe, tmp_path):
    ax = ev.plot.lateral_force(trace)
    assert "not known where the finger rests" in [text.get_text() for text in ax.texts]
    assert not ev.plot.force(trace).texts
    still = ev.simulate(swipe.replace({"motion": {"speed": 0.0}}), time=np.linspace(0, 0.1, 11))
    for shown, words in ((trace, "not known for 50.4 % of the time (the finger"), (still, "not known (the")):
        page = ev.report(shown, tmp_path / "a.html").read_text()
        assert f"{words} " in page
        assert "The finger rests" in page


def test_a_sweep_holds_it_beside_what_is_known(swipe):
    rests = swipe.replace({"motion": {"speed": 0.0}})
    found = ev.sweep(rests, {"motion.speed": [0.0, 0.03]}, quantity=["mean lateral_force"], records=True)
    assert np.all(np.isnan(found.lateral_force.values[0]))
    assert np.any(np.isfinite(found.lateral_force.values[1]))
    assert np.isnan(found["mean lateral_force"].values).tolist() == [True, False]
    assert "friction at rest" in found.attrs["validity"]


def test_what_is_not_known_is_not_felt(swipe):
    """Perception uses only windows in which the friction is known, and refuses a record without one."""
    sine = {"drive": {"model": "Sine", "amplitude": 500.0, "frequency": 5.0}}
    for wrong, words in (
        ({"motion": {"speed": 0.0}}, r"motion\.speed: the finger rests.*nothing to feel"),
        ({}, r"motion\.time_profile.*every window"),
        (sine, "rests while"),
    ):
        with pytest.raises(InputError, match=words):
            ev.perceive(swipe.replace(wrong))
    long = swipe.replace({"motion.time_profile.hold": 10.0})
    slides = swipe.replace({"motion": {"speed": 0.03}})
    assert ev.perceive(long).level == pytest.approx(ev.perceive(slides).level, abs=1e-9)
