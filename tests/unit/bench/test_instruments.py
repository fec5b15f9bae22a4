"""Drivers and simulated instruments: commands, blocks and replies."""

import json
import socket
import sys
from unittest.mock import MagicMock

import numpy as np
import pytest

import electrovib as ev
from electrovib.bench.drivers.hp_33120a import Hp33120a, mismatches
from electrovib.bench.drivers.tektronix_tds3014b import TektronixTds3014b, time_scale, volt_scale
from electrovib.bench.link import BenchError, Link, SimulatedClock, connect
from electrovib.bench.run import one_process
from electrovib.bench.settings import read_settings
from electrovib.bench.twin.generator import TwinGenerator, matches
from electrovib.bench.twin.simulated import TwinOscilloscope
from electrovib.core.errors import InputError

SCENARIO = "vezzoli_2014/fig6"


class Ramp:
    """An input with 1 V per second from the trigger on."""

    def input_voltage(self, channel, times, trigger):
        return channel * (times - trigger)


@pytest.fixture
def generator():
    clock = SimulatedClock()
    twin = TwinGenerator(clock)
    return clock, twin, Hp33120a(Link("generator", twin))


@pytest.fixture
def oscilloscope():
    clock = SimulatedClock()
    twin = TwinOscilloscope(clock, Ramp())
    return clock, twin, TektronixTds3014b(Link("oscilloscope", twin))


def output(clock, twin):
    return float(twin.voltage(np.array([clock.now()]))[0])


def ready(driver, *, load=True):
    driver.identify()
    driver.zero()
    driver.set_burst()
    driver.set_trigger()
    if load:
        driver.set_load()
    driver.download(np.array([0, 1000, 2000, 2047, -2047, 1000, 500, 0], np.int16), 0.8, 10.0)


def test_a_burst_is_played_once_and_rests_at_0_v(generator):
    """No driver sends a reset, which is followed by a continuous sine, as the state before the first command is."""
    clock, twin, driver = generator
    clock.sleep(0.25e-3)
    assert output(clock, twin) == pytest.approx(0.1)
    ready(driver)
    assert output(clock, twin) == 0
    driver.trigger()
    clock.sleep(0.35)
    assert output(clock, twin) == pytest.approx(5)
    clock.sleep(0.1)
    assert output(clock, twin) == pytest.approx(-5)
    for _ in range(20):
        clock.sleep(0.5)
        assert output(clock, twin) == 0
    assert driver.link.ask("FUNC:SHAP?") == "USER"
    assert not [command for command in twin.received if "RST" in command]
    twin.send(b"*RST")
    clock.sleep(0.25e-3)
    assert output(clock, twin) == pytest.approx(0.1)


def test_a_load_of_50_ohm_doubles_the_open_voltage(generator):
    clock, twin, driver = generator
    ready(driver, load=False)
    assert float(driver.link.ask("VOLT?")) == pytest.approx(10)
    driver.trigger()
    clock.sleep(0.35)
    assert output(clock, twin) == pytest.approx(10)
    driver.set_load()
    assert float(driver.link.ask("VOLT?")) == pytest.approx(20)
    with pytest.raises(BenchError, match="-222"):  # by the generator itself
        driver.set_amplitude(21.0)
    twin.send(b"OUTP:LOAD 50")
    twin._commands["OUTPut:LOAD"] = lambda _: None
    with pytest.raises(BenchError, match=r"reports a load of 50 ohm.*twice as much"):
        driver.set_load()


def test_waveforms_that_do_not_fit_or_do_not_rest_at_0_are_refused(generator):
    _, twin, driver = generator
    for codes, words in (
        ([0] * 7, "7 points"),
        ([0] * 7 + [1], "begins and ends at 0 V"),
        ([0, 3000, *[0] * 6], "3000"),
        ([0, -32768, *[0] * 6], "32768"),
    ):
        with pytest.raises(BenchError, match=words):
            driver.download(np.array(codes, np.int16), 0.8, 10.0)
    twin.send(b"DATA:DAC VOLATILE, #216" + np.full(8, 3000, ">i2").tobytes())
    assert driver.link.ask("SYST:ERR?").startswith("-222")
    # points go out with the most significant byte first
    ready(driver)
    assert twin._memory[:4] == (0, 1000, 2000, 2047)
    twin.send(b"FORM:BORD SWAP")
    twin.send(b"DATA:DAC VOLATILE, #216" + np.array([0, 1, 2, 3, 4, 5, 6, 0], "<i2").tobytes())
    assert twin._memory == (0, 1, 2, 3, 4, 5, 6, 0)


