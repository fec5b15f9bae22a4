"""The plan of a run: the drive as points of the generator, the ranges of the channels, and what the limits allow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

import numpy as np

from electrovib.bench.settings import GENERATORS, ForceInput, VoltageMonitor, check_drivers
from electrovib.core.answer import Answer, Curve, Document, Panel
from electrovib.core.diagnostics import Diagnostic, reasons
from electrovib.core.errors import InputError
from electrovib.core.units import format_quantity
from electrovib.physics.limits import WORDS, Limits, unit_of_limit
from electrovib.scenario.grids import AtRest
from electrovib.studies import check as checks

if TYPE_CHECKING:
    from numpy.typing import ArrayLike, NDArray

    from electrovib.bench.settings import BenchSettings
    from electrovib.core.arrays import Real
    from electrovib.scenario import Scenario
    from electrovib.studies.check import CheckResult

_ENDS = 1e-6
"""Voltage at the beginning and the end, over the peak, that counts as 0."""
_MOST_CORNERS: Final = 10_000_000
_WITHIN = 4
"""Times in each point of the generator at which the resampling error is evaluated."""


@dataclass(frozen=True, kw_only=True, repr=False)
class BenchPlan(Answer):
    """A run on a bench, before anything is sent.

    Parameters
    ----------
    scenario : Scenario
        The experiment, from rest.
    settings : BenchSettings
        The set-up.
    limits : Limits
        The strictest of scenario, bench and current limiter.
    duration : float
        Duration of the burst [s].
    codes : ndarray, shape (n,)
        Points of the generator; the first and the last are 0.
    amplitude : float
        Setting of the generator for the full burst: voltage between the largest codes of either sign [V].
    fraction : float
        Peak of the first burst over that of the full one, dimensionless, <= 1.
    peak : float
        Largest absolute voltage of the plate [V].
    check : CheckResult
        Comparison of the drive with the limits.
    resampling_error : float
        Root mean square difference of points and drive over the peak, dimensionless.
    """

    scenario: Scenario
    settings: BenchSettings
    limits: Limits
    duration: float
    codes: NDArray[np.int16]
    amplitude: float
    fraction: float
    peak: float
    check: CheckResult
    resampling_error: float

    @property
    def diagnostics(self) -> tuple[Diagnostic, ...]:
        """Diagnostics of the experiment, beyond those that the check states."""
        return self.check.diagnostics

    @property
    def current(self) -> float:
        """Largest absolute current that is predicted [A]."""
        return self.check.value("peak current") or 0.0

    def voltage(self, time: ArrayLike) -> NDArray[np.float64]:
        """Return the voltage of the plate [V] in the full burst, at times after the trigger [s]; 0 outside."""
        times = np.asarray(time, dtype=float)
        inside = (times >= 0) & (times <= self.duration)
        values = _plate_voltage(self.scenario, np.clip(times, 0, self.duration))
        return np.where(inside, values, 0.0)

    def ranges(self, fraction: float = 1.0) -> dict[int, tuple[float, float]]:
        """Return the lowest and highest voltage [V] of each input of the oscilloscope.

        `fraction` is the peak of the burst over that of the full one.
        """
        found = {}
        extremes = self._extremes()
        for name, channel in self.settings.channels().items():
            if isinstance(channel, ForceInput):
                ends = [force / channel.sensitivity + channel.zero for force in (channel.low, channel.high)]
            elif isinstance(channel, VoltageMonitor):
                # a read-back of twice the plan must be seen and not clipped
                ends = [2.0 * fraction * each / channel.ratio for each in extremes]
            else:
                largest = 2.0 * (self.limits.current or self.current)
                ends = [-largest * channel.resistance, largest * channel.resistance]
            found[self.settings.channels()[name].input] = (min(ends), max(ends))
        return found

    def _extremes(self) -> tuple[float, float]:
        played = self._played()
        ends = (float(played.min()), float(played.max()))
        return min(*ends, -0.2 * self.peak), max(*ends, 0.2 * self.peak)

    @property
    def document(self) -> Document:
        """The plan, a sentence for each statement, and the burst as the generator plays it."""
        return Document(
            title=f"Bench plan: {self.scenario.titled() or 'a scenario'}",
            sentences=self._statements(),
            diagnostics=self.diagnostics,
            figures=[self._burst()],
            remarks=reasons(self.diagnostics),
        )

    def _burst(self) -> Panel:
        """Draw the levels of the generator over the voltage that was asked for."""
        edges = np.linspace(0.0, self.duration, self.codes.size + 1)
        levels = np.repeat(self._played(), 2)
        return Panel(
            id="burst",
            title="The full burst at the plate",
            caption="The points of the generator, each held until the next, and the drive.",
            x=("time", "s"),
            y=("voltage", "V"),
            curves=(
                Curve(label="points of the generator", x=np.repeat(edges, 2)[1:-1], y=levels),
                Curve(label="drive", x=edges, y=self.voltage(edges), kind="dashed"),
            ),
        )

    def _played(self) -> NDArray[np.float64]:
        """Return the voltage of the plate [V] for each point of the generator."""
        largest = GENERATORS[self.settings.generator.driver].largest_code
        return self.codes * np.float64(self.amplitude * self.settings.amplifier.gain / (2 * largest))

    def _statements(self) -> list[str]:
        settings, limits = self.settings, self.limits
        limiter = settings.current_limiter
        held = ", ".join(
            f"{name.replace('_', ' ')} {format_quantity(value, unit_of_limit(name))}"
            for name in WORDS
            if (value := getattr(limits, name)) is not None
        )
        enable = settings.amplifier.enable
        return [
            f"set-up: {settings.title or 'without a title'}",
            f"hardware that limits the current: {limiter.name}, {format_quantity(limiter.current, 'A')}",
            f"limits, the strictest of scenario and bench: {held}",
            f"drive: one burst of {format_quantity(self.duration, 's', digits=4)}, from 0 V to 0 V, peak"
            f" {format_quantity(self.peak, 'V', digits=4)} at the plate; predicted largest current"
            f" {format_quantity(self.current, 'A', digits=3)}{self._stray()}",
            f"generator ({settings.generator.driver}): {self.codes.size} points, {self.amplitude:.4g} V between the largest"
            f" codes, gain of the amplifier {settings.amplifier.gain:g}; resampling error"
            f" {100 * self.resampling_error:.2g} % of the peak (rms)",
            f"played as levels of {format_quantity(self._level, 's', digits=4)}, {self._edge()}",
            f"first burst: {format_quantity(self.fraction * self.peak, 'V', digits=4)}, compared with the plan to"
            f" {100 * settings.burst.tolerance:g} % before the full one",
            "enable line: "
            + (
                "none; the operator switches the high voltage and confirms between the steps"
                if enable is None
                else f"'{enable.on}' and '{enable.off}'"
            ),
            "current read back: "
            + ("yes" if settings.oscilloscope.current is not None else "no, no input is declared for it"),
            *checks.not_shown(self.check.rows),
        ]

    @property
    def _level(self) -> float:
        """Duration of a point of the generator [s]."""
        return self.duration / self.codes.size

    def _edge(self) -> str:
        edge = self.settings.edge
        if edge is None:
            return "judged as steps: no edge is declared"
        words = f"with edges of {format_quantity(edge.time, 's', digits=4)} ({edge.source})"
        return words if edge.time < self._level else f"{words}, judged as straight lines from point to point"

    def _stray(self) -> str:
        amplifier = self.scenario.circuit.amplifier
        if amplifier is not None and amplifier.stray_capacitance > 0:
            return ", stray capacitance included"
        return ", without stray capacitance: none is declared (circuit.amplifier.stray_capacitance)"


def make_plan(scenario: Scenario, settings: BenchSettings) -> BenchPlan:
    """Plan a run and refuse what cannot be played safely.

    The voltage to be played is the drive, times the gain of the scenario's own amplifier if it has one. A
    drive is refused that is no finite voltage which begins and ends at 0 V, is longer than allowed, does not
    fit the generator, or exceeds a limit; every limit at once.
    """
    check_drivers(settings)
    duration = _finite_duration(scenario, settings)
    at_rest = scenario.replace({"time.initial_state": {"model": AtRest.__name__}, "time.duration": duration})
    peak, codes, played, error = _points(at_rest, settings, duration)
    begins = np.arange(codes.size, dtype=np.float64) * np.float64(duration / codes.size)
    limits, check = cleared(at_rest, settings, begins, played / _own_gain(at_rest))
    amplitude = 2 * peak / abs(settings.amplifier.gain)
    fraction = min(settings.burst.low_voltage / peak, 1.0)
    lowest, highest = GENERATORS[settings.generator.driver].amplitudes
    if not (lowest <= fraction * amplitude and amplitude <= highest):
        raise InputError(
            f"the generator would have to put out {fraction * amplitude:.3g} V in the first burst and {amplitude:.3g} V in the"
            f" full one (peak to peak, amplifier.gain = {settings.amplifier.gain:g}); it can put out {lowest:g} to {highest:g} V."
            " Change burst.low_voltage, the drive, or the amplifier"
        )
    return BenchPlan(
        scenario=at_rest, settings=settings, limits=limits, duration=duration, codes=codes, amplitude=amplitude,
        fraction=fraction, peak=peak, check=check, resampling_error=error,
    )  # fmt: skip


def _finite_duration(scenario: Scenario, settings: BenchSettings) -> float:
    drive = scenario.drive
    if drive.quantity != "voltage":
        raise InputError("is a current; the bench plays voltages", path="drive")
    duration = scenario.time.duration or drive.duration
    if duration > settings.burst.longest:
        raise InputError(
            f"the drive lasts {format_quantity(duration, 's')}, longer than burst.longest ="
            f" {format_quantity(settings.burst.longest, 's')}; shorten it with time.duration, or allow longer bursts"
        )
    peak = drive.largest(duration)
    if peak == 0:
        raise InputError("is 0 V throughout: there is nothing to play", path="drive")
    for when, time in (("begins", 0.0), ("ends", duration)):
        value = float(drive.voltage(time))
        if abs(value) > _ENDS * peak:
            raise InputError(
                f"{when} at {format_quantity(value, 'V', digits=4)}; on the bench a drive is a burst that begins and ends at"
                f" 0 V, with its ramps inside. Use a drive such as Trapezium with low = 0, or a duration (time.duration, now"
                f" {format_quantity(duration, 's')}) after which the voltage is 0",
                path="drive",
            )
    return duration


def _plate_voltage(scenario: Scenario, times: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the voltage that the plate is to have: the drive times the gain of the scenario's amplifier."""
    return scenario.drive.voltage(times) * _own_gain(scenario)


