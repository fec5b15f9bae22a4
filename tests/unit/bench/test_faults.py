"""Every step of the sequence with every fault: 0 V at the plate, a sentence, and the data so far on disk."""

import json
import os
import re
import signal
from types import SimpleNamespace

import numpy as np
import pytest

import electrovib as ev
from electrovib.apps.progress import heard
from electrovib.bench.link import BenchError, BenchStopped
from electrovib.bench.sequence import STEPS, RunRecord, compare, refuse_beyond
from electrovib.bench.settings import Instruments
from electrovib.bench.twin.simulated import SimulatedBench
from electrovib.physics.limits import Limits

SCENARIO = "vezzoli_2014/fig6"
SILENT = {"compare"}
"""Steps in which nothing is sent."""
WITH_BLOCKS = {"low-voltage burst", "full burst", "records"}
AT_ONCE = {"exception": RuntimeError, "keyboard": KeyboardInterrupt, "SIGTERM": None}
COMMUNICATION = {"timeout": TimeoutError, "wrong answer": None, "disconnect": ConnectionResetError}
CASES = [
    *((step, fault) for step in STEPS for fault in AT_ONCE),
    *((step, fault) for step in STEPS if step not in SILENT for fault in COMMUNICATION),
    *((step, "truncated block") for step in STEPS if step in WITH_BLOCKS),
]


class Injector:
    """Faults of the connections, in one step, and the current step."""

    def __init__(self, step, fault):
        self.wanted, self.fault = step, fault
        self.step, self.is_healed, self.fired = "", False, False

    def report(self, step):
        self.step = step
        if step == self.wanted and step in SILENT:
            self.fire()

    @property
    def is_on(self):
        if self.is_healed and self.fault != "disconnect":
            return False
        return self.step == self.wanted or (self.fired and self.fault == "disconnect")

    def fire(self):
        self.fired = True
        if self.fault == "SIGTERM":
            os.kill(os.getpid(), signal.SIGTERM)
        else:
            raise (AT_ONCE | COMMUNICATION)[self.fault]("injected")


class Faulty:
    """A connection that fails as the injector tells."""

    def __init__(self, inner, injector):
        self.inner, self.injector, self.close = inner, injector, inner.close

    def send(self, message):
        if self.injector.is_on and self.injector.fault in {*AT_ONCE, "timeout", "disconnect"}:
            self.injector.fire()
        self.inner.send(message)

    def receive(self):
        reply = self.inner.receive()
        cut_off = reply[:-100] if reply.startswith(b"#") else reply
        spoiled = {"wrong answer": b"banana", "truncated block": cut_off}.get(self.injector.fault, reply)
        if not self.injector.is_on or spoiled == reply:
            return reply
        self.injector.fired = True
        return spoiled


@pytest.fixture
def stopped(tmp_path, monkeypatch, twin_in_place):
    """Run with a fault; return what was raised, the twin, the injector and the file of the incomplete run."""

    def call(step="", fault="", *, with_enable=True, spoil=None):
        injector = Injector(step, fault)

        def healed(instruments, original=Instruments.to_zero):
            injector.is_healed = True
            return original(instruments)

        monkeypatch.setattr(Instruments, "to_zero", healed)
        twins = twin_in_place(
            with_enable=with_enable,
            spoil=spoil and (lambda twin: spoil(twin, injector)),
            wrap=lambda connection: Faulty(connection, injector),
        )
        told = heard("electrovib.bench", lambda step: injector.report(step.getMessage()))
        with told, pytest.raises((BenchError, BenchStopped, KeyboardInterrupt)) as caught:
            ev.run_bench(SCENARIO, simulate=True, output=tmp_path / "t.nc")
        assert not (tmp_path / "t.nc").exists()
        return caught.value, twins[0], injector, ev.open_trace(tmp_path / "t.incomplete.nc")

    return call