def test_the_oscilloscope_records_before_and_after_the_trigger(oscilloscope):
    clock, twin, driver = oscilloscope
    length = driver.set_time(0.85)
    step = driver.set_channel(2, -1.0, 3.0)
    assert length == pytest.approx(1.0)
    driver.start()
    assert not driver.is_ready()
    twin.synchronise(clock.now())  # too early: the part before the trigger is not filled
    assert not driver.is_done()
    clock.sleep(0.1)
    assert driver.is_ready()
    twin.synchronise(clock.now())
    clock.sleep(0.89)
    assert not driver.is_done()
    clock.sleep(0.02)
    assert driver.is_done()
    times, voltages = driver.record(2)
    assert times.size == 10_000
    assert times[[0, 1000]] == pytest.approx([-0.1, 0.0], abs=1e-6)
    assert np.abs(voltages - 2 * times).max() <= 0.51 * step


class Scripted:
    """An instrument whose replies are given: one to everything, or one to each question."""

    def __init__(self, replies):
        self.replies = replies

    def send(self, message):
        self.asked = message

    def receive(self):
        return self.replies if isinstance(self.replies, bytes) else self.replies[self.asked]


def recorded(preamble, counts):
    """Return what the driver reads of an oscilloscope with a preamble and a curve."""
    data = counts.astype(">i2").tobytes()
    replies = {b"WFMP?": preamble.encode(), b"CURV?": b"#5%d" % len(data) + data}
    return TektronixTds3014b(Link("oscilloscope", Scripted(replies))).record(1)


PREAMBLE = (
    'WFMPRE:BYT_NR 2;BIT_NR 16;ENCDG BIN;BN_FMT RI;BYT_OR MSB;NR_PT 10000;WFID "Ch1; DC";PT_FMT Y;XINCR 2.0E-5;PT_OFF 100;'
    'XZERO 1.0E-3;XUNIT "s";YMULT 1.0E-4;YZERO 5.0E-1;YOFF 1.0E3;YUNIT "V"'
)


def test_a_record_is_scaled_by_its_preamble():
    counts = np.arange(10_000) - 5000
    times, voltages = recorded(PREAMBLE, counts)
    np.testing.assert_allclose(times, 1e-3 + 2e-5 * (np.arange(10_000) - 100), rtol=1e-12)
    np.testing.assert_allclose(voltages, 0.5 + 1e-4 * (counts - 1000), rtol=1e-12)


@pytest.mark.parametrize(
    ("wrong", "words"),
    [
        (("BYT_OR MSB", "BYT_OR LSB"), "samples of the form"),
        (("BYT_NR 2", "BYT_NR 1"), "samples of the form"),
        (("NR_PT 10000", "NR_PT 500"), "announces 500 points of CH1 and sent 10000"),
        (("YMULT 1.0E-4", "YMULT x"), "no number for YMULT"),
        (("XINCR 2.0E-5;", ""), "no number for XINCR"),
    ],
)
def test_a_preamble_that_does_not_fit_is_refused(wrong, words):
    with pytest.raises(BenchError, match=words):
        recorded(PREAMBLE.replace(*wrong), np.zeros(10_000))


def test_scales_hold_the_range():
    for duration in (1e-6, 3e-4, 0.272, 1.0, 9.0):
        assert duration <= 9.0 * time_scale(duration) <= 2.6 * duration
    for low, high in ((0.0, 5.0), (-0.01, 0.01), (1.0, 4.0)):
        assert high - low < 8 * volt_scale(low, high) < 4 * (high - low)
    with pytest.raises(BenchError, match="coarsest"):
        volt_scale(0.0, 100.0)


@pytest.mark.parametrize(("text", "word"), [("TEKTRONIX,TDS 3054C,0,x", "TDS 3054C"), ("banana", "banana")])
def test_another_model_is_refused_unless_it_is_named(oscilloscope, text, word):
    _, twin, driver = oscilloscope
    assert driver.identify().startswith("TEKTRONIX")
    twin.identity = text
    with pytest.raises(BenchError, match=f'set oscilloscope.accept_model = "{word}"'):
        driver.identify()
    named = TektronixTds3014b(Link("oscilloscope", twin), also=word)
    if "," in text:
        assert named.identify() == text


def test_headers_are_short_or_long():
    assert all(matches("VOLTage:OFFSet", header) for header in ("VOLT:OFFS", "voltage:offset"))
    assert not any(matches("VOLTage:OFFSet", header) for header in ("VOLTA:OFFS", "VOLT", "OFFS"))


