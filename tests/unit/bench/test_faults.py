"""Every step of the sequence with every fault: 0 V at the plate, a sentence, and the data so far on disk."""

import functools
import json
import os
import signal
from types import SimpleNamespace

import numpy as np
import pytest

import electrovib as ev
from electrovib.bench import run
from electrovib.bench.faults import BenchError, BenchStopped
from electrovib.bench.instruments import Instruments
from electrovib.bench.sequence import STEPS, RunRecord, compare, refuse_beyond
from electrovib.bench.twin.simulated import SimulatedBench
from electrovib.physics.limits import Limits

SCENARIO = "vezzoli_2014/fig6"
ENABLE = {"on": "OUTP ON", "off": "OUTP OFF", "state": "OUTP?"}
ORIGINAL = run.plan_bench
SILENT = {"compare"}
"""Steps in which nothing is sent."""
WITH_BLOCKS = {"low-voltage burst", "full burst", "records"}
AT_ONCE = {"exception": RuntimeError, "keyboard": KeyboardInterrupt, "SIGTERM": None}
COMMUNICATION = ("timeout", "wrong answer", "disconnect")
CASES = [
    *((step, fault) for step in STEPS for fault in AT_ONCE),
    *((step, fault) for step in STEPS if step not in SILENT for fault in COMMUNICATION),
    *((step, "truncated block") for step in STEPS if step in WITH_BLOCKS),
]


def settings(*, with_enable=True):
    content = ORIGINAL(SCENARIO).settings.to_dict()
    content["amplifier"]["enable"] = ENABLE if with_enable else None
    return content


@functools.cache
def plan(with_enable):
    return ORIGINAL(SCENARIO, bench=settings(with_enable=with_enable))


class Injector:
    """Faults of the connections, in one step, and the current step."""

    def __init__(self, step, fault):
        self.wanted, self.fault = step, fault
        self.step, self.is_healed, self.fired = "", False, False

    def report(self, step):
        self.step = step
        if step == self.wanted and step in SILENT:
            self.at_once()

    @property
    def is_on(self):
        if self.is_healed and self.fault != "disconnect":
            return False
        return self.step == self.wanted or (self.fired and self.fault == "disconnect")

    def at_once(self):
        self.fired = True
        if self.fault == "SIGTERM":
            os.kill(os.getpid(), signal.SIGTERM)
        else:
            raise AT_ONCE[self.fault]("injected")


class Faulty:
    """A connection that fails as the injector tells."""

    def __init__(self, inner, injector):
        self.inner, self.injector = inner, injector

    def send(self, message):
        injector = self.injector
        if injector.is_on and injector.fault in AT_ONCE:
            injector.at_once()
        if injector.is_on and injector.fault == "disconnect":
            injector.fired = True
            raise ConnectionResetError("the cable was pulled")
        if injector.is_on and injector.fault == "timeout":
            injector.fired = True
            raise TimeoutError
        self.inner.send(message)

    def receive(self):
        injector, reply = self.injector, self.inner.receive()
        if injector.is_on and injector.fault == "wrong answer":
            injector.fired = True
            return b"banana"
        if injector.is_on and injector.fault == "truncated block" and reply.startswith(b"#"):
            injector.fired = True
            return reply[:-100]
        return reply

    def close(self):
        self.inner.close()


@pytest.fixture
def stopped(tmp_path, monkeypatch):
    """Run with a fault; return what was raised, the twin, the injector and the file of the incomplete run."""

    def call(step, fault, *, with_enable=True, spoil=None):
        injector, twins = Injector(step, fault), []

        class Spoiled(SimulatedBench):
            def __init__(self, *arguments, **named):
                super().__init__(*arguments, **named)
                twins.append(self)
                if spoil:
                    spoil(self, injector)

            @property
            def connections(self):
                inner = super().connections
                return {name: Faulty(each, injector) for name, each in inner.items()}

        def healed(instruments, original=Instruments.to_zero):
            injector.is_healed = True
            return original(instruments)

        monkeypatch.setattr(run, "SimulatedBench", Spoiled)
        monkeypatch.setattr(Instruments, "to_zero", healed)
        monkeypatch.setattr(run, "plan_bench", lambda *_, **__: plan(with_enable))
        with pytest.raises((BenchError, BenchStopped, KeyboardInterrupt)) as caught:
            ev.run_bench(SCENARIO, simulate=True, output=tmp_path / "t.nc", report=injector.report)
        assert not (tmp_path / "t.nc").exists()
        return caught.value, twins[0], injector, ev.open_trace(tmp_path / "t.incomplete.nc")

    return call


def at_zero(twin):
    """Voltage of the plate after one burst."""
    twin.clock.sleep(plan(with_enable=True).duration)
    return twin.plate_voltage() == 0


