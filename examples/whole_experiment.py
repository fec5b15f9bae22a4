"""Figure 6 of Vezzoli et al. 2014 as an experiment: eight drawn fingers on the simulated bench, evaluated as in the paper.

The generator plays the trapezoidal pulse, the amplifier with its 250 uA charges plate and stray capacitance, the finger slides at
constant speed, two force sensors and an oscilloscope of 10 000 points record. Each of two force laws has its row in the figure.
Speed, delay, stray capacitance, noise, ranges and dynamics of the sensors are choices: the paper does not print them.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np

import electrovib as ev
from electrovib.bench.settings import read_settings
from electrovib.view.style import PALETTE

if TYPE_CHECKING:
    from matplotlib.figure import Figure
    from numpy.typing import NDArray

    from electrovib.scenario import Scenario

PAPER = (2e-3, 5e-3)
"""Change of the lateral force that the paper states: "from 2 to 5 mN" (section 4)."""
LAWS = {"law (1) of the paper": "vezzoli_2014/fig6", "Maxwell stress in a leaky gap": "vezzoli_2014/fig6_gap"}
SEED, FINGERS, BURSTS = 1, 8, 16
REST, RISE, HOLD = 40e-3, 36e-3, 0.1
SET_UP = {
    "limits.voltage": "1 kV",
    "drive.delay": REST,
    "time.duration": REST + 2 * RISE + HOLD + REST,
    "motion.speed": "20 mm/s",
}
CHAIN = {
    "circuit.amplifier": {"source_current": "250 uA", "stray_capacitance": "100 pF"},
    "rig": {
        "model": "Tribometer",
        "lateral": {"natural_frequency": 500.0, "damping_ratio": 0.05},
        "normal": {"natural_frequency": 2e3, "damping_ratio": 0.02, "time_constant": 10.0},
    },
    # the finger is put down as the record begins: a piezoelectric sensor reads no force that was there before
    "load.time_profile": {"model": "Press", "rise": "5 ms"},
}


class Subject(NamedTuple):
    """One finger: forces over time [s], all in newtons.

    `recorded` is the change of the lateral force that the bench recorded, `own` that of the finger under the ideal drive;
    `friction` is the lateral over the normal force of the records before the pulse, `true_friction` the drawn one.
    """

    time: NDArray[np.float64]
    recorded: NDArray[np.float64]
    own: NDArray[np.float64]
    friction: float
    true_friction: float

    def at_the_top(self, force: NDArray[np.float64]) -> float:
        """Return the mean of a force over the last 4 ms of the rise [N]."""
        top = (self.time > REST + RISE - 4e-3) & (self.time <= REST + RISE)
        return float(np.mean(force[top]))

    @property
    def attraction(self) -> float:
        """Attraction at the end of the rise, as it is evaluated from the records [N]."""
        return self.at_the_top(self.recorded) / self.friction


def smooth(values: NDArray[np.float64], points: int = 20) -> NDArray[np.float64]:
    """Return the means of 20 consecutive readings, 0.8 ms."""
    return values[: values.size // points * points].reshape(-1, points).mean(axis=1)


def measure(finger: Scenario, bursts: int, seed: int) -> Subject:
    """Play the pulse on one finger and evaluate the records: average over bursts, baseline, friction."""
    expected = finger.friction.coefficient * finger.load.normal_force
    bench = read_settings().replace(
        {"forces.lateral.low": 0.8 * expected, "forces.lateral.high": 1.2 * expected}
    )
    chain = finger.replace(CHAIN)
    records = [
        ev.run_bench(finger, bench=bench, simulate=True, finger=chain, seed=seed + burst)
        for burst in range(bursts)
    ]
    time = records[0].time.values
    before = (time > REST / 2) & (time < REST)
    readings = {
        name: np.mean([each[name].values for each in records], axis=0)
        for name in ("lateral_force", "normal_force")
    }
    lateral = readings["lateral_force"]
    own = ev.simulate(finger, time=time).lateral_force.values
    return Subject(
        time=smooth(time),
        recorded=smooth(lateral - lateral[before].mean()),
        own=smooth(own - own[before].mean()),
        friction=float(lateral[before].mean() / readings["normal_force"][before].mean()),
        true_friction=finger.friction.coefficient,
    )


def main(scenario: str, fingers: int = FINGERS, bursts: int = BURSTS) -> list[Subject]:
    """Measure fingers drawn from the population `fingers`, each in a number of bursts."""
    base = ev.load(scenario, changes=SET_UP)
    drawn = ev.read_space(base, "fingers").draw(SEED, 0, fingers)
    return [
        measure(
            base.replace({path: float(each[number]) for path, each in drawn.items()}), bursts, number * bursts
        )
        for number in range(fingers)
    ]


def table(subjects: list[Subject]) -> str:
    """Return the forces at the end of the rise [mN] of each finger, and their spread beside the paper's."""
    rows = ["finger  friction (drawn)  lateral (own, chain adds)  attraction"]
    for number, each in enumerate(subjects, 1):
        recorded, own = 1e3 * each.at_the_top(each.recorded), 1e3 * each.at_the_top(each.own)
        rows.append(
            f"{number:6d}     {each.friction:.3f} ({each.true_friction:.3f})  {recorded:7.3f} ({own:6.3f}, {recorded - own:+.3f})"
            f"  {1e3 * each.attraction:18.3f}"
        )
    low, high = (1e3 * extreme(each.at_the_top(each.recorded) for each in subjects) for extreme in (min, max))
    measured = " to ".join(f"{1e3 * each:g}" for each in PAPER)
    return "\n".join([*rows, f"lateral force {low:.2f} to {high:.2f} mN; the paper states {measured} mN"])