@pytest.mark.parametrize(
    ("reply", "words"),
    [
        (b"#15abcd", "announced a block of 5 bytes and sent 4"),
        (b"#15abcdef", "sent 6"),
        (b"#15abcde\r\n\n", "sent 8: they are no single block"),
        (b"#3", "where a binary block was expected, after"),
        (b"hello", "where a binary block was expected, after"),
        (b"#0abc", "not one of indefinite length .* set the instrument to definite length"),
        (b":CURVE #15abcde", "stands behind other text; switch headers off"),
    ],
)
def test_blocks_that_are_cut_off_or_too_long_are_refused(reply, words):
    with pytest.raises(BenchError, match=words):
        Link("oscilloscope", Scripted(reply)).ask_block("CURV?")
    for end in (b"", b"\n", b"\r\n"):
        assert Link("oscilloscope", Scripted(b"#15a\r\nde" + end)).ask_block("CURV?") == b"a\r\nde"
    with pytest.raises(BenchError, match="where a number was expected"):
        Link("oscilloscope", Scripted(b"x")).ask_number("ACQ:STATE?")


@pytest.mark.parametrize("end", [b"\n", b"\r\n"])
def test_a_block_over_a_socket_is_whole_whatever_ends_it(end):
    """Before, a block that CR and LF follow was said to be truncated."""
    data = bytes(range(256)) * 12
    with socket.create_server(("127.0.0.1", 0)) as server:
        address = f"TCPIP::127.0.0.1::{server.getsockname()[1]}::SOCKET"
        connection = connect({"oscilloscope": address})["oscilloscope"]
        accepted, _ = server.accept()
        with accepted:
            accepted.sendall(b"#43072" + data + end + b"7" + end)
            link = Link("oscilloscope", connection)
            assert link.ask_block("CURV?") == data
            assert link.ask_number("ACQ:STATE?") == 7
        link.close()


def test_the_trace_states_instruments_settings_limits_and_the_current_limiter():
    trace = ev.run_bench(SCENARIO, simulate=True)
    assert set(json.loads(trace.attrs["instruments"])) == {"generator", "oscilloscope"}
    settings = json.loads(trace.attrs["settings"])
    assert float(settings["OUTP:LOAD?"]) == pytest.approx(9.9e37)
    assert float(settings["VOLT?"]) == pytest.approx(10)
    assert (settings["BM:NCYC?"], settings["TRIG:SOUR?"]) == ("+1.00000E+00", "BUS")
    assert "250" in trace.attrs["current_limiter"] or "0.00025" in trace.attrs["current_limiter"]
    assert json.loads(trace.attrs["limits"])["voltage"] == 1000
    assert (trace.attrs["complete"], trace.attrs["simulated"], trace.attrs["burst"]) == (1, 1, "full burst")
    assert trace.lateral_force.attrs["calibration"] == "0.1 N/V, zero 0 V"
    assert float(abs(trace.plate_voltage - trace.drive_voltage).max()) < 15
    assert trace.time.values[0] == pytest.approx(0, abs=1e-9)
    assert "beyond" not in trace.attrs["comparisons"]


def test_a_burst_of_microseconds_and_a_finger_in_a_periodic_state_are_recorded():
    """The simulated finger is at rest before the burst; its times are resolved far below a microsecond."""
    short = {f"drive.{name}": 1e-6 for name in ("rise", "hold", "fall")}
    short |= {"drive.high": 1.0, "time.duration": 3e-6}
    ones = {"limits.voltage": 1.0, "amplifier.gain": 1.0, "oscilloscope.voltage.ratio": 1.0}
    sine = {"drive": {"model": "Sine", "amplitude": 1.0, "frequency": 100.0}}
    finger = ev.load(SCENARIO, changes=sine | {"time.initial_state": {"model": "PeriodicState"}})
    bench = read_settings().replace(ones)
    trace = ev.run_bench(ev.load(SCENARIO, changes=short), bench=bench, simulate=True, finger=finger)
    assert float(trace.time[-1]) == pytest.approx(3.6e-6, rel=0.01)
    # readings of 20 mV
    assert float(trace.plate_voltage.sel(time=slice(1e-6, 2e-6)).mean()) == pytest.approx(1.0, abs=0.02)


class VisaIOError(Exception):
    """Stands for that of pyvisa."""

    def __init__(self, error_code):
        super().__init__(f"VISA {error_code}")
        self.error_code = error_code