def slow_apart_from_bursts(step, fault):
    """Most cases of four faults, which take the same path as the others, are left to the slow tests."""
    slow = fault in {"exception", "keyboard", "timeout", "wrong answer"} and step not in {
        "enable",
        "compare",
        "full burst",
    }
    return pytest.param(step, fault, marks=[pytest.mark.slow] if slow else [])


@pytest.mark.parametrize(("step", "fault"), [slow_apart_from_bursts(*case) for case in CASES])
def test_a_fault_ends_with_0_v_a_sentence_and_the_data(stopped, step, fault):
    error, twin, injector, trace = stopped(step, fault)
    assert injector.fired
    kind = {"keyboard": KeyboardInterrupt, "SIGTERM": BenchStopped}.get(fault, BenchError)
    assert type(error) is kind
    assert f"stopped in the step '{step}': " in str(error)
    assert "Traceback" not in str(error)
    assert str(trace.attrs["stopped"]).startswith(f"stopped in the step '{step}'")
    assert json.loads(trace.attrs["steps"])[-1] == step
    assert "drive_voltage" in trace
    assert at_zero(twin)
    if fault == "disconnect":
        assert "SWITCH THE HIGH VOLTAGE OFF BY HAND" in str(error)
    else:
        assert not twin.plant.is_on
        assert "the generator is at 0 V, and the high voltage is disabled" in str(error)
    if step in {"compare", "raise", "full burst", "records"}:
        assert "plate_voltage" in trace


def test_the_twin_starts_in_the_dangerous_state():
    twin = SimulatedBench(plan(with_enable=True).settings, plan(with_enable=True).scenario, seed=1)
    twin.plant.switch(0.0, on=True)
    twin.clock.sleep(0.25e-3)
    assert abs(twin.plate_voltage()) == pytest.approx(20, rel=1e-6)  # 100 mV into 50 ohm, a gain of 200


def multiplied(factor, when):
    def spoil(twin, injector):
        inner = twin.plant.input_voltage

        def wrong(channel, times, trigger):
            return inner(channel, times, trigger) * (
                factor if injector.step == when and channel in (1, 4) else 1
            )

        twin.plant.input_voltage = wrong

    return spoil


@pytest.mark.parametrize("with_enable", [True, False])
def test_a_read_back_above_the_limit_stops_the_run(stopped, with_enable):
    error, twin, _, trace = stopped("", "", with_enable=with_enable, spoil=multiplied(1.2, "full burst"))
    assert "in the full burst the voltage read back reached 1.2" in str(error)
    assert "above its limit of 1 kV" in str(error)
    assert float(trace.plate_voltage.max()) > 1150
    assert at_zero(twin)
    assert "lateral_force" not in trace


def test_twice_the_voltage_is_found_by_the_low_voltage_burst(stopped):
    error, twin, _, trace = stopped("", "", spoil=multiplied(2.0, "low-voltage burst"))
    assert "stopped in the step 'compare'" in str(error)
    assert "a load of 50 ohm" in str(error)
    assert float(trace.plate_voltage.max()) == pytest.approx(40, rel=0.1)
    assert float(trace.drive_voltage.max()) == pytest.approx(20, rel=1e-3)
    assert at_zero(twin)


def test_a_voltage_that_would_exceed_its_limit_at_full_scale_is_refused_before_the_full_burst(stopped):
    """4 % more than planned is within the tolerance of the comparison, and 1040 V are above the limit of 1 kV."""
    error, twin, _, trace = stopped("", "", spoil=multiplied(1.04, "low-voltage burst"))
    assert "stopped in the step 'compare'" in str(error)
    assert "scaled to the full burst reaches 1.04 kV, above its limit of 1 kV" in str(error)
    assert json.loads(trace.attrs["steps"])[-1] == "compare"
    assert twin.generator.received.count("*TRG") == 1
    assert at_zero(twin)


def test_a_voltage_above_its_limit_by_the_resolution_of_the_low_voltage_burst_alone_is_played(stopped):
    error, twin, _, _ = stopped("records", "exception", spoil=multiplied(1.01, "low-voltage burst"))
    assert "stopped in the step 'records'" in str(error)
    assert twin.generator.received.count("*TRG") == 2


@pytest.mark.parametrize("query", ["VOLTage", "OUTPut:LOAD", "FREQuency", "BM:STATe"])
def test_a_setting_changed_by_hand_is_found_before_the_trigger(stopped, query):
    def spoil(twin, injector):
        inner = twin.generator._queries[query]
        twin.generator._queries[query] = lambda text: (
            {"BM:STATe": "0"}.get(query, "50") if injector.step == "full burst" else inner(text)
        )

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "stopped in the step 'full burst': a setting does not read back" in str(error)
    assert twin.generator.received.count("*TRG") == 1
    assert not twin.plant.is_on