def draw(found: dict[str, list[Subject]]) -> Figure:
    """Draw the records with their band beside the measured one, and the difference from the finger's own response."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9, 3.2 * len(found)), layout="constrained")
    rows = figure.subplots(len(found), 2, squeeze=False, sharex=True)
    top = 1e3 * (REST + RISE)
    for (left, right), (law, subjects) in zip(rows, found.items(), strict=True):
        time = 1e3 * subjects[0].time
        recorded = 1e3 * np.array([each.recorded for each in subjects])
        left.fill_between(
            time, recorded.min(axis=0), recorded.max(axis=0), color="0.85", label="band of the records"
        )
        for number, each in enumerate(subjects):
            left.plot(time, recorded[number], lw=0.7, color=PALETTE[number])
            left.plot(time, 1e3 * each.own, "--", lw=0.8, color="k", label="" if number else "finger alone")
            right.plot(
                time, recorded[number] - 1e3 * each.own, lw=0.5, color=PALETTE[number], label=f"{number + 1}"
            )
        left.fill_between(
            [top - 8, top + 8],
            *(1e3 * each for each in PAPER),
            color="tab:red",
            alpha=0.3,
            label="stated in the paper",
        )
        left.set(ylabel="change of the lateral force [mN]", title=law)
        right.set(ylabel="record less finger alone [mN]", title="what the chain adds")
        right.margins(y=0.25)
    for axes in rows[-1]:
        axes.set(xlabel="time [ms]", xlim=(0, 1e3 * SET_UP["time.duration"]))
    rows[0][0].legend(fontsize=7, loc="upper right")
    rows[0][1].legend(fontsize=6, ncols=8, title="finger", title_fontsize=6, loc="upper center")
    return figure


if __name__ == "__main__":
    found = {law: main(scenario) for law, scenario in LAWS.items()}
    tables = {law: table(subjects) for law, subjects in found.items()}
    for law, text in tables.items():
        print(f"{law}: {text.splitlines()[-1]}")
    for law, text in tables.items():
        print(law, text, sep="\n")
    draw(found).savefig("whole_experiment.png", dpi=150)
