"""The set-up as roles, with its limits: generator, amplifier, oscilloscope, force; the drivers, and how all go to 0 V."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Final, Self

from pydantic import Field, field_validator, model_validator

from electrovib.bench.drivers.hp_33120a import Hp33120a
from electrovib.bench.drivers.tektronix_tds3014b import TektronixTds3014b
from electrovib.bench.link import BenchError, Link
from electrovib.core.arrays import Real
from electrovib.core.errors import ElectrovibError, InputError, nearest, refuse
from electrovib.core.model import Model, read_model
from electrovib.core.parsing import read_toml, read_toml_file
from electrovib.core.quantity import Number, Quantity
from electrovib.physics.amplifier import negating_word
from electrovib.physics.limits import Limits

if TYPE_CHECKING:
    from collections.abc import Callable, Mapping

    from electrovib.bench.link import Connection

SCHEMA: Final = 1
"""Version of the bench files that this package reads."""
DEFAULT: Final = "vezzoli_2014.toml"
"""File of the set-up of Vezzoli et al. 2014 that is shipped with the package."""
Input = Annotated[int, Field(ge=1, le=4, description="input of the oscilloscope, 1 to 4")]
DriverName = Annotated[str, Field(description="name of the driver")]
AcceptedModel = Annotated[
    str, Field(description="further model that is accepted by this driver, as the instrument states it")
]


def _something(text: str) -> str:
    """Refuse a text that says that nothing is there, where a part has to be named."""
    if word := negating_word(text):
        raise ValueError(f"names nothing that is there ({word}); name the part, or its circuit")
    return text


class CurrentLimiter(Model):
    """The hardware that limits the current into plate and finger, whatever the software does."""

    example: ClassVar[Mapping[str, Any]] = {"name": "safety circuit of the amplifier", "current": 250e-6}

    name: Annotated[str, Field(min_length=3, description="the hardware that limits the current")]
    current: Annotated[Number, Quantity("A", 1e-9, 10, "current at which that hardware limits")]

    _named = field_validator("name")(_something)


class BurstRules(Model):
    """Conditions under which a drive is played, as one finite burst."""

    longest: Annotated[Number, Quantity("s", 1e-6, 60, "longest burst that is played")] = 1.0
    low_voltage: Annotated[
        Number, Quantity("V", 1e-3, 100, "peak voltage of the plate in the first burst")
    ] = 20.0
    tolerance: Annotated[
        Number, Quantity("1", 1e-4, 0.2, "deviation of the read-back voltage from the plan over its peak")
    ] = 0.05
    resampling_error: Annotated[
        Number, Quantity("1", 1e-6, 0.2, "rms error of the drive as points of the generator, over its peak")
    ] = 0.01


class GeneratorRole(Model):
    """The waveform generator that plays the drive."""

    example: ClassVar[Mapping[str, Any]] = {"driver": "hp_33120a"}

    driver: DriverName
    resource: Annotated[str, Field(description="VISA resource, for instance GPIB0::10::INSTR")] = ""
    accept_model: AcceptedModel = ""


class OutputEdge(Model):
    """The edge between two points of the generator as the plate receives it."""

    example: ClassVar[Mapping[str, Any]] = {"time": 10e-6, "source": "filter in front of the plate, measured"}

    time: Annotated[
        Number, Quantity("s", 1e-12, 1, "height of a step over its steepest slope; of one pole 1/(2 pi f)")
    ]
    source: Annotated[str, Field(min_length=3, description="what makes the edge, and how its time is known")]

    _named = field_validator("source")(_something)


class EnableLine(Model):
    """An instrument that enables and disables the high voltage, with its commands."""

    example: ClassVar[Mapping[str, Any]] = {"on": "OUTP ON", "off": "OUTP OFF", "state": "OUTP?"}

    resource: Annotated[str, Field(description="VISA resource of the instrument that holds the line")] = ""
    on: Annotated[str, Field(min_length=1, description="command that enables the high voltage")]
    off: Annotated[str, Field(min_length=1, description="command that disables the high voltage")]
    state: Annotated[str, Field(min_length=1, description="query of the state of the line")]
    enabled: Annotated[str, Field(description="reply to the query while enabled")] = "1"
    disabled: Annotated[str, Field(description="reply to the query while disabled")] = "0"


class AmplifierRole(Model):
    """The high-voltage amplifier between generator and plate."""

    example: ClassVar[Mapping[str, Any]] = {"name": "amplifier", "gain": 100.0}

    name: Annotated[str, Field(description="maker and model")]
    gain: Annotated[Number, Quantity("1", -1e5, 1e5, "voltage of the plate over voltage of the generator")]
    enable: EnableLine | None = None

    @model_validator(mode="after")
    def _amplifies(self) -> Self:
        if self.gain == 0:
            raise ValueError("a gain of 0 plays nothing; give that of the amplifier, for instance 100")
        return self


class VoltageMonitor(Model):
    """The input of the oscilloscope that reads the voltage of the plate back."""

    example: ClassVar[Mapping[str, Any]] = {"input": 1, "ratio": 100.0}

    input: Input
    ratio: Annotated[
        Number, Quantity("1", -1e6, 1e6, "voltage of the plate over voltage of the input, its sign included")
    ]

    @model_validator(mode="after")
    def _reads(self) -> Self:
        if self.ratio == 0:
            raise ValueError("a ratio of 0 makes every voltage 0; give that of the monitor")
        return self

    def quantity(self, voltage: Real) -> Real:
        """Return the voltage of the plate [V] from that at the input [V]."""
        return self.ratio * voltage

    def size(self, step: float) -> float:
        """Return the change of the plate voltage [V] for a change at the input [V]."""
        return abs(self.ratio) * step


class CurrentMonitor(Model):
    """The input of the oscilloscope that reads the current of the amplifier back."""

    example: ClassVar[Mapping[str, Any]] = {"input": 4, "resistance": 10e3}

    input: Input
    resistance: Annotated[
        Number, Quantity("ohm", 1e-3, 1e9, "voltage of the input over current of the amplifier")
    ]

    def quantity(self, voltage: Real) -> Real:
        """Return the current of the amplifier [A] from the voltage at the input [V]."""
        return voltage / self.resistance

    def size(self, step: float) -> float:
        """Return the change of the current [A] for a change at the input [V]."""
        return step / self.resistance


class ForceInput(Model):
    """An input of the oscilloscope that reads a force sensor, with its calibration."""

    example: ClassVar[Mapping[str, Any]] = {"input": 2, "sensitivity": 0.1, "low": 0.0, "high": 0.5}

    input: Input
    sensitivity: Annotated[Number, Quantity("N/V", -1e6, 1e6, "force per volt, its sign included")]
    zero: Annotated[Number, Quantity("V", -1e3, 1e3, "voltage without force")] = 0.0
    low: Annotated[Number, Quantity("N", -1e3, 1e3, "lowest force that is recorded")]
    high: Annotated[Number, Quantity("N", -1e3, 1e3, "highest force that is recorded")]
    noise: Annotated[
        Number, Quantity("N", 0, 1e3, "rms noise of one reading; used by the simulated set-up only")
    ] = 0.0

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise ValueError(f"low must be below high, which is {self.high:g}")
        if self.sensitivity == 0:
            raise ValueError("a sensitivity of 0 makes every force 0; give that of the sensor")
        return self

    def quantity(self, voltage: Real) -> Real:
        """Return the force [N] from the voltage at the input [V]."""
        return self.sensitivity * (voltage - self.zero)

    def size(self, step: float) -> float:
        """Return the change of the force [N] for a change at the input [V]."""
        return abs(self.sensitivity) * step


class ForceInputs(Model):
    """The force channels of the set-up."""

    lateral: ForceInput | None = None
    normal: ForceInput | None = None


class OscilloscopeRole(Model):
    """The oscilloscope that records voltage, current and forces."""

    example: ClassVar[Mapping[str, Any]] = {"driver": "tektronix_tds3014b", "voltage": VoltageMonitor.example}

    driver: DriverName
    resource: Annotated[str, Field(description="VISA resource, for instance TCPIP0::192.0.2.1::INSTR")] = ""
    accept_model: AcceptedModel = ""
    voltage: VoltageMonitor
    current: CurrentMonitor | None = None


class BenchSettings(Model):
    """A set-up that plays a drive on a plate and records forces.

    Notes
    -----
    `current_limiter` and the limits of voltage and current have no default: a set-up that does not declare them plays
    nothing.
    """

    example: ClassVar[Mapping[str, Any]] = {
        "current_limiter": CurrentLimiter.example,
        "limits": {"voltage": 1000.0, "current": 250e-6},
        "edge": OutputEdge.example,
        "generator": GeneratorRole.example,
        "amplifier": AmplifierRole.example,
        "oscilloscope": OscilloscopeRole.example,
    }

    title: Annotated[str, Field(description="name of the set-up")] = ""
    current_limiter: CurrentLimiter
    limits: Limits
    burst: BurstRules = BurstRules()
    edge: Annotated[
        OutputEdge | None, Field(description="edge between two points; without it they are judged as steps")
    ] = None
    generator: GeneratorRole
    amplifier: AmplifierRole
    oscilloscope: OscilloscopeRole
    forces: ForceInputs = ForceInputs()

    @model_validator(mode="after")
    def _one_channel_each(self) -> Self:
        inputs = [each.input for each in self.channels().values()]
        if len(set(inputs)) < len(inputs):
            raise ValueError(f"two channels share an input of the oscilloscope: inputs {sorted(inputs)}")
        return self

    def channels(self) -> dict[str, VoltageMonitor | CurrentMonitor | ForceInput]:
        """Return the recorded channels by role: voltage, and where declared current, lateral, normal."""
        found = {
            "voltage": self.oscilloscope.voltage,
            "current": self.oscilloscope.current,
            "lateral": self.forces.lateral,
            "normal": self.forces.normal,
        }
        return {name: each for name, each in found.items() if each is not None}

    @property
    def resources(self) -> dict[str, str]:
        """Address of each instrument by role."""
        found = {"generator": self.generator.resource, "oscilloscope": self.oscilloscope.resource}
        enable = self.amplifier.enable
        return found if enable is None else {**found, "enable line": enable.resource}


def read_settings(source: str | Path | Mapping[str, Any] | BenchSettings | None = None) -> BenchSettings:
    """Read the settings of a set-up; by default that of Vezzoli et al. 2014.

    Mistakes are refused all at once; where a declaration for safety is missing, with the lines to add.
    """
    if isinstance(source, BenchSettings):
        _refuse_undeclared(source.to_dict(), "the bench")
        return source
    name = str(source) if isinstance(source, (str, Path)) else "the bench"
    if source is None:
        tables = read_toml(default_text())
    elif isinstance(source, (str, Path)):
        advice = "'electrovib bench init' prints a bench file to start from"
        tables = read_toml_file(Path(source), kind="a bench file", advice=advice)
    else:
        tables = {"schema": SCHEMA} | {str(key): item for key, item in source.items()}
    schema = tables.pop("schema", None)
    if schema != SCHEMA:
        raise InputError(
            f"schema = {repr(schema)[:60]}: this version reads 'schema = {SCHEMA}'; write it as the first line",
            path=name,
        )
    _refuse_undeclared(tables, name)
    return read_model(BenchSettings, tables)


def default_text() -> str:
    """Return the TOML of the set-up of Vezzoli et al. 2014."""
    return resources.files("electrovib.bench").joinpath(DEFAULT).read_text(encoding="utf-8")


_LINES: Final = {
    "current_limiter": (
        "no hardware that limits the current is declared, so nothing runs; add, with the name and the value of yours:"
        ' [current_limiter] name = "safety circuit of the amplifier" current = "250 uA"'
    ),
    "limits.voltage": 'no largest voltage is declared, so nothing runs; add: [limits] voltage = "1 kV"',
    "limits.current": 'no largest current is declared, so nothing runs; add: [limits] current = "250 uA"',
}


def _refuse_undeclared(tables: Mapping[str, Any], name: str) -> None:
    limits = tables.get("limits")
    held = limits if isinstance(limits, dict) else {}
    missing = [f"limits.{each}" for each in ("voltage", "current") if held.get(each) is None]
    if tables.get("current_limiter") is None:
        missing.insert(0, "current_limiter")
    if missing:
        raise InputError(f"{name}: {each}: {_LINES[each]}" for each in missing)


GENERATORS: Final[Mapping[str, type[Hp33120a]]] = {"hp_33120a": Hp33120a}
OSCILLOSCOPES: Final[Mapping[str, type[TektronixTds3014b]]] = {"tektronix_tds3014b": TektronixTds3014b}
"""Drivers by their names in a bench file."""
_ATTEMPTS = 2


def check_drivers(settings: BenchSettings) -> None:
    """Refuse names of drivers that do not exist, with the nearest name."""
    asked = (
        ("generator.driver", settings.generator.driver, GENERATORS),
        ("oscilloscope.driver", settings.oscilloscope.driver, OSCILLOSCOPES),
    )
    problems = [
        f"{path} = '{name}': there is no such driver.{nearest(name, known)}"
        for path, name, known in asked
        if name not in known
    ]
    refuse(problems)


@dataclass(frozen=True, kw_only=True)
class Instruments:
    """Drivers of the instruments of a bench; `enable` is None without an enable line of the amplifier."""

    generator: Hp33120a
    oscilloscope: TektronixTds3014b
    enable: EnableDriver | None

    @classmethod
    def of(cls, settings: BenchSettings, connections: Mapping[str, Connection]) -> Instruments:
        """Make the drivers from connections by role."""
        links = {name: Link(name, connection) for name, connection in connections.items()}
        generator, oscilloscope, line = settings.generator, settings.oscilloscope, settings.amplifier.enable
        return cls(
            generator=GENERATORS[generator.driver](links["generator"], also=generator.accept_model),
            oscilloscope=OSCILLOSCOPES[oscilloscope.driver](
                links["oscilloscope"], also=oscilloscope.accept_model
            ),
            enable=None if line is None else EnableDriver(links["enable line"], line),
        )

    def to_zero(self) -> list[str]:
        """Disable the high voltage and set the generator to 0 V, whatever fails; return what could not be confirmed."""
        failures = []
        if self.enable is not None:
            failures += _attempted(self.enable.disable, "the high voltage is not confirmed as disabled")
        failures += _attempted(self.generator.zero, "0 V at the generator is not confirmed")
        return failures

    def close(self) -> None:
        """End the connections."""
        self.generator.link.close()
        self.oscilloscope.link.close()
        if self.enable is not None:
            self.enable.link.close()


def _attempted(work: Callable[[], None], what: str) -> list[str]:
    """Try a command a few times; return what failed."""
    last: BaseException | None = None
    for _ in range(_ATTEMPTS):
        try:
            work()
        except BaseException as error:  # noqa: BLE001  # nothing may keep the next command from being sent
            last = error
        else:
            return []
    why = str(last) if isinstance(last, ElectrovibError) else f"{type(last).__name__}: {last}"
    return [f"{what}: {why}"]


class EnableDriver:
    """Enables and disables the high voltage by the commands of the bench file, and reads the state back."""

    def __init__(self, link: Link, line: EnableLine) -> None:
        self.link = link
        self._line = line

    def enable(self) -> None:
        """Enable the high voltage, and refuse a line that does not read back as enabled."""
        self._switch(self._line.on, self._line.enabled, "enabled")

    def disable(self) -> None:
        """Disable the high voltage, and refuse a line that does not read back as disabled."""
        self._switch(self._line.off, self._line.disabled, "disabled")

    def confirm(self) -> None:
        """Read the state back without a change, and refuse a line that does not read back as enabled."""
        self._expect(self._line.enabled, "enabled", "while the high voltage was on")

    def _switch(self, command: str, wanted: str, state: str) -> None:
        self.link.write(command)
        self._expect(wanted, state, f"after '{command}'")

    def _expect(self, wanted: str, state: str, when: str) -> None:
        reply = self.link.ask(self._line.state)
        if reply != wanted:
            raise BenchError(
                f"the enable line answered '{reply[:60]}' to '{self._line.state}' {when}, where '{wanted}' was expected: it is"
                f" not known to be {state}"
            )