def test_the_full_amplitude_is_read_back_before_the_high_voltage_is_on_again(stopped):
    """A generator that keeps another amplitude than the full one is found while the plate is still disconnected."""

    def spoil(twin, injector):
        inner = twin.generator._queries["VOLTage"]
        twin.generator._queries["VOLTage"] = lambda text: "12" if injector.step == "raise" else inner(text)

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "stopped in the step 'raise': a setting does not read back: 'VOLT?" in str(error)
    assert [on for _, on in twin.plant._switched if on] == [True], "for the low-voltage burst alone"
    assert twin.generator.received.count("*TRG") == 1


def test_a_current_above_its_limit_stops_the_run_before_the_full_burst(stopped):
    """The monitor of the current alone shows a leak: 0.3 mA, above the limit of 250 uA, at the planned voltage."""

    def spoil(twin, _):
        inner, channel = twin.plant.input_voltage, plan(True).settings.channels()["current"]

        def leaking(number, times, trigger):
            leak = 0.3e-3 * channel.resistance * (times > trigger)
            return inner(number, times, trigger) + (leak if number == channel.input else 0.0)

        twin.plant.input_voltage = leaking

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert (
        "stopped in the step 'low-voltage burst': in the low-voltage burst the current read back reached 300"
        in str(error)
    )
    assert twin.generator.received.count("*TRG") == 1
    assert at_zero(twin)


def test_an_oscilloscope_that_never_finishes_stops_the_run(stopped):
    def spoil(twin, injector):
        inner = twin.oscilloscope._queries["ACQuire:STATE"]
        twin.oscilloscope._queries["ACQuire:STATE"] = lambda text: (
            "1" if injector.step == "low-voltage burst" else inner(text)
        )

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "the oscilloscope has not recorded the burst after" in str(error)
    assert not twin.plant.is_on
    assert at_zero(twin)


def test_an_enable_line_that_opens_during_the_burst_stops_the_run(stopped):
    def spoil(twin, injector):
        inner = twin.generator.on_trigger.copy()

        def opened(time):
            for each in inner:
                each(time)
            if injector.step == "full burst":
                twin.clock.sleep(0.05)
                twin.plant.switch(twin.clock.now(), on=False)

        twin.generator.on_trigger[:] = [opened]

    error, twin, _, trace = stopped("", "", spoil=spoil)
    assert "stopped in the step 'full burst': the enable line answered '0'" in str(error)
    assert "not known to be enabled" in str(error)
    assert "lateral_force" not in trace
    assert at_zero(twin)


def test_the_high_voltage_is_disabled_before_a_record_is_transferred(stopped):
    seen = []

    def spoil(twin, injector):
        inner = twin.oscilloscope._queries["CURVe"]
        twin.oscilloscope._queries["CURVe"] = lambda text: (
            seen.append((injector.step, twin.plant.is_on)),
            inner(text),
        )[1]

    stopped("records", "exception", spoil=spoil)
    assert seen
    assert not any(on for _, on in seen)
    assert {step for step, _ in seen} == {"low-voltage burst", "full burst"}


@pytest.mark.parametrize("name", ["voltage", "current"])
def test_a_root_mean_square_above_its_limit_stops_the_run(name):
    """A rectangle of 1 over half of the burst has a root mean square of 0.707; what lies outside of it does not count."""
    time = np.linspace(-1, 2, 3001)
    record = RunRecord(
        burst="full burst", time=time, channels={name: ((time >= 0) & (time <= 0.5)).astype(float)}
    )

    def limited(value):
        return SimpleNamespace(limits=Limits(**{name: 1.0, f"rms_{name}": value}), duration=1.0)

    refuse_beyond(limited(0.71), record, name, 0.0)
    with pytest.raises(
        BenchError, match=f"the rms {name} read back reached 70[0-9.]+ m[VA], above its limit of 700 m"
    ):
        refuse_beyond(limited(0.7), record, name, 0.0)
    refuse_beyond(limited(0.7), record, name, 0.01)


