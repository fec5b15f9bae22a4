"""How wide an answer about people is: by its draws, by thresholds of perception and by the force law, each named apart.

A published threshold is that of a group, for one site, contact and procedure. Thresholds therefore differ between
publications: the threshold of every finger is uncertain, and no share of people follows from it. How thresholds differ between
people was not read anywhere; a space that draws ``perception.threshold`` states it, and a share then contains it.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from electrovib.core.units import format_quantity
from electrovib.physics.perception import Perception
from electrovib.scenario import Scenario
from electrovib.studies.felt_spectrum import not_proportional

SAMPLING, THRESHOLDS, LAW = "sampling", "thresholds of perception", "force law"
TOGETHER, PEOPLE = "together", "differences of the threshold between people"
CONFIDENCE: Final = 0.95
"""Of every interval for a finite number of draws."""
COMMAND: Final = "electrovib evidence ultrashiver swing"
"""Computes `TYPICAL_FACTORS`: these are the absolute forces that were measured on a person's finger."""
TYPICAL_FACTORS: Final = {
    "EffectiveMedium": 14.0,
    "MaxwellStressInGap": 11.0,
    "MaxwellStressInInsulator": 15.0,
    "MaxwellStressInStratumCorneum": 2900.0,
    "Persson2018RoughGap": 9.7,
    "Vezzoli2014Causal": 10.0,
}
"""Typical factor by which a law misses them, two forces of two groups; a test computes it again."""
LEVEL, LOWEST_LEVEL, HIGHEST_LEVEL = (f"{which}detection level" for which in ("", "lowest ", "highest "))
"""Level above the middle of the thresholds, above the highest and above the lowest."""


@dataclass(frozen=True, kw_only=True)
class Width:
    """One reason why an answer about people is uncertain.

    - `name`: what is uncertain: `SAMPLING`, `THRESHOLDS`, `LAW` or `PEOPLE`; or several of them, `TOGETHER`.
    - `text`: what the interval is, or why it is not included and what computes it.
    - `interval`: ends that follow from it alone, in `unit` (``"1"``: as a factor of the force); NaN where no value of the
      searched range gives what is wanted. None stands for a width that is not included.
    """

    name: str
    text: str
    interval: tuple[float, float] | None = None
    unit: str = "1"

    @property
    def sentence(self) -> str:
        """What is uncertain, and by how much."""
        if self.interval is None:
            return f"Not included: {self.name}: {self.text}."
        low, high = self.interval
        ends = f"{shown_end(low, self.unit)} to {shown_end(high, self.unit)}"
        if self.unit == "1" and math.isclose(low * high, 1.0) and high > 1:  # a factor to both sides
            ends = f"1/{shown_end(high, self.unit)} to {shown_end(high, self.unit)}"
        head = self.name.capitalize() if self.name == TOGETHER else f"Width by {self.name}"
        return f"{head}, {ends}{' times the force' * (self.unit == '1')}: {self.text}."


def shown_end(value: float, unit: str) -> str:
    """Write an end of an interval, or why it has none."""
    if not math.isfinite(value):
        return "no value in the range" if math.isnan(value) else "no bound (too few draws)"
    return f"{value:+.1f} dB" if unit == "dB" else format_quantity(value, unit, digits=4)


def sentences(widths: Iterable[Width]) -> tuple[str, ...]:
    """Return one sentence for each width, those that are not included last."""
    return tuple(each.sentence for each in sorted(widths, key=lambda each: each.interval is None))


ONE_FINGER: Final = Width(name=SAMPLING, text="these are numbers of one finger; a space draws others")
UNFELT: Final = Width(
    name=THRESHOLDS,
    text="no number here says what is felt; 'electrovib find-value --want \"detection level = 0 dB\"' finds what is just felt",
)
BETWEEN_PEOPLE: Final = Width(
    name=PEOPLE,
    text="no publication read here prints it; in a space that draws perception.threshold, shares contain it",
)


def threshold_width(person: Perception, interval: tuple[float, float], *, unit: str, has_skin: bool) -> Width:
    """Return the width by the thresholds of a person, and by published skins where none is given."""
    text = "published thresholds" if person.threshold is None else "the uncertainty of perception.threshold"
    text += ", common to all fingers" if has_skin else " and published skins, common to all fingers"
    return Width(name=THRESHOLDS, text=text, interval=interval, unit=unit)


def factor_of(scenario: Scenario, quantity: str) -> float | None:
    """Return the typical factor of the law, None if unknown, or where the quantity is not proportional to the attraction."""
    is_force = bool({"electrostatic_force", "mean_force"} & set(quantity.split()))
    is_moved = quantity.endswith(LEVEL) or quantity == "swing lateral_force"
    follows = is_force or (is_moved and not not_proportional(scenario))
    return TYPICAL_FACTORS.get(type(scenario.force).__name__) if follows else None


def missed_by(law: str) -> str:
    """Write the typical factor of a law."""
    return f"{TYPICAL_FACTORS[law]:g} times" if law in TYPICAL_FACTORS else "not compared"


def law_width(
    law: str, factor: float | None, interval: tuple[float, float] | None = None, *, unit: str = "1"
) -> Width:
    """Return the width by a force law: the interval, by default that of its typical factor; not included without one."""
    if factor is None:
        why = f"no measured force says how far {law} is off here; '{COMMAND}' compares the laws"
        return Width(name=LAW, text=why)
    text = f"{law} misses the two forces that were measured on fingers by a factor of {factor:g} typically ({COMMAND})"
    return Width(name=LAW, text=text, interval=interval or (1 / factor, factor), unit=unit)


def clopper_pearson(number: int, count: int) -> tuple[float, float]:
    """Return the exact 95 % confidence interval of a probability, from quantiles of the beta distribution."""
    from scipy.stats import beta

    tail = (1 - CONFIDENCE) / 2
    low = 0.0 if number == 0 else float(beta.ppf(tail, number, count - number + 1))
    high = 1.0 if number == count else float(beta.ppf(1 - tail, number + 1, count - number))
    return low, high


def quantile_ranks(share: float, count: int) -> tuple[int, int]:
    """Return the ranks of the order statistics between which a quantile lies with a probability of at least 95 %.

    They are 0 and count + 1 where the sample is too small. The number of members below the quantile is
    binomial, whatever the distribution; the probability is exact for a continuous one.
    """
    from scipy.stats import binom

    tail = (1 - CONFIDENCE) / 2
    return int(binom.ppf(tail, count, share)), int(binom.ppf(1 - tail, count, share)) + 1