def moments():
    """Every case; most of four faults, which take the same path as the others, are left to the slow tests."""
    for step, fault in CASES:
        is_slow = fault not in {"SIGTERM", "disconnect", "truncated block"}
        is_slow = is_slow and step not in {"enable", "compare", "full burst"}
        yield pytest.param(step, fault, marks=[pytest.mark.slow] if is_slow else [])


@pytest.mark.parametrize(("step", "fault"), [*moments()])
def test_a_fault_ends_with_0_v_a_sentence_and_the_data(stopped, at_zero, step, fault):
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


def test_the_twin_starts_in_the_dangerous_state(plan):
    twin = SimulatedBench(plan().settings, plan().scenario, seed=1)
    twin.plant.switch(0.0, on=True)
    twin.clock.sleep(0.25e-3)
    assert abs(twin.plate_voltage()) == pytest.approx(20, rel=1e-6)  # 100 mV into 50 ohm, a gain of 200


def multiplied(factor, when):
    """Let the voltage and the current read back be larger than they are in one step."""

    def spoil(twin, injector):
        inner = twin.plant.input_voltage
        twin.plant.input_voltage = lambda channel, times, trigger: (
            inner(channel, times, trigger) * (factor if injector.step == when and channel in (1, 4) else 1)
        )

    return spoil


def answered(query, reply, when, *, by="generator"):
    """Let an instrument answer a query wrongly in one step; without a reply it tells of one point less than it has."""

    def spoil(twin, injector):
        instrument = getattr(twin, by)
        inner = instrument._queries[query]
        said = reply or (lambda: f"+{len(instrument._memory) - 1}")
        instrument._queries[query] = lambda text: (
            (said() if callable(said) else said) if injector.step == when else inner(text)
        )

    return spoil


def leaking(twin, _):
    """The monitor of the current alone shows a leak: 0.3 mA, above the limit of 250 uA, at the planned voltage."""
    inner, channel = twin.plant.input_voltage, ev.plan_bench(SCENARIO).settings.channels()["current"]

    def read(number, times, trigger):
        leak = 0.3e-3 * channel.resistance * (times > trigger)
        return inner(number, times, trigger) + (leak if number == channel.input else 0.0)

    twin.plant.input_voltage = read


def opened(twin, injector):
    """The enable line opens during the burst."""
    inner = twin.generator.on_trigger.copy()

    def triggered(time):
        for each in inner:
            each(time)
        if injector.step == "full burst":
            twin.clock.sleep(0.05)
            twin.plant.switch(twin.clock.now(), on=False)

    twin.generator.on_trigger[:] = [triggered]


def unwilling(twin, _):
    twin.operate = lambda words: " ON" not in words


def lost(twin, injector):
    """The generator alone is no longer connected."""
    original = twin.generator.send

    def send(message):
        if injector.step == "full burst":
            raise ConnectionResetError("gone")
        original(message)

    twin.generator.send = send