def _own_gain(scenario: Scenario) -> float:
    """Return the gain of the scenario's amplifier; 1 without one."""
    amplifier = scenario.circuit.amplifier
    return 1.0 if amplifier is None else amplifier.gain


def _points(
    scenario: Scenario, settings: BenchSettings, duration: float
) -> tuple[float, NDArray[np.int16], NDArray[np.float64], float]:
    """Return peak voltage [V], codes of the generator, the voltages of the plate [V] for them, and their rms error."""
    driver = GENERATORS[settings.generator.driver]
    count = driver.most_points
    fine = (np.arange(_WITHIN * count, dtype=np.float64) + 0.5) * (duration / (_WITHIN * count))
    wanted = _plate_voltage(scenario, fine)
    peak = scenario.drive.largest(duration) * abs(_own_gain(scenario))
    sign = np.sign(settings.amplifier.gain)
    mean = wanted.reshape(count, _WITHIN).mean(axis=1)
    codes = driver.codes_of(sign * mean, peak)
    codes[0] = codes[-1] = 0  # the output rests at the first point
    played = np.asarray(sign * driver.voltages_of(codes, peak))
    error = float(np.sqrt(np.mean((np.repeat(played, _WITHIN) - wanted) ** 2)) / peak)
    if error > settings.burst.resampling_error:
        raise InputError(
            f"as {count} points the drive has an error of {100 * error:.2g} % of its peak (rms), more than"
            f" burst.resampling_error = {settings.burst.resampling_error:g}; shorten it, or allow the error"
        )
    _refuse_lost(scenario, settings, duration, played)
    return peak, codes.astype(np.int16), played, error


