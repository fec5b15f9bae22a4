"""The statistical laws of rough contact beside contact and attraction solved together, on twelve surfaces.

Run from the root of the repository with ``python -m benchmarks.rough_laws``. A law is one of those that `run`, `study` and
`evidence` use; every ratio is that of the law over the solver. Nothing that is fitted here is used by a law.
"""

from collections.abc import Callable, Sequence
from statistics import fmean
from typing import NamedTuple

import numpy as np
from benchmarks.table import surroundings, write_page
from scipy.optimize import minimize_scalar

from electrovib.core.constants import eps0
from electrovib.physics.contact.rough_surface import MOST_TOUCHING, exponential_gap, gaussian_gaps
from electrovib.physics.half_space import Elastic
from electrovib.physics.roughness import PullingSpots, contact_fraction, local_pull, mean_pull
from electrovib.physics.topography import SelfAffine
from electrovib.solve.rough_contact import Loaded, MaxwellStress, Rest

POINTS, SURFACES, DRAWS = 256, 12, 3
LOADS = (1e3, 7e3, 50e3)
BETWEEN = (2.6e3, 19e3)
"""Further loads [Pa] without attraction, for the mean gap over load."""
PULLS = (0.0, 0.1, 0.3, 1.0, 2.0, 4.0, 8.0, 16.0, 32.0, 64.0)
"""Attraction of a closed gap over the load, which sets the voltage."""
LEAST = 1e-3
"""Contact share below which a grid has too few points of contact for a comparison."""
OPEN = 0.75
"""Mean gap over the rms height above which an exponential is asked for."""
GOAL = 0.15
PREDICTED = (
    "Predicted before the first run: contact share without voltage 0.75 (0.55 to 0.9), with voltage 0.7 (0.4 to 1.1);"
    " attraction of plates 0.5 (0.1 to 1), of Gaussian gaps with the law's share 0.85 (0.6 to 1), with the solver's share"
    " 1.0 (0.8 to 1.2); decay factor 0.5 (0.4 to 0.7), pressure factor 0.4 of the roll-off wave number times the rms height;"
    " exponential within 20 % of the load; with attraction the mean gap 0.95 of that at load plus attraction."
)


class Surface(NamedTuple):
    """Roughness, effective modulus [Pa], and electrical thickness [m] of what lies on it."""

    number: int
    roughness: SelfAffine
    modulus: float
    electrical_thickness: float

    @property
    def periods(self):
        return (self.roughness.longest,) * 2

    @property
    def slope(self):
        return self.roughness.rms_slope(self.periods)

    def loaded(self, load, draw):
        heights = self.roughness.heights((POINTS, POINTS), self.periods, seed=DRAWS * self.number + draw)
        body = Elastic(modulus=self.modulus * 0.75, poisson=0.5)
        return Loaded(heights=heights, periods=self.periods, compliance=body.compliance, pressure=load)


class Case(NamedTuple):
    """A surface at rest under a load [Pa] and a voltage [V]: contact share, mean gap [m] and attraction [Pa] of the solver."""

    surface: Surface
    load: float
    voltage: float
    share: float
    gap: float
    attraction: float

    @property
    def borne(self):
        """Pressure [Pa] that the law's contact bears: load and attraction."""
        return self.load + self.attraction

    def law_share(self, factor=1.0):
        """Contact share of the law, with a factor to its pressure."""
        surface = self.surface
        return float(contact_fraction(factor * self.borne, modulus=surface.modulus, slope=surface.slope))

    def plates(self):
        thickness = self.surface.electrical_thickness
        return float(local_pull(self.voltage, electrical_thickness=thickness, gap=self.gap))

    def gaussian(self, share, gap=None):
        """Attraction [Pa] of Gaussian gaps with a share, and the solver's mean gap or another."""
        gaps = gaussian_gaps(
            mean_gap=self.gap if gap is None else gap, touching=float(min(share, MOST_TOUCHING))
        )
        thickness = self.surface.electrical_thickness
        pull = mean_pull(self.voltage, electrical_thickness=thickness, gaps=gaps, spots=PullingSpots())
        return float(pull.total)