READ_BACK = "a setting does not read back: '"
SETTINGS = {
    "VOLTage": "3.3",
    "FREQuency": "3.3",
    "OUTPut:LOAD": "50",
    "BM:NCYCles": "3.3",
    "VOLTage:OFFSet": "3.3",
}
LOW, FULL = "low-voltage burst", "full burst"
BEYOND = "scaled to the full burst reaches 1.04 kV, above its limit of 1 kV"
ABOVE = r"in the full burst the voltage read back reached 1\.2.*above its limit of 1 kV"
LEAK = "in the low-voltage burst the current read back reached 300"
BAD = {
    "twice the voltage": (multiplied(2.0, LOW), "compare", "a load of 50 ohm", 1, 1),
    # 4 % more than planned is within the tolerance of the comparison, and 1040 V are above the limit of 1 kV
    "beyond the limit at full scale": (multiplied(1.04, LOW), "compare", BEYOND, 1, 1),
    "above the limit": (multiplied(1.2, FULL), FULL, ABOVE, 2, 2),
    "a leak": (leaking, LOW, LEAK, 1, 1),
    "no record": (
        answered("ACQuire:STATE", "1", LOW, by="oscilloscope"),
        LOW,
        "the oscilloscope has not recorded the burst",
        1,
        1,
    ),
    "the enable line opens": (opened, FULL, "the enable line answered '0'.*not known to be enabled", 2, 2),
    "the generator is lost": (lost, FULL, "0 V at the generator is not confirmed", 1, 2),
    # a generator that keeps another amplitude than the full one is found while the plate is still disconnected
    "another amplitude": (answered("VOLTage", "12", "raise"), "raise", rf"{READ_BACK}VOLT\?", 1, 1),
    # the last points lead back to 0 V; one in a thousand is within the tolerance of a number that is not a count
    "points are lost": (
        answered("DATA:ATTRibute:POINts", None, "read back"),
        "read back",
        rf"{READ_BACK}DATA:ATTR:POIN\?",
        0,
        0,
    ),
    **{
        f"{query} before anything is enabled": (
            answered(query, reply, "read back"),
            "read back",
            READ_BACK,
            0,
            0,
        )
        for query, reply in {**SETTINGS, "TRIGger:SOURce": "IMM"}.items()
    },
    **{
        f"{query} changed by hand": (answered(query, reply, FULL), FULL, READ_BACK, 1, 2)
        for query, reply in {"VOLTage": "50", "OUTPut:LOAD": "50", "FREQuency": "50", "BM:STATe": "0"}.items()
    },
}
"""What is wrong, the step that stops, its words, and how often a burst was triggered and the high voltage enabled."""


@pytest.mark.parametrize(("spoil", "step", "words", "bursts", "enabled"), BAD.values(), ids=BAD)
def test_a_bench_that_is_not_as_planned_stops_the_run(stopped, at_zero, spoil, step, words, bursts, enabled):
    error, twin, _, trace = stopped(spoil=spoil)
    assert f"stopped in the step '{step}': " in str(error)
    assert re.search(words, str(error), re.DOTALL), error
    assert json.loads(trace.attrs["steps"])[-1] == step
    assert twin.generator.received.count("*TRG") == bursts
    assert len([on for _, on in twin.plant._switched if on]) == enabled
    assert not twin.plant.is_on
    assert at_zero(twin)
    assert "lateral_force" not in trace


def test_what_was_read_above_a_limit_is_in_the_record(stopped, at_zero):
    """Also without an enable line; a plate at twice the voltage was found at 40 V instead of 20 V."""
    error, twin, _, trace = stopped(with_enable=False, spoil=multiplied(1.2, "full burst"))
    assert "above its limit of 1 kV" in str(error)
    assert float(trace.plate_voltage.max()) > 1150
    assert at_zero(twin)
    *_, trace = stopped(spoil=multiplied(2.0, "low-voltage burst"))
    assert float(trace.plate_voltage.max()) == pytest.approx(40, rel=0.1)
    assert float(trace.drive_voltage.max()) == pytest.approx(20, rel=1e-3)


def test_without_an_enable_line_an_operator_who_refuses_stops_the_run(stopped, at_zero):
    error, twin, _, _ = stopped(with_enable=False, spoil=unwilling)
    assert "stopped in the step 'enable': the operator did not confirm" in str(error)
    assert "*TRG" not in twin.generator.received
    assert at_zero(twin)


def test_amplitude_and_records_are_touched_only_while_the_high_voltage_is_disabled(stopped):
    """A voltage above its limit by the resolution of the low-voltage burst alone is played; nothing is ever reset."""
    records, amplitudes = [], []

    def spoil(twin, injector):
        multiplied(1.01, "low-voltage burst")(twin, injector)
        curve, voltage = twin.oscilloscope._queries["CURVe"], twin.generator._commands["VOLTage"]

        def read(text):
            records.append((injector.step, twin.plant.is_on))
            return curve(text)

        def set_to(text):
            amplitudes.append((float(text), twin.plant.is_on))
            return voltage(text)

        twin.oscilloscope._queries["CURVe"] = read
        twin.generator._commands["VOLTage"] = set_to

    error, twin, _, _ = stopped("records", "exception", spoil=spoil)
    assert "stopped in the step 'records'" in str(error)
    assert set(records) == {("low-voltage burst", False), ("full burst", False)}
    assert amplitudes == [(pytest.approx(0.2), False), (pytest.approx(10), False)]
    assert twin.generator.received.count("*TRG") == 2
    assert not [command for command in twin.generator.received if command.startswith("*RST")]


