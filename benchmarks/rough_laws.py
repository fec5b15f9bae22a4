"""The statistical laws of rough contact beside contact and attraction solved together: their errors, and their correction.

Run from the root of the repository with ``python -m benchmarks.rough_laws``. A law is one of those that `run`, `study` and
`evidence` use; every ratio is that of the law over the solver. The six numbers of `FittedSurface` are fitted on 30 surfaces
here, rounded there, and tested on ten others.
"""

import math
from collections import Counter
from concurrent.futures import ProcessPoolExecutor
from statistics import fmean
from typing import NamedTuple
from unittest.mock import patch

import numpy as np
from benchmarks.table import surroundings, write_page
from scipy.optimize import minimize, minimize_scalar

from electrovib.core.constants import eps0
from electrovib.physics.contact.attraction import RoughAttraction
from electrovib.physics.contact.surface import MOST_TOUCHING, FittedSurface, gaussian_gaps
from electrovib.physics.half_space import Elastic
from electrovib.physics.roughness import PullingSpots, contact_fraction, local_pull, mean_pull
from electrovib.physics.topography import POINTS_PER_WAVE, SelfAffine
from electrovib.solve.diagnostics.closed_gap import pressed_gaps
from electrovib.solve.electrics.attraction import borne
from electrovib.solve.rough_contact import Loaded, MaxwellStress

FITTED, OTHERS, DRAWS = 30, 10, 8
LOADS = (1e3, 2.6e3, 7e3, 19e3, 50e3)
PULLED = (1e3, 7e3, 50e3)
"""Loads [Pa] under which the voltage is raised."""
PULLS = (0.0, 0.3, *(2.0 ** (half / 2) for half in range(21)))
"""Attraction of a closed gap over the load, which sets the voltage; the last is beyond the breakdown of most films."""
LEAST = 1e-3
"""Contact share below which a grid has too few points of contact for a comparison."""
GOAL = 0.15
MUCH = 0.4
"""Attraction over load above which what the spots hold is fitted, from the load alone: below it changes little."""
FALLEN = 2.0
"""Ratio to which a law counts that has fallen shut before the solver, in the fit."""
NARROW = 0.3
"""Gap over the electrical thickness up to which a place counts as narrow: the film has 0.77 of the field of a closed gap."""


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

    @property
    def law(self):
        rms = self.roughness.rms
        return FittedSurface(modulus=self.modulus, rms_height=rms, rms_slope=self.slope)


class Case(NamedTuple):
    """A surface at rest under a load [Pa] and a voltage [V], by the solver.

    Contact share, extrapolated to a grid without end from every second point, of whose spacing its error is a multiple, by
    their ratio without a voltage; mean gap [m], attraction [Pa], and the share of narrow places.
    """

    surface: Surface
    load: float
    voltage: float
    share: float
    on_grid: float
    gap: float
    attraction: float
    narrow: float

    @property
    def whole(self):
        return self.load + self.attraction

    @property
    def borne(self):
        """Pressure [Pa] that the corrected law's contact bears: load and attraction, without what its spots hold."""
        return self.without(FittedSurface.held)

    def without(self, held):
        closed = local_pull(self.voltage, electrical_thickness=self.surface.electrical_thickness)
        return self.whole - held * self.share * float(closed)

    def gaps(self, share, gap=None, power=1.0):
        """Return the local gaps of a law with a share, and the solver's mean gap or another."""
        mean_gap = self.gap if gap is None else gap
        return gaussian_gaps(mean_gap=mean_gap, touching=float(min(share, MOST_TOUCHING)), power=power)

    def pulled(self, gaps):
        """Return the attraction of local gaps over that of the solver."""
        thickness = self.surface.electrical_thickness
        pull = mean_pull(self.voltage, electrical_thickness=thickness, gaps=gaps, spots=PullingSpots())
        return float(pull.total) / self.attraction

    def erf_share(self):
        return float(contact_fraction(self.whole, modulus=self.surface.modulus, slope=self.surface.slope))

    def plates(self):
        thickness = self.surface.electrical_thickness
        pull = local_pull(self.voltage, electrical_thickness=thickness, gap=self.gap)
        return float(pull) / self.attraction

    def from_load(self):
        """Return the attraction of the corrected law by itself, from the load alone, over that of the solver."""
        law, thickness = self.surface.law, self.surface.electrical_thickness
        attraction = RoughAttraction(
            voltage=self.voltage, electrical_thickness=thickness, surface=law, spots=PullingSpots()
        )
        gaps, _ = pressed_gaps(law, attraction, self.load)
        return math.nan if gaps is None else self.pulled(gaps)

    def of_a_run(self):
        """Return the contact share of a run, which finds from its attraction what the spots hold."""
        law, both = self.surface.law, (np.array([self.whole]), np.array([self.attraction]))
        pressure = borne(law, *both, electrical_thickness=self.surface.electrical_thickness)
        return float(law.real_share(pressure)[0])

    def corrected(self):
        """Return the local gaps of the corrected law under the pressure that is borne."""
        law, at = self.surface.law, np.asarray(self.borne)
        return self.gaps(float(law.real_share(at)), float(law.gap(at)), law.power)