def surfaces():
    """Return surfaces with rms height, Hurst exponent, range of waves, modulus and layer all varied."""
    for at in range(SURFACES):
        rms = 0.5e-6 * 60 ** (at / (SURFACES - 1))
        longest = 1e-3 * (rms / 5e-6) ** 0.5
        yield Surface(
            at,
            SelfAffine(
                rms=rms,
                hurst=0.5 + 0.1 * (3 * at % 5),
                longest=longest,
                roll_off=longest / (2, 4)[at // 2 % 2],
                shortest=longest / (16, 32)[at // 3 % 2],
            ),
            modulus=(0.3e6, 1e6, 3e6)[(1 + 2 * at) % 3],
            electrical_thickness=(1e-6, 3e-6, 10e-6)[at // 4],
        )


def followed(surface, load, draw):
    """Return the cases of rising voltage, and what ends them: a fall, or a grid that does not resolve the attraction."""
    contact, start, found = surface.loaded(load, draw), None, []
    for pull in PULLS if load in LOADS else (0.0,):
        voltage = surface.electrical_thickness * (2 * load * pull / eps0) ** 0.5
        attraction = MaxwellStress(voltage=voltage, electrical_thickness=surface.electrical_thickness)
        rest: Rest = contact.rest(attraction if voltage else None, start=start)
        if rest.fell or rest.steepness > 1:
            return found, "falls" if rest.fell else "grid"
        start = rest.gap
        found.append(Case(surface, load, voltage, rest.contact_share, rest.mean_gap, rest.mean_attraction))
    return found, "last"


def averaged(draws):
    """Return the mean over draws of a case, as of a finger that is many periods wide."""
    first = draws[0]
    return first._replace(
        **{name: fmean(getattr(each, name) for each in draws) for name in ("share", "gap", "attraction")}
    )


class Measured(NamedTuple):
    """All that is solved of a surface: cases of single draws and their means, and what ended the voltage, by load."""

    surface: Surface
    single: list
    mean: list
    ends: list
    coarser: list

    def line(self, cases):
        """Return decay factor, pressure factor, and the largest error in load of the best exponential."""
        known = [case for case in cases if not case.voltage]
        rms, modulus = self.surface.roughness.rms, self.surface.modulus
        logs = np.log([case.load / modulus for case in known])
        gaps = np.array([case.gap for case in known]) / rms
        slope, level = np.polyfit(logs, gaps, 1)
        off = np.abs(gaps - level - slope * logs).max() / -slope
        return -slope, float(np.exp(-level / slope)), float(np.exp(off))


def measured(surface):
    """Solve all draws, loads and voltages of a surface; cases outside the range of the laws are left out."""
    single, mean, ends, coarser = [], [], [], []
    for load in sorted(LOADS + BETWEEN):
        draws, why = zip(*(followed(surface, load, draw) for draw in range(DRAWS)), strict=True)
        single += [case for draw in draws for case in draw if LEAST <= case.share <= MOST_TOUCHING]
        together = [averaged(each) for each in zip(*draws, strict=False)]
        mean += [case for case in together if LEAST <= case.share <= MOST_TOUCHING]
        if load in LOADS:
            ends.append(f"{max(case.voltage for case in together):.3g} V, {why[0]}")
            fine = surface.loaded(load, 0)
            coarse = Loaded(
                heights=fine.heights[::2, ::2],
                periods=fine.periods,
                compliance=fine.compliance,
                pressure=load,
            ).rest()
            if LEAST <= draws[0][0].share <= MOST_TOUCHING:
                coarser.append(coarse.contact_share / draws[0][0].share)
    return Measured(surface, single, mean, ends, coarser)


RATIOS: dict[str, Callable[[Case], float]] = {
    "contact share without voltage": lambda case: np.nan if case.voltage else case.law_share() / case.share,
    "contact share with voltage": lambda case: case.law_share() / case.share if case.voltage else np.nan,
    "attraction of plates at the mean gap": lambda case: pulled(case, case.plates),
    "attraction of Gaussian gaps, share of the law": lambda case: pulled(
        case, lambda: case.gaussian(case.law_share())
    ),
    "attraction of Gaussian gaps, share of the solver": lambda case: pulled(
        case, lambda: case.gaussian(case.share)
    ),
}


def pulled(case, law):
    """Return the attraction of a law over that of the solver; not a number without a voltage."""
    return law() / case.attraction if case.voltage else np.nan


def known(values):
    found = np.asarray(list(values), dtype=float)
    return found[np.isfinite(found)]


def spread(values):
    """Write median and range."""
    found = known(values)
    return f"{np.median(found):.3f} ({found.min():.3f} to {found.max():.3f})" if found.size else "-"


def within(values):
    """Write the share of ratios within the goal."""
    return f"{100 * np.mean(np.abs(np.log(known(values))) <= np.log(1 + GOAL)):.0f} %"


def fitted(ratio, cases):
    """Return the factor for which the largest error over some cases is least."""

    def worst(log_factor):
        return float(np.abs(np.log(known(ratio(case, np.exp(log_factor)) for case in cases))).max())

    return float(np.exp(minimize_scalar(worst, bounds=(-1.5, 1.5), method="bounded").x))


def of_all(found: Sequence[Measured], mean=True):
    return [case for each in found for case in (each.mean if mean else each.single)]


def exponential(case, *, decay, factor):
    """Return the mean gap [m] of the exponential law under load and attraction."""
    surface = case.surface
    return float(
        exponential_gap(case.borne, flat=factor * surface.modulus, decay=decay * surface.roughness.rms)
    )


def summary(found):
    rows = [
        (
            name,
            spread(map(ratio, of_all(found, mean=False))),
            spread(map(ratio, of_all(found))),
            within(map(ratio, of_all(found))),
        )
        for name, ratio in RATIOS.items()
    ]
    lines = [each.line(each.mean) for each in found]
    waves = [2 * np.pi * each.surface.roughness.rms / each.surface.roughness.roll_off for each in found]
    slopes = [each.surface.slope for each in found]
    decay, factor, off = zip(*lines, strict=True)
    beside = [
        (case.gap / case.surface.roughness.rms, case.gap / exponential(case, decay=line[0], factor=line[1]))
        for each, line in zip(found, lines, strict=True)
        for case in each.mean
        if case.voltage
    ]
    numbers = {
        "decay factor": decay,
        "pressure factor": factor,
        "pressure factor over roll-off wave number times rms height": np.divide(factor, waves),
        "pressure factor over rms slope": np.divide(factor, slopes),
        "largest error of the exponential, as a factor in load": off,
        "mean gap with voltage over the exponential at load plus attraction": [ratio for _, ratio in beside],
        f"the same, mean gaps above {OPEN:g} rms heights": [
            ratio for height, ratio in beside if height > OPEN
        ],
        "contact share on every second point, over that of the grid": [
            ratio for each in found for ratio in each.coarser
        ],
    }
    return rows + [(name, "-", spread(values), "-") for name, values in numbers.items()]


def corrections(found):
    """Fit each correction on every other surface, and test it on the others."""
    fit, test = of_all(found[::2]), of_all(found[1::2])
    lines = [each.line(each.mean) for each in found[::2]]
    decay = float(np.median([line[0] for line in lines]))
    steep = float(
        np.median([line[1] / each.surface.slope for line, each in zip(lines, found[::2], strict=True)])
    )

    def without_gap(case, factor):
        gap = exponential(case, decay=decay, factor=steep * case.surface.slope)
        return pulled(case, lambda: case.gaussian(factor * case.law_share(), gap)) if gap else np.nan

    tried = {
        "contact share of the law under a pressure times": lambda case, factor: (
            case.law_share(factor) / case.share
        ),
        "attraction of Gaussian gaps with the law's share, all times": lambda case, factor: pulled(
            case, lambda: factor * case.gaussian(case.law_share())
        ),
        "attraction of Gaussian gaps with the law's share times": lambda case, factor: pulled(
            case, lambda: case.gaussian(factor * case.law_share())
        ),
        f"the same, mean gap from decay factor {decay:.3f} and pressure factor {steep:.3f} rms slopes": without_gap,
    }
    rows = []
    for name, ratio in tried.items():
        factor = fitted(ratio, fit)
        row = [f"{name} {factor:.3f}"]
        for cases in (fit, test, of_all(found[1::2], mean=False)):
            row += [
                spread(ratio(case, factor) for case in cases),
                within(ratio(case, factor) for case in cases),
            ]
        rows.append(row)
    return rows


def each_surface(found):
    for each in found:
        rough, surface = each.surface.roughness, each.surface
        decay, factor, _ = each.line(each.mean)
        yield (
            f"{rough.rms * 1e6:.2f}",
            f"{rough.hurst:.1f}",
            " / ".join(f"{wave * 1e3:.3g}" for wave in (rough.longest, rough.roll_off, rough.shortest)),
            f"{surface.slope:.3f}",
            f"{surface.modulus / 1e6:g}",
            f"{surface.electrical_thickness * 1e6:g}",
            *(spread(map(ratio, each.mean)) for ratio in RATIOS.values()),
            f"{decay:.3f}",
            f"{factor:.3f}",
            "; ".join(each.ends),
        )


def main() -> None:
    """Measure and write the page."""
    found = [measured(surface) for surface in surfaces()]
    counts = f"{len(of_all(found, mean=False))} contacts solved, {len(of_all(found))} means of {DRAWS} draws"
    write_page(
        "rough_laws.md",
        "Statistical laws of rough contact beside the contact solved",
        [
            f"Law over solver, median and range. {SURFACES} surfaces, {POINTS} x {POINTS} points, {DRAWS} draws of the phases"
            f" each, loads of 1, 7 and 50 kPa, voltages until a contact falls shut or the grid does not resolve the attraction,"
            f" contact shares of {LEAST:g} to {MOST_TOUCHING:g}: {counts}. Spots pull. The law's share is that under load"
            " plus the solver's attraction; its mean gap is the solver's where nothing else is said.",
            PREDICTED,
            surroundings(["numpy", "scipy"]),
        ],
        [
            (
                "All surfaces",
                [],
                ("quantity", "single draws", "mean of draws", f"within {100 * GOAL:.0f} %"),
                summary(found),
            ),
            (
                "Corrections with one factor",
                [
                    "Fitted to the mean of draws of every other surface, so that the largest error is least. No law uses them."
                ],
                (
                    "correction",
                    "fitted surfaces",
                    f"within {100 * GOAL:.0f} %",
                    "other surfaces",
                    f"within {100 * GOAL:.0f} %",
                    "single draws of these",
                    f"within {100 * GOAL:.0f} %",
                ),
                corrections(found),
            ),
            (
                "Each surface",
                ["Mean of draws; largest voltage at 1, 7 and 50 kPa, and what ends the first draw there."],
                (
                    "rms [um]",
                    "Hurst",
                    "longest / roll-off / shortest [mm]",
                    "slope",
                    "E* [MPa]",
                    "electrical thickness [um]",
                    *RATIOS,
                    "decay factor",
                    "pressure factor",
                    "largest voltages",
                ),
                list(each_surface(found)),
            ),
        ],
    )


if __name__ == "__main__":
    main()