def _refuse_lost(scenario: Scenario, settings: BenchSettings, duration: float, played: Real) -> None:
    """Refuse a drive with a feature that is lost: a corner or a peak out of the range of the points about it."""
    count, drive, gain = played.size, scenario.drive, _own_gain(scenario)
    if drive.count_corners(duration) > _MOST_CORNERS:
        raise InputError(
            f"has more than {_MOST_CORNERS} corners for {count} points; shorten it", path="drive"
        )
    corners, heights = drive.corners(duration)
    ends = gain * np.array(drive.extremes(0.0, duration))
    after = gain * drive.voltage(corners)
    wanted = np.concatenate([after, after - gain * heights, ends])
    places = np.minimum(corners / duration * count, count - 1).astype(int)
    around = np.pad(played, 1)[np.tile(places, 2) + np.arange(3)[:, None]]
    low = np.append(around.min(axis=0), [played.min()] * 2)
    high = np.append(around.max(axis=0), [played.max()] * 2)
    off = np.maximum(low - wanted, wanted - high)
    worst = int(np.argmax(off))
    if off[worst] > settings.burst.tolerance * np.max(np.abs(ends)):
        reached, missed = (format_quantity(float(each[worst]), "V", digits=4) for each in (wanted, off))
        raise InputError(
            f"the drive reaches {reached} for less than a point of the generator ({format_quantity(duration / count, 's')}), and"
            f" the points about it miss it by {missed}, more than burst.tolerance = {settings.burst.tolerance:g} of the peak."
            " Shorten the burst (time.duration), or remove what is shorter than a point",
            path="drive",
        )