def surfaces(first, count):
    """Return surfaces with rms height, spectrum, modulus and layer varied, without a relation between them."""
    for at in range(count):
        even = [math.modf((first + at + 1) * math.sqrt(prime))[0] for prime in (2, 3, 5, 7, 11, 13)]
        rms = 0.5e-6 * 60 ** ((at + 0.5) / count)
        longest = 1e-3 * (rms / 5e-6) ** 0.5 * 2 ** (even[0] - 0.5)
        roll_off, shortest = (2, 3, 4)[int(3 * even[2])], (16, 24, 32)[int(3 * even[3])]
        hurst = round(0.5 + 0.4 * even[1], 2)
        yield Surface(
            first + at,
            SelfAffine(
                rms=rms,
                hurst=hurst,
                longest=longest,
                roll_off=longest / roll_off,
                shortest=longest / shortest,
            ),
            modulus=0.2e6 * 50 ** even[4],
            electrical_thickness=0.25e-6 * 40 ** even[5],
        )


def followed(surface, load, heights, pulls):
    """Return voltage and rest of rising voltages, and what ends them: a fall, or a grid that does not resolve the attraction."""
    body, thickness = Elastic(modulus=surface.modulus * 0.75, poisson=0.5), surface.electrical_thickness
    contact = Loaded(heights=heights, periods=surface.periods, compliance=body.compliance, pressure=load)
    found, start = [], None
    for pull in pulls:
        voltage = thickness * (2 * load * pull / eps0) ** 0.5
        attraction = MaxwellStress(voltage=voltage, electrical_thickness=thickness) if voltage else None
        rest = contact.rest(attraction, start=start)
        if rest.fell or rest.steepness > 1:
            return found, "falls" if rest.fell else "grid"
        if rest.contact_share > MOST_TOUCHING:
            return found, "closes"
        start = rest.gap
        found.append((voltage, rest))
    return found, "last"


def drawn(job):
    """Return the cases of one draw of a surface under a load, and what ended the voltage."""
    surface, load, draw = job
    seed = DRAWS * surface.number + draw
    points = round(POINTS_PER_WAVE * surface.roughness.longest / surface.roughness.shortest)
    heights = surface.roughness.heights((points, points), surface.periods, seed=seed)
    fine, why = followed(surface, load, heights, PULLS if load in PULLED else PULLS[:1])
    # a coarser grid does not resolve an attraction near its fall, so the error of the share is that without it
    coarse, _ = followed(surface, load, heights[::2, ::2], PULLS[:1])
    if not (fine and coarse):
        return [], why
    on_grid = 2 - coarse[0][1].contact_share / fine[0][1].contact_share
    cases = []
    for voltage, rest in fine:
        share = rest.contact_share * on_grid
        narrow = float(np.mean(rest.gap <= NARROW * surface.electrical_thickness))
        numbers = share, rest.contact_share, rest.mean_gap, rest.mean_attraction, narrow
        cases.append(Case(surface, load, voltage, *numbers))
    return cases, why


def averaged(draws):
    """Return the mean over draws of a case, as of a finger that is many periods wide."""
    names = ("share", "on_grid", "gap", "attraction", "narrow")
    return draws[0]._replace(**{name: fmean(getattr(each, name) for each in draws) for name in names})


def known(cases):
    return [case for case in cases if LEAST <= case.share <= MOST_TOUCHING]


def solved(found, pool):
    """Return the means over draws of all cases of some surfaces, single draws, and what ended the voltages."""
    places = [(surface, load) for surface in found for load in LOADS]
    jobs = [(*place, draw) for place in places for draw in range(DRAWS)]
    done = list(pool.map(drawn, jobs, chunksize=DRAWS))
    mean, single, ends = [], [], Counter()
    for at in range(len(places)):
        draws, why = zip(*done[at * DRAWS : (at + 1) * DRAWS], strict=True)
        mean += known(averaged(each) for each in zip(*draws, strict=False))
        single += known(case for each in draws for case in each)
        ends.update(why if places[at][1] in PULLED else ())
    return mean, single, ends


