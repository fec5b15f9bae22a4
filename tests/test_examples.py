"""Every example runs and one number of it is asserted."""

import importlib.util
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
from vezzoli_fingers import lateral_by_law

import electrovib as ev

ROOT = Path(__file__).parent.parent


def example(name: str) -> ModuleType:
    spec = importlib.util.spec_from_file_location(name, ROOT / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.fixture
def drawn(tmp_path):
    """Return a function that draws the figure of an example, or saves one, and sees that there is something on it."""

    def draw(module, *of, into=False):
        file = tmp_path / "figure.png"
        if into:
            module.draw(*of, file)
        else:
            module.draw(*of).savefig(file)
        assert file.stat().st_size > 5000

    return draw


def test_step_by_hand():
    # 1e-12 of the 1000 V step: rounding of exp over 2000 samples
    assert example("step_by_hand").main() < 1e-9


def test_insulator_sweep():
    force = example("insulator_sweep").main()
    film = 1e-6 / 3.35 + 5e-6 + 200e-6 / 1560
    # the conducting skin drops out during the 1 s hold: between skin as dielectric and skin as conductor
    low = 8.8541878128e-12 * 1e-4 * 100**2 / 2 / film**2
    high = 8.8541878128e-12 * 1e-4 * 100**2 / 2 / (film - 200e-6 / 1560) ** 2
    assert low < force[0] <= high * (1 + 1e-13)
    assert np.all(np.diff(force) < 0)


def test_measured_drive():
    # static force at 300 V by law (1) is 5.0898 mN; the pulse rises within one sample of 78 us against 7.7 ms
    assert 0.98 * 5.0898e-3 < example("measured_drive").main() < 5.0898e-3


def test_field_solution(drawn):
    module = example("field_solution")
    planar, work, fringe, leaky = np.abs(module.main())
    # asked: 0.1 % of the Maxwell stress in the gap law and of the leaky stack; stated: 0.02 % between stress and virtual work,
    # 4 % of an excess that is 3 % of the force for the correction
    assert planar < 1e-3
    assert work < 2e-4
    assert fringe < 2e-3
    assert leaky < 1e-3
    drawn(module, into=True)


def test_measured_swipe(drawn):
    module = example("measured_swipe")
    swipe = module.main()
    low, high = swipe.friction.ends
    assert low <= 0.4 <= high
    # the zero drifts linearly in time, so the straight line is right: noise of 3 mV over 18 000 samples
    # and the 50 ms in which friction sets in leave less than 1 %
    assert swipe.friction.value == pytest.approx(0.4, rel=1e-2)
    assert max(swipe.friction.choices.values()) > 0.43
    drawn(module, swipe)


def test_clutch_release(drawn):
    module = example("clutch_release")
    release = module.main()
    # noise of 5 mN on 0.7 N over about 110 samples
    found = release.parameters
    assert release.form == "exponential"
    assert found["frequency"].value == pytest.approx(350, rel=5e-3)
    assert found["quality"].value == pytest.approx(3, rel=3e-2)
    # the end of the drive is known to half of 78 us
    for name, true in (("frequency", 350), ("quality", 3), ("delay", 0.4e-3), ("time_constant", 0.1e-3)):
        assert found[name].lower < true < found[name].upper
    assert release.misfit < 1.2
    drawn(module, release)


@pytest.mark.slow
def test_whole_experiment(drawn):
    module = example("whole_experiment")
    found = {law: module.main(scenario, fingers=2, bursts=2) for law, scenario in module.LAWS.items()}
    base = ev.load("vezzoli_2014/fig6", changes=module.SET_UP)
    fingers = ev.read_space(base, "fingers").draw(module.SEED, 0, 2)
    at_end = lateral_by_law(fingers, ramp=module.RISE) * fingers["contact.area"] / base.contact_area
    by_law, in_gap = found.values()
    for each, force in zip(by_law, at_end, strict=True):
        # the last 4 ms of the rise are averaged, in which the force still grows
        assert 0.95 * force < each.at_the_top(each.own) <= force
    for each in (*by_law, *in_gap):
        # noise and rounding of 1 mN over 2 x 100 readings, and over 2 x 500 of the baseline: five times their root mean square
        assert each.at_the_top(each.recorded) == pytest.approx(each.at_the_top(each.own), abs=0.45e-3)
        # the reading of the normal force has decayed by exp(-0.08 s/10 s), and its rounding is 4 mN
        assert each.friction == pytest.approx(each.true_friction, rel=0.015)
    assert max(each.at_the_top(each.own) for each in by_law) < module.PAPER[0] / 2
    assert max(each.attraction for each in in_gap) > 20e-3
    assert "the paper states 2 to 5 mN" in module.table(by_law)
    drawn(module, found)


def test_every_example_is_tested():
    tested = {name.removeprefix("test_") for name in globals() if name.startswith("test_")}
    assert {path.stem for path in (ROOT / "examples").glob("*.py")} <= tested


@pytest.mark.slow
def test_stick_slip(drawn):
    module = example("stick_slip")
    traces = module.main()
    largest = {label: float(trace.lateral_force.max()) for label, trace in traces.items()}
    # 1.5 x 0.5 x 0.5 N at rest, less what it has fallen to while the contact creeps
    assert 0.33 < largest["no voltage"] < 0.375
    # 0.5 N and 151.9 mN of attraction: the whole curve of friction is as much higher
    assert largest["500 V held"] / largest["no voltage"] == pytest.approx(1 + 0.1519 / 0.5, rel=0.02)
    assert largest["500 V, force at 100 Hz"] < largest["500 V held"] - 0.05
    assert all(trace.attrs["friction_events"] > 10 for trace in traces.values())
    drawn(module, traces)


def test_constant_force(drawn):
    module = example("constant_force")
    module.CARRIERS = module.CARRIERS[[0, 6, 12]]  # ends and middle of the curve
    direct, carriers, predicted = module.main()
    # V0 (1 + t/tau) inside 1 kV for 1 s, tau = 7.7 ms: 56.55 mN (1/131)^2; the ramp from 0 V adds to the time
    assert direct == pytest.approx(56.55e-3 / (1 + 1 / 7.7e-3) ** 2, rel=0.02)
    # 250 uA at 3 kHz is 404 V on the film alone, 4.6 mN by equation (1)
    assert predicted[0] == pytest.approx(4.62e-3, rel=5e-3)
    # 33 pF of film and 100 pF of stray capacitance share the current
    assert predicted[1] / predicted[0] == pytest.approx((32.96 / 132.96) ** 2, rel=0.02)
    place = int(np.argmin(np.abs(module.CARRIERS - 3e3)))
    for stray, force in zip(module.STRAY, predicted, strict=True):
        slope = (module.CARRIERS[place] / 3e3) ** 2
        assert force == pytest.approx(carriers[stray][place] * slope, rel=5e-3)
    drawn(module, direct, carriers, into=True)


def test_pull_in(drawn):
    module = example("pull_in")
    loop, snap = module.main()
    # a linear spring shortened by the load: V^2 = 8 k (K + g)^3/(27 eps0), g = 20 um less 200 Pa over 1e8 Pa/m
    assert snap == pytest.approx((8 * 1e8 * (5e-6 + 18e-6) ** 3 / (27 * 8.8541878128e-12)) ** 0.5, rel=1e-9)
    jumped = loop.up.voltage[loop.up.jump]
    assert len(jumped) == 1
    assert 0 <= jumped[0] - snap < 0.5
    assert loop.down.voltage[loop.down.jump][0] < 0.6 * snap
    drawn(module, loop, snap)


def test_picture_texture(drawn, tmp_path):
    module = example("picture_texture")
    rendered = module.main(tmp_path)
    # asked: the force averaged over a carrier period to 1 %, the stream equal to the drive to 1e-9
    assert 0 < rendered.drive.misfit < 0.01
    assert rendered.difference < 1e-9
    drawn(module, rendered, into=True)