BURST = np.linspace(-1, 2, 3001)
HALF = ((BURST >= 0) & (BURST <= 0.5)).astype(float)
"""A root mean square of 0.707 of a burst of 1 s; what lies outside of it does not count."""
PEAK = 1.2 * np.sin(2 * np.pi * BURST) ** 2 - 0.1
"""Between -0.1 and 1.1."""


@pytest.mark.parametrize("name", ["voltage", "current"])
@pytest.mark.parametrize(
    ("values", "limits", "tolerated", "words"),
    [
        (HALF, {"": 1.0, "rms_": 0.71}, 0.0, None),
        (HALF, {"": 1.0, "rms_": 0.7}, 0.01, None),
        (
            HALF,
            {"": 1.0, "rms_": 0.7},
            0.0,
            r"the rms {} read back reached 70[0-9.]+ m., above its limit of 700 m",
        ),
        (PEAK, {"": 1.11}, 0.0, None),
        (-PEAK, {"": 1.11}, 0.0, None),
        (PEAK, {"": 1.09}, 0.0, r"the {} read back reached 1\.1 ., above its limit of 1\.09"),
        (-PEAK, {"": 1.09}, 0.0, r"the {} read back reached 1\.1 ., above its limit of 1\.09"),
    ],
)
def test_a_peak_of_either_sign_or_an_rms_above_its_limit_stops(name, values, limits, tolerated, words):
    record = RunRecord(burst="full burst", time=BURST, channels={name: values})
    allowed = Limits(**{f"{kind}{name}": value for kind, value in limits.items()})
    plan = SimpleNamespace(limits=allowed, duration=1.0)
    if words is None:
        refuse_beyond(plan, record, name, tolerated)
        return
    with pytest.raises(BenchError, match=words.format(name)):
        refuse_beyond(plan, record, name, tolerated)


AROUND = np.linspace(-0.1, 0.9, 10_001)
HUMP = np.where(AROUND >= 0, 100 * np.sin(np.pi * np.clip(AROUND / 0.9, 0, 1)) ** 2, 0.0)
SINE = 100 * np.sin(2 * np.pi * np.linspace(0, 1, 10_001))


@pytest.mark.parametrize(
    ("wanted", "added", "words"),
    [
        (HUMP, 4.0 * (AROUND < 0), None),
        # a residual voltage of 8 % before the trigger alone: scale and shape are within the tolerance of 5 %
        (HUMP, 8.0 * (AROUND < 0), "the plate is at 8 V, where 0 V was expected"),
        (HUMP, -8.0 * (AROUND < 0), "the plate is at -8 V, where 0 V was expected"),
        # a third harmonic of 10 %, orthogonal to the plan: the scale is right, the rms difference 7.1 % of the peak
        (
            SINE,
            10 * np.sin(6 * np.pi * np.linspace(0, 1, 10_001)),
            r"another shape: 1 times the plan, rms difference 7\.1 % of the peak",
        ),
    ],
    ids=["little charge", "charged", "charged, negative", "another shape"],
)
def test_a_charged_plate_or_another_shape_stops_the_run(wanted, added, words):
    settings = SimpleNamespace(burst=SimpleNamespace(tolerance=0.05))
    plan = SimpleNamespace(voltage=lambda _: wanted, peak=100.0, settings=settings)
    time = AROUND if wanted is HUMP else np.linspace(0, 1, 10_001)
    record = RunRecord(burst="full burst", time=time, channels={"voltage": wanted + added})
    if words is None:
        compare(plan, record, fraction=1.0, step=0.0)
        return
    with pytest.raises(BenchError, match=words):
        compare(plan, record, fraction=1.0, step=0.0)