def on(cases):
    return [case for case in cases if case.voltage]


UNCORRECTED = {
    "contact share of the erf law": lambda cases: [case.erf_share() / case.share for case in cases],
    "attraction of plates at the mean gap": lambda cases: [case.plates() for case in on(cases)],
    "attraction of Gaussian gaps, share of the erf law": lambda cases: [
        case.pulled(case.gaps(case.erf_share())) for case in on(cases)
    ],
    "attraction of Gaussian gaps, share of the solver": lambda cases: [
        case.pulled(case.gaps(case.share)) for case in on(cases)
    ],
}
"""Laws without a correction; the mean gap is the solver's."""
CORRECTED = {
    "contact share": lambda cases: [
        float(case.surface.law.real_share(np.asarray(case.borne))) / case.share for case in cases
    ],
    "contact share of a run": lambda cases: [case.of_a_run() / case.share for case in cases],
    "mean gap": lambda cases: [
        float(case.surface.law.gap(np.asarray(case.borne))) / case.gap for case in cases
    ],
    "attraction": lambda cases: [case.pulled(case.corrected()) for case in on(cases)],
    "attraction from the load alone": lambda cases: [case.from_load() for case in on(cases)],
    "share of narrow places": lambda cases: [
        float(case.corrected().share_up_to(NARROW * case.surface.electrical_thickness)) / case.narrow
        for case in cases
    ],
}


def spread(values):
    """Write median and range of what is known."""
    found = np.asarray(list(values), dtype=float)
    found = found[np.isfinite(found)]
    return f"{np.median(found):.3f} ({found.min():.3f} to {found.max():.3f})" if found.size else "-"


def within(values):
    """Write the share of ratios within the goal; what is not known is not."""
    return f"{100 * np.mean(np.abs(np.log(list(values))) <= np.log(1 + GOAL)):.0f} %"


def fitted(cases):
    """Return the numbers of the corrected law that are best on some cases: least squares of logarithms."""
    stiff = np.array([case.surface.modulus * case.surface.slope for case in cases])
    rms = np.array([case.surface.roughness.rms for case in cases])
    share, gap = (np.array([getattr(case, name) for case in cases]) for name in ("share", "gap"))
    much = [case for case in on(cases) if case.attraction > MUCH * case.load]
    best = {"method": "Nelder-Mead", "options": {"xatol": 1e-5, "fatol": 1e-9}}
    one = {"method": "bounded", "options": {"xatol": 1e-3}}

    def off_power(power):
        law = [case.pulled(case.gaps(case.share, power=power)) for case in on(cases)[::3]]
        return float(np.mean(np.log(law) ** 2))

    def numbers(held):
        reduced = np.array([case.without(held) for case in cases]) / stiff

        def off_share(these):
            law = contact_fraction(these[0] * reduced ** these[1], modulus=1.0, slope=1.0)
            return float(np.mean(np.log(law / share) ** 2))

        def off_gap(these):
            law = rms * these[1] * np.log(these[0] / reduced)
            return float(np.mean(np.log(np.maximum(law, 1e-3 * rms) / gap) ** 2))

        first, second = minimize(off_share, (1.0, 1.0), **best).x, minimize(off_gap, (0.5, 0.4), **best).x
        return dict(zip(("SHARE", "GROWTH", "FLAT", "DECAY"), (*first, *second), strict=True)) | {
            "held": held,
            "power": power,
        }

    def off_held(held):
        with patch.multiple(FittedSurface, **numbers(held)):
            law = np.nan_to_num([case.from_load() for case in much], nan=FALLEN)
        return float(np.mean(np.log(law) ** 2))

    power = minimize_scalar(off_power, bounds=(1.0, 1.6), **one).x
    held = minimize_scalar(off_held, bounds=(0.0, 1.0), **one).x
    return numbers(FittedSurface.held) | {"held": held}


def compared(laws, groups):
    """Return a row for each law: median, range and share within the goal on each group of cases."""
    for name, law in laws.items():
        yield (name, *(write(law(cases)) for cases in groups for write in (spread, within)))