@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("name", ["voltage", "current"])
def test_a_peak_of_either_sign_above_its_limit_stops_the_run(name, sign):
    time = np.linspace(0, 1, 1001)
    record = RunRecord(
        burst="full burst", time=time, channels={name: sign * (1.2 * np.sin(2 * np.pi * time) ** 2 - 0.1)}
    )
    for limit in (1.11, 1.09):
        plan = SimpleNamespace(limits=Limits(**{name: limit}), duration=1.0)
        if limit > 1.1:
            refuse_beyond(plan, record, name, 0.0)
            continue
        with pytest.raises(
            BenchError, match=rf"the {name} read back reached 1\.1 [VA], above its limit of 1\.09"
        ):
            refuse_beyond(plan, record, name, 0.0)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_plate_that_is_charged_before_the_burst_stops_the_run(sign):
    """A residual voltage of 8 % before the trigger alone: scale and shape are within the tolerance of 5 %."""
    time = np.linspace(-0.1, 0.9, 10_001)
    wanted = np.where(time >= 0, 100 * np.sin(np.pi * np.clip(time / 0.9, 0, 1)) ** 2, 0.0)
    plan = SimpleNamespace(
        voltage=lambda _: wanted, peak=100.0, settings=SimpleNamespace(burst=SimpleNamespace(tolerance=0.05))
    )
    for residual, stops in ((4.0, False), (8.0, True)):
        found = wanted + np.where(time < 0, sign * residual, 0.0)
        record = RunRecord(burst="full burst", time=time, channels={"voltage": found})
        if not stops:
            compare(plan, record, fraction=1.0, step=0.0)
            continue
        with pytest.raises(
            BenchError, match=rf"the plate is at {'-' if sign < 0 else ''}8 V, where 0 V was expected"
        ):
            compare(plan, record, fraction=1.0, step=0.0)


def test_another_shape_of_the_same_size_stops_the_run():
    """A third harmonic of 10 %, orthogonal to the plan: the scale is right, the rms difference 7.1 % of the peak."""
    time = np.linspace(0, 1, 10_001)
    wanted = 100 * np.sin(2 * np.pi * time)
    plan = SimpleNamespace(
        voltage=lambda _: wanted, peak=100.0, settings=SimpleNamespace(burst=SimpleNamespace(tolerance=0.05))
    )
    found = wanted + 10 * np.sin(6 * np.pi * time)
    record = RunRecord(burst="full burst", time=time, channels={"voltage": found})
    with pytest.raises(
        BenchError, match=r"another shape: 1 times the plan, rms difference 7\.1 % of the peak"
    ):
        compare(plan, record, fraction=1.0, step=0.0)


def test_the_amplitude_is_changed_only_while_the_high_voltage_is_disabled(stopped):
    seen = []

    def spoil(twin, injector):
        inner = twin.generator._commands["VOLTage"]
        twin.generator._commands["VOLTage"] = lambda text: (
            seen.append((float(text), twin.plant.is_on)),
            inner(text),
        )

    stopped("records", "exception", spoil=spoil)
    assert seen == [(pytest.approx(0.2), False), (pytest.approx(10), False)]


def test_without_an_enable_line_an_operator_who_refuses_stops_the_run(stopped):
    def spoil(twin, injector):
        twin.operate = lambda words: " ON" not in words

    error, twin, _, _ = stopped("", "", with_enable=False, spoil=spoil)
    assert "stopped in the step 'enable': the operator did not confirm" in str(error)
    assert at_zero(twin)


def test_a_lost_generator_alone_leaves_the_high_voltage_disabled(stopped):
    def spoil(twin, injector):
        def lost(message):
            raise ConnectionResetError("gone")

        original = twin.generator.send

        def send(message):
            if injector.step == "full burst":
                lost(message)
            original(message)

        twin.generator.send = send

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "0 V at the generator is not confirmed" in str(error)
    assert not twin.plant.is_on


def test_the_generator_is_never_reset(stopped):
    _, twin, _, _ = stopped("records", "exception")
    assert twin.generator.received
    assert not [command for command in twin.generator.received if command.startswith("*RST")]


@pytest.mark.parametrize(
    "query", ["VOLTage", "FREQuency", "OUTPut:LOAD", "BM:NCYCles", "TRIGger:SOURce", "VOLTage:OFFSet"]
)
def test_a_setting_that_does_not_read_back_stops_the_run_before_anything_is_enabled(stopped, query):
    def spoil(twin, injector):
        inner = twin.generator._queries[query]
        wrong = {"TRIGger:SOURce": "IMM", "OUTPut:LOAD": "50"}.get(query, "3.3")
        twin.generator._queries[query] = lambda text: wrong if injector.step == "read back" else inner(text)

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "stopped in the step 'read back': a setting does not read back: '" in str(error)
    assert [on for _, on in twin.plant._switched if on] == []


def test_a_waveform_that_lost_its_last_points_is_not_played(stopped):
    """The last points lead back to 0 V; one in a thousand is within the tolerance of a number that is not a count."""

    def spoil(twin, injector):
        twin.generator._queries["DATA:ATTRibute:POINts"] = lambda _: f"+{len(twin.generator._memory) - 1}"

    error, twin, _, _ = stopped("", "", spoil=spoil)
    assert "stopped in the step 'read back': a setting does not read back: 'DATA:ATTR:POIN?" in str(error)
    assert [on for _, on in twin.plant._switched if on] == []