@pytest.fixture
def visa(monkeypatch):
    """Put a stand-in for pyvisa in place and return its one resource."""

    def read_raw():
        reply = resource.replies.pop(0)
        if isinstance(reply, Exception):
            raise reply
        return reply

    resource, package = MagicMock(replies=[], read_raw=read_raw), MagicMock()
    package.constants.StatusCode.error_timeout = -1
    package.errors.VisaIOError = VisaIOError
    package.ResourceManager().open_resource = lambda _, timeout: resource if timeout > 0 else None
    monkeypatch.setitem(sys.modules, "pyvisa", package)
    return resource


def test_messages_by_visa(visa):
    link = Link("generator", connect({"generator": "GPIB0::10::INSTR"})["generator"])
    visa.replies = [b"HEWLETT-PACKARD,33120A,0,1\r\n", b"#15abcd\n\n", VisaIOError(-1), VisaIOError(-7)]
    assert link.ask("*IDN?") == "HEWLETT-PACKARD,33120A,0,1"
    assert link.ask_block("CURV?") == b"abcd\n"  # the last byte of the data is that of a line feed
    with pytest.raises(BenchError, match=r"the generator gave no answer in time, after 'VOLT\?'"):
        link.ask("VOLT?")
    with pytest.raises(BenchError, match="is no longer connected"):
        link.ask("VOLT?")
    link.close()
    visa.close.assert_called_once()
    assert visa.write_raw.call_args_list[0].args == (b"*IDN?\n",)


def test_a_missing_pyvisa_and_an_instrument_out_of_reach_are_named(monkeypatch):
    with pytest.raises(BenchError, match=r"'TCPIP::127\.0\.0\.1::1::SOCKET' cannot be reached"):
        connect({"oscilloscope": "TCPIP::127.0.0.1::1::SOCKET"})
    monkeypatch.setitem(sys.modules, "pyvisa", None)
    with pytest.raises(InputError, match=r"pip install 'electrovib\[bench\]'"):
        connect({"generator": "GPIB0::10::INSTR"})


def test_readings_are_calibrated_and_forces_beyond_the_declared_range_are_stated():
    content = ev.plan_bench(SCENARIO).settings.to_dict()
    content["forces"]["lateral"] |= {"sensitivity": -0.1, "zero": 0.5, "low": 0.0, "high": 0.2}
    trace = ev.run_bench(SCENARIO, bench=content, simulate=True)
    assert float(trace.lateral_force.mean()) == pytest.approx(0.2503, rel=2e-3)
    assert "of 10000 readings of the lateral force lie beyond 0 N to 200 mN" in trace.attrs["comparisons"]
    settings = ev.plan_bench(SCENARIO, bench=content).settings
    assert settings.forces.lateral.quantity(np.array([0.5, -1.5])).tolist() == [0, 0.2]
    assert settings.oscilloscope.current.quantity(np.array([1.0])) == pytest.approx(100e-6)


def test_one_process_holds_a_bench():
    with one_process({"generator": "nobody"}) as left:
        assert left == ""
        second = one_process({"generator": "nobody"})
        with pytest.raises(BenchError, match="another process uses this bench"), second:
            pass
        with one_process({"generator": "another"}):
            pass
    with one_process({"generator": "nobody"}) as left:
        assert left == ""


def test_each_setting_is_compared_in_its_own_size():
    """1 ms more than 4 ms/div, or 1 mV more than 1 mV, is a quarter or all of it, and no rounding."""
    ranges = {1: (-1e-3, 3e-3), 2: (-4.0, 4.0)}
    expected = Hp33120a.expected(16000, 0.03, 0.05) | TektronixTds3014b.expected(0.03, ranges)
    assert expected["HOR:MAI:SCA?"] == 4e-3
    numbers = {query: value for query, value in expected.items() if not isinstance(value, str)}
    texts = {query: value for query, value in expected.items() if isinstance(value, str)}
    exact = texts | {query: f"{value:+.9E}" for query, value in numbers.items()}
    assert mismatches(exact, expected) == []
    for query, value in numbers.items():
        size = abs(value) or 1.0
        rounded = [] if isinstance(value, int) else [value + 0.9e-3 * size, value - 0.9e-3 * size]
        beyond = [value + 1.1e-3 * size, value - 1.1e-3 * size]
        for number in rounded:
            assert mismatches(exact | {query: f"{number:.9E}"}, expected) == []
        for number in [*beyond, *([value - 1] if isinstance(value, int) else [])]:
            (said,) = mismatches(exact | {query: f"{number:.9E}"}, expected)
            assert said.startswith(f"'{query}' answers ")
    for query in expected:
        for reply in ("", "banana"):
            assert len(mismatches(exact | {query: reply}, expected)) == 1