_DECLARE: Final = (
    "Declare it in the bench file with its source:"
    ' [edge] time = "10 us" source = "filter in front of the plate, measured"'
)


def cleared(
    scenario: Scenario, settings: BenchSettings, times: Real, voltages: Real
) -> tuple[Limits, CheckResult]:
    """Check what the generator plays against the strictest of all declared limits, or refuse it.

    `times` (n,) [s] at which the points of the generator begin, and their `voltages` (n,) [V] at the input of
    the scenario's amplifier. The limits are the strictest of scenario, bench and current limiter; voltage and
    current are always declared. Refused are a current limiter that allows more than the smallest declared
    current, and every limit that is exceeded or could not be compared.
    """
    limiter = settings.current_limiter
    places = [checks.LimitsFrom("the bench", settings.limits)]
    declared = checks.declared_limits(scenario, places)["current"]
    if limiter.current > declared.value:
        raise InputError(
            f"current_limiter.current = {format_quantity(limiter.current, 'A')}: '{limiter.name}' allows more than the largest"
            f" current that is declared, {format_quantity(declared.value, 'A')} ({declared.source}); software alone does not"
            " protect: set the hardware to that value, or declare a larger limit"
        )
    places.append(checks.LimitsFrom(f"the current limiter ({limiter.name})", Limits(current=limiter.current)))
    consequence, relied_on = "Nothing is played", checks.without_its_limits(scenario)
    if relied_on is not scenario:
        consequence += (
            ". On the bench saturation, current limit and bandwidth of circuit.amplifier do not count"
        )
    result = checks.cleared_as_played(
        relied_on, times=times, voltages=voltages, edge=None if settings.edge is None else settings.edge.time, declare=_DECLARE,
        limits=places, what="a burst on the bench", name="the points of the generator", consequence=consequence,
    )  # fmt: skip
    strict = checks.declared_limits(scenario, places)
    checks.refuse_demanded(scenario, strict["voltage"], result.duration, consequence)
    return Limits(**{name: each.value for name, each in strict.items()}), result
