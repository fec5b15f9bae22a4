"""What a recording prescribes drives the model of it, and what contradicts it is refused."""

import numpy as np
import pytest
from twins import GAP, LEAK, TIMES, exact, noisy, plate

import electrovib as ev
from electrovib.core.errors import InputError
from electrovib.core.signals import make_trace
from electrovib.recordings.fit.measured import MeasuredTrace
from electrovib.recordings.fit.of_scenario import fit_scenario

FORCE, FRICTION = "electrostatic_force", "friction.coefficient"
TRUE = {GAP: 3e-6, LEAK: 2e-9}


def recorded(scenario, *, seed=1, name="a", noise=0.3, **changes):
    """A force and the voltage that made it, with noise on both."""
    rng = np.random.default_rng([41, seed])
    trace = noisy(exact(scenario, "step"), rng)
    voltage = scenario.drive.voltage(TIMES) + noise * rng.normal(size=TIMES.size)
    return MeasuredTrace(trace=trace.assign(drive_voltage=(("time",), voltage)), name=name, changes=changes)


def assert_true(found):
    for name, value in TRUE.items():
        error = abs(found.estimate.values[name] - value)
        assert error < 4 * found.estimate.standard_deviations[name] < 0.1 * value
    assert not found.misfit.reasons


def test_a_voltage_series_is_fitted_with_the_voltages_of_its_recordings():
    """The scenario's 300 V stand in none of them: taken for 100 V they would make the gap 3 times too wide."""
    series = [
        recorded(plate(**{"drive.high": f"{level} V"}), seed=level, name=f"{level}")
        for level in (75, 100, 150)
    ]
    found = fit_scenario(plate(**{"drive.high": "300 V"}), series, free=[GAP, LEAK])
    assert_true(found)
    assert len(found.prescribed) == 3
    assert "150: the drive has up to 15" in found.prescribed[2]
    assert "300 V in the scenario" in found.prescribed[2]
    drive = found.problem.prediction.prepared[2].base.drive
    assert drive.model_dump()["high"] == pytest.approx(150, rel=2e-3)
    assert found.scenario.drive.high == 300
    judged = {each.name: each for each in found.diagnostics}
    # the highest that any recording has
    assert judged["electrowetting"].value == pytest.approx(150, rel=0.01)
    assert judged["field emission"].state == judged["linear skin, stratum_corneum"].state == "ok"


def test_a_declared_drive_keeps_its_formula_and_another_course_is_taken_from_the_samples():
    scenario = plate()
    found = fit_scenario(scenario, recorded(scenario), free=[GAP, LEAK])
    assert found.problem.prediction.prepared[0].base.drive == scenario.drive
    assert not found.prescribed
    assert_true(found)
    ramp = {"model": "Trapezium", "high": "100 V", "rise": "15 ms", "hold": "5 ms", "fall": "9 ms"}
    found = fit_scenario(scenario, recorded(plate(drive=ramp), noise=0.05), free=[GAP, LEAK])
    assert type(found.problem.prediction.prepared[0].base.drive).__name__ == "Sampled"
    assert_true(found)
    high = plate(**{"drive.high": "300 V"})  # that of the scenario is kept where asked
    found = fit_scenario(high, recorded(scenario), free=[GAP, LEAK], keep=["drive"])
    assert found.estimate.values[GAP] > 6e-6


CURRENT = {"drive": {"model": "CurrentSine", "amplitude": "1 uA", "frequency": "100 Hz"}}
STATED = {"drive.high": "300 V"}


@pytest.mark.parametrize(
    ("changes", "stated", "settings", "words"),
    [
        ({}, STATED, {}, r"drive\.high = 300 V was stated.*up to 100\.\d V .* 300 V.*--keep drive"),
        ({}, {}, {"free": ["drive.high"]}, r"drive\.high is free, but.*--keep drive"),
        (CURRENT, {}, {}, "drive_voltage is recorded, but the scenario prescribes a current"),
        (STATED, {}, {"keep": ["drives"]}, "expected drive, load or motion"),
    ],
)
def test_what_contradicts_a_recording_is_refused_with_both_numbers(changes, stated, settings, words):
    with pytest.raises(InputError, match=words):
        fit_scenario(plate(**changes), recorded(plate(), **stated), **{"free": [GAP]} | settings)


def test_a_recorded_load_and_speed_drive_the_friction():
    """The load rises from 0.2 to 1 N, which a load of 0.5 N would make a friction that is no Coulomb friction."""
    rng = np.random.default_rng(42)
    time = np.linspace(0, 30e-3, 300)
    load = 0.2 + 0.8 * np.clip((time - 5e-3) / 20e-3, 0, 1)
    pull = ev.prepare(plate(), free=[GAP]).signals([3e-6], names=[FORCE], time=time)[FORCE]
    lateral = 0.42 * (load + pull) + 2e-3 * rng.normal(size=time.size)
    signals = {"lateral_force": lateral, "normal_force": load + 2e-3 * rng.normal(size=time.size)}
    signals["sliding_speed"] = np.full(time.size, 0.03)
    trace = make_trace({name: (("time",), values) for name, values in signals.items()}, {"time": time}, {})
    found = fit_scenario(plate(), trace, free=[FRICTION])
    assert [each.observed.signal for each in found.residuals] == ["lateral_force"]
    assert found.estimate.values[FRICTION] == pytest.approx(0.42, abs=0.003)
    assert not found.misfit.reasons
    kept = fit_scenario(plate(), trace, free=[FRICTION], keep=["load"])
    assert kept.misfit.reasons


def test_a_trace_of_the_model_is_said_to_be_computed_and_its_prescribed_signals_are_not_fitted():
    scenario = ev.load("vezzoli_2014/fig6")
    found = fit_scenario(scenario, ev.simulate(scenario), free=["stack.insulator.thickness"])
    fitted = {each.observed.signal for each in found.residuals}
    assert not fitted & {"normal_force", "drive_voltage", "sliding_speed"}
    assert found.misfit.computed
    assert "these data were computed by this model" in found.misfit.sentence
    noise = 1e-5 * float(ev.simulate(scenario)[FORCE].max()) * np.random.default_rng(1).normal(size=1000)
    trace = ev.simulate(scenario, time=np.linspace(0, 0.3, 1000))[[FORCE]]
    trace[FORCE].values[:] += noise
    assert not fit_scenario(scenario, trace, free=["stack.insulator.thickness"]).misfit.computed