def by_share(cases):
    """Return the corrected law by share in contact, attraction over load, and rms height over electrical thickness."""
    groups = {
        f"contact share {low:g} to {high:g}": [case for case in cases if low <= case.share < high]
        for low, high in ((1e-3, 0.01), (0.01, 0.1), (0.1, 0.5))
    }

    def over(case):
        return case.surface.roughness.rms / case.surface.electrical_thickness

    groups |= {
        f"attraction {low:g} to {high:g} times the load": [
            case for case in on(cases) if low <= case.attraction / case.load < high
        ]
        for low, high in ((0, 0.1), (0.1, 0.4), (0.4, 1), (1, 1000))
    }
    groups |= {
        f"rms height {low:g} to {high:g} electrical thicknesses": [
            case for case in cases if low <= over(case) < high
        ]
        for low, high in ((0, 1), (1, 10), (10, 1000))
    }
    for name, some in groups.items():
        yield (name, *(write(law(some)) for law in CORRECTED.values() for write in (spread, within)))


def each_surface(found, cases):
    for surface in found:
        own, rough = [case for case in cases if case.surface.number == surface.number], surface.roughness
        yield (
            f"{rough.rms * 1e6:.2f}",
            f"{rough.hurst:.2f}",
            " / ".join(f"{wave * 1e3:.3g}" for wave in (rough.longest, rough.roll_off, rough.shortest)),
            f"{surface.slope:.3f}",
            f"{surface.modulus / 1e6:.2g}",
            f"{surface.electrical_thickness * 1e6:.2g}",
            f"{max(case.voltage for case in own):.3g}",
            *(spread(law(own)) for law in CORRECTED.values()),
        )


def main() -> None:
    """Measure and write the page."""
    first, others = list(surfaces(0, FITTED)), list(surfaces(100, OTHERS))
    with ProcessPoolExecutor(2) as pool:
        fit, _, ends = solved(first, pool)
        test, single, more = solved(others, pool)
    ended = ", ".join(f"{name} {count}" for name, count in (ends + more).items())
    numbers = ", ".join(
        f"{name} {best:.3f} ({getattr(FittedSurface, name):.3f})" for name, best in fitted(fit).items()
    )
    within_goal = f"within {100 * GOAL:.0f} %"
    write_page(
        "rough_laws.md",
        "Statistical laws of rough contact beside the contact solved",
        [
            f"Law over solver, median and range, on means of {DRAWS} draws of the phases. {FITTED} surfaces for the fit and"
            f" {OTHERS} others, {POINTS_PER_WAVE} points for the shortest wave, rms heights of 0.5 to 30 um, loads of 1 to 50"
            " kPa; at 1, 7 and 50 kPa the voltage rises in steps of a factor of 1.19 until, in one of the draws, the contact or a"
            " part of it falls shut, or half of it touches, the grid does not resolve the attraction, or"
            f" a closed gap pulls {PULLS[-1]:g} times the load ({ended}). Contact shares of {LEAST:g} to {MOST_TOUCHING:g}:"
            f" {len(fit)} and {len(test)} contacts. Spots pull. A law has the pressure of load and"
            " solver's attraction, the corrected one without what the spots hold.",
            f"The share on the grid is {spread(case.on_grid / case.share for case in fit)} times that of a grid without end;"
            " that one is the solver's here, from this grid and every second point of it.",
            f"Best on the fitted surfaces, and in `FittedSurface`: {numbers}. `held` is the best for the attraction from the load"
            " alone, and smaller in `FittedSurface`, where the contact share errs less; the others are the best with that one.",
            surroundings(["numpy", "scipy"]),
        ],
        [
            (
                "Without a correction, all surfaces",
                ["Mean gap of the solver."],
                ("quantity", "law over solver", within_goal),
                list(compared(UNCORRECTED, [fit + test])),
            ),
            (
                "Corrected: `FittedSurface`",
                [
                    f"Narrow places have a gap up to {NARROW:g} of the electrical thickness, contact included. From the load"
                    " alone the law finds the attraction by itself, which errs more the nearer the contact is to falling shut;"
                    " where the law has fallen before the solver, its attraction is not known and not within."
                ],
                (
                    "quantity",
                    *("fitted surfaces", within_goal),
                    *("ten others", within_goal),
                    *("single draws of these", within_goal),
                ),
                list(compared(CORRECTED, [fit, test, single])),
            ),
            (
                "Corrected, where",
                ["All surfaces."],
                ("contacts", *(head for name in CORRECTED for head in (name, within_goal))),
                list(by_share(fit + test)),
            ),
            (
                "Each surface, corrected",
                [f"The last {OTHERS} are the others."],
                (
                    "rms [um]",
                    "Hurst",
                    "longest / roll-off / shortest [mm]",
                    "slope",
                    "E* [MPa]",
                    "electrical thickness [um]",
                    "largest voltage [V]",
                    *CORRECTED,
                ),
                list(each_surface(first + others, fit + test)),
            ),
        ],
    )


if __name__ == "__main__":
    main()
