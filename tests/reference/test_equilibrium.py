"""Every equilibrium is found: against polynomial roots, dense scans, the closed forms of a spring, and simulate."""

import functools
from collections import Counter
from itertools import pairwise

import mpmath
import numpy as np
import pytest
from parallel_plates import equilibria, pull_in_voltage
from scenario_parts import EPS0
from scipy.optimize import brentq, minimize_scalar

from electrovib.papers.ciavarella_2020 import BearingArea
from electrovib.physics.contact import LinearSpring, PerssonSurface, PlateAttraction, RoughAttraction
from electrovib.physics.roughness import IdleSpots, PullingSpots
from electrovib.solve.equilibrium import hysteresis
from electrovib.solve.equilibrium.states import NOISE, balance, follow

SETS = 1000


def log_uniform(random, low, high):
    return float(10 ** random.uniform(np.log10(low), np.log10(high)))


def random_spring(random):
    """A spring, a load, layers and a voltage around the one of pull-in; free gaps on both sides of K/2."""
    free_gap = log_uniform(random, 1e-7, 1e-4)
    thickness = free_gap * log_uniform(random, 0.03, 10)
    spring = LinearSpring(stiffness=log_uniform(random, 1e6, 1e12), free_gap=free_gap)
    pressure = spring.stiffness * free_gap * random.choice([0.0, random.uniform(0, 0.9)])
    left = free_gap - pressure / spring.stiffness
    scale = np.sqrt(8 * spring.stiffness * (thickness + left) ** 3 / (27 * EPS0))
    return spring, pressure, thickness, float(scale * random.uniform(0.2, 1.3))


def states_of(spring, pressure, thickness, voltage):
    return equilibria(surface=spring, pressure=pressure, voltage=voltage, electrical_thickness=thickness)


def snap_of(spring, pressure, thickness):
    given = {"stiffness": spring.stiffness, "free_gap": spring.free_gap, "pressure": pressure}
    return pull_in_voltage(**given, electrical_thickness=thickness)


def by_polynomial(spring, pressure, thickness, voltage):
    """Real roots of the cubic between closed and free, to 40 digits, in units of the free gap."""
    with mpmath.workdps(40):
        unit = mpmath.mpf(spring.free_gap)
        k, electrical = mpmath.mpf(spring.stiffness) * unit, mpmath.mpf(thickness) / unit
        left = 1 - mpmath.mpf(pressure) / k
        stress = mpmath.mpf(EPS0) * mpmath.mpf(voltage) ** 2 / 2 / unit**2 / k
        # (left - u) (electrical + u)^2 - stress
        powers = [
            left * electrical**2 - stress,
            2 * electrical * left - electrical**2,
            left - 2 * electrical,
            -1,
        ]
        roots = mpmath.polyroots(powers, asc=True, maxsteps=500, extraprec=200)
        real = [mpmath.re(r) for r in roots if abs(mpmath.im(r)) < mpmath.mpf(10) ** -25 * (1 + abs(r))]
        return sorted(float(r * unit) for r in real if 0 <= r <= left)


def test_a_springs_states_are_the_roots_of_its_cubic():
    random, counts = np.random.default_rng(1), {0: 0, 1: 0, 2: 0}
    for _ in range(SETS):
        spring, pressure, thickness, voltage = random_spring(random)
        expected = by_polynomial(spring, pressure, thickness, voltage)
        states = states_of(spring, pressure, thickness, voltage)
        open_ones = [state for state in states if not state.touching]
        assert len(open_ones) == len(expected)
        counts[len(expected)] += 1
        for state, gap in zip(open_ones, expected, strict=True):
            # rounding of the pressures over the slope of their difference
            slope = spring.stiffness - EPS0 * voltage**2 / (thickness + gap) ** 3
            noise = 2e-15 * (spring.stiffness * spring.free_gap + state.attraction) / abs(slope)
            assert abs(state.gap - gap) <= 1e-13 * gap + noise
            assert state.stable == (slope > 0)
            assert abs(state.residual) <= 1e-13 * (state.repulsion + pressure + state.attraction)
        closed = pressure + EPS0 * voltage**2 / (2 * thickness**2) > spring.stiffness * spring.free_gap
        assert [state.touching for state in states[:1]] == [closed]
        if closed:
            assert states[0].gap == 0
            assert states[0].stable
            borne = states[0].repulsion + states[0].stop
            assert borne == pytest.approx(pressure + states[0].attraction, rel=1e-12)
        # stable and unstable take turns, the ends are stable: two stable states are a hysteresis
        assert [state.stable for state in states] == [index % 2 == 0 for index in range(len(states))]
    assert min(counts.values()) > 50  # every case was tried


def by_scan(difference, low, high, points):
    """Changes of sign over a dense grid, closer where the difference turns without one, each solved apart."""
    grid = np.unique(np.append(np.linspace(low, high, points), np.geomspace(high * 1e-6, high, points)))
    grid = grid[grid >= low]
    values = np.array([difference(gap) for gap in grid])
    for k in range(1, len(grid) - 1):  # a pair of roots between three points
        if values[k - 1] * values[k] > 0 and abs(values[k]) < min(abs(values[k - 1]), abs(values[k + 1])):
            sign = np.sign(values[k])
            around, close = (grid[k - 1], grid[k + 1]), {"xatol": 1e-12 * grid[k]}
            towards = functools.partial(lambda x, sign: sign * difference(x), sign=sign)
            turn = minimize_scalar(towards, bounds=around, method="bounded", options=close).x
            grid = np.append(grid, turn)
    grid = np.sort(grid)
    values = np.array([difference(gap) for gap in grid])
    pairs = zip(pairwise(grid), pairwise(values), strict=True)
    found = [between for between, (at_a, at_b) in pairs if at_a * at_b < 0]
    return [brentq(difference, a, b, xtol=1e-20, rtol=1e-14) for a, b in found]


def random_skin(random):
    modulus, rms = log_uniform(random, 1e5, 1e9), log_uniform(random, 1e-6, 5e-5)
    if random.integers(2):
        factors = {"pressure_factor": random.uniform(0.1, 1), "decay_factor": random.uniform(0.3, 1)}
        return PerssonSurface(modulus=modulus, rms_slope=1.0, rms_gap=rms, **factors)
    prefactor, longest = random.uniform(0.5, 1.5), rms * random.uniform(10, 100)
    heights = {"rms_height": rms, "rms_slope": 1.0, "longest_wavelength": longest}
    return BearingArea(prefactor=prefactor, modulus=modulus, **heights)


def difference_of(skin, attraction, pressure, gap):
    return float(skin.pressure(np.asarray(gap))) - pressure - attraction.pressure(float(gap))


@pytest.mark.slow
@pytest.mark.parametrize(("spots", "sets"), [(None, SETS), (PullingSpots(), 25), (IdleSpots(), 25)])
def test_states_of_a_rough_skin_are_those_of_a_dense_scan(spots, sets):
    """Under plates at one gap, and under an attraction averaged over the gaps."""
    random, counts = np.random.default_rng(3 if spots else 2), Counter()
    for _ in range(sets):
        skin = random_skin(random)
        softest = skin.modulus * 1e-3 if spots else float(skin.pressure(np.asarray(0.0)))
        pressure = softest * log_uniform(random, 1e-2 if spots else 1e-6, 10 if spots else 0.5)
        free = float(skin.gap(np.asarray(pressure)))
        thickness = free * log_uniform(random, 1e-3, 1 if spots else 3)
        attracted = functools.partial(PlateAttraction, electrical_thickness=thickness)
        if spots:
            averaged = {"electrical_thickness": thickness, "surface": skin, "spots": spots}
            attracted = functools.partial(RoughAttraction, **averaged)
        low = attracted(voltage=1.0).smallest_gap if spots else 0.0
        if low >= 0.8 * free:
            continue
        # a voltage that balances at some gap, then a little more or less
        somewhere = random.uniform(low, free)
        missing = difference_of(skin, PlateAttraction(0.0, thickness), pressure, somewhere)
        nearby = 1 if spots else random.choice([1, random.uniform(0.8, 1.2)])
        voltage = float(np.sqrt(missing / attracted(voltage=1.0).pressure(somewhere)) * nearby)
        attraction = attracted(voltage=voltage)
        difference = functools.partial(difference_of, skin, attraction, pressure)
        expected = by_scan(difference, low, free * (1 + 1e-6), 150 if spots else 200)
        states = balance(skin, attraction, pressure=pressure)
        found = [state for state in states if not state.touching]
        counts[len(expected)] += 1
        assert len(found) == len(expected)
        # near folds both waver
        np.testing.assert_allclose([state.gap for state in found], expected, rtol=1e-7)
        assert all(abs(state.residual) <= 1e-12 * state.repulsion for state in found)
        for state in found:
            # self-consistent: the surface topography bears the load and the average over the gaps that it then has
            assert state.repulsion == pytest.approx(pressure + attraction.pressure(state.gap), rel=1e-12)
            nudge = 1e-5 * min([state.gap, *(abs(o.gap - state.gap) for o in states if o is not state)])
            pushed_back = difference(state.gap - nudge) > 0 > difference(state.gap + nudge)
            assert state.stable == pushed_back
    if spots is None:
        assert min(counts[1], counts[2]) > 100
    assert sum(number for roots, number in counts.items() if roots > 1) > 0


def snaps_at(spring, pressure, thickness, around):
    """Voltage between those with and without an open stable state, by halving."""

    def is_open(voltage):
        states = states_of(spring, pressure, thickness, voltage)
        return any(state.stable and not state.touching for state in states)

    low, high = 0.99 * around, 1.01 * around
    assert is_open(low)
    assert not is_open(high)
    while high - low > 1e-15 * high and low < (low + high) / 2 < high:
        low, high = ((low + high) / 2, high) if is_open((low + high) / 2) else (low, (low + high) / 2)
    return high


@pytest.mark.slow
def test_pull_in_is_where_the_formula_says():
    random, tried = np.random.default_rng(4), 0
    for _ in range(200):
        spring, pressure, thickness, _ = random_spring(random)
        expected = snap_of(spring, pressure, thickness)
        left = spring.free_gap - pressure / spring.stiffness
        assert (expected is None) == (left <= thickness / 2)
        # the fold lies at g = (2 g0 - K)/3: so near the stop halving tells closed from open otherwise
        if expected is None or 2 * left - thickness < 0.05 * left:
            continue
        tried += 1
        found = snaps_at(spring, pressure, thickness, expected)
        # two states count as one fold where they differ by less than NOISE of what presses, of which V^2 is a part
        at_fold = EPS0 * expected**2 / 2 / (2 / 3 * (thickness + left)) ** 2
        # (both sides: twice pressure + at_fold), a quarter more for the rounding of the formula itself
        assert abs(found / expected - 1) < 1.25 * NOISE * (pressure + at_fold) / at_fold
    assert tried > 60


def test_without_room_for_it_there_is_no_pull_in():
    """g0 <= K/2: one state at every voltage, and the gap closes without a jump."""
    random = np.random.default_rng(5)
    for _ in range(50):
        spring, _, _, _ = random_spring(random)
        thickness = spring.free_gap * random.choice([2.0, 2.0000001, random.uniform(2, 20)])
        closes = thickness * np.sqrt(2 * spring.stiffness * spring.free_gap / EPS0)
        voltages = closes * np.array([0.01, 0.5, 0.9, 0.99, 0.9999, 0.999999, 1.000001, 1.1, 3])
        for voltage in voltages:
            states = states_of(spring, 0.0, thickness, voltage)
            assert len(states) == 1
            assert states[0].stable
            assert states[0].touching == (voltage > closes)
        course = closes * np.linspace(0.05, 1.5, 40)
        loop = hysteresis(course, surface=spring, pressure=0.0, electrical_thickness=thickness)
        assert not np.any(loop.up.jump | loop.down.jump)
        np.testing.assert_allclose(loop.up.gap, loop.down.gap[::-1], rtol=1e-7, atol=1e-9 * spring.free_gap)


def check_jumps(loop, snap, release):
    (up,), (down,) = np.flatnonzero(loop.up.jump), np.flatnonzero(loop.down.jump)
    assert loop.up.voltage[up - 1] <= snap <= loop.up.voltage[up]
    assert loop.down.voltage[down] <= release <= loop.down.voltage[down - 1]


def test_a_spring_snaps_in_and_lets_go_at_its_two_voltages():
    random = np.random.default_rng(6)
    for _ in range(25):
        spring, pressure, thickness, _ = random_spring(random)
        snap = snap_of(spring, pressure, thickness)
        left = spring.free_gap - pressure / spring.stiffness
        if snap is None or left < 0.7 * thickness:
            continue
        release = thickness * np.sqrt(2 * spring.stiffness * left / EPS0)
        assert release < snap
        course = snap * np.linspace(0.02, 1.2, 119)
        loop = hysteresis(course, surface=spring, pressure=pressure, electrical_thickness=thickness)
        check_jumps(loop, snap, release)
        # between them two stable states at one voltage, neither of them a failure
        middle = (release + snap) / 2
        states = states_of(spring, pressure, thickness, middle)
        assert [state.stable for state in states] == [True, False, True]


def test_a_rough_skin_has_its_loop_between_the_turns_of_its_curve():
    """All states lie on V^2(g) = (repulsion - load)/(attraction of 1 V): a branch ends where it turns."""
    skin = PerssonSurface(modulus=2e5, rms_slope=1.0, rms_gap=2e-5, pressure_factor=0.5, decay_factor=0.5)
    pressure, thickness = 2e3, 1e-6
    gaps = np.linspace(0.0, float(skin.gap(np.asarray(pressure))), 400_001)
    squared = (skin.pressure(gaps) - pressure) * 2 * (thickness + gaps) ** 2 / EPS0
    snap, release = np.sqrt(squared.max()), np.sqrt(squared[0])
    course = snap * np.linspace(0.01, 1.1, 110)
    loop = hysteresis(course, surface=skin, pressure=pressure, electrical_thickness=thickness)
    check_jumps(loop, snap, release)


def test_a_rough_average_is_followed_too():
    skin = PerssonSurface(**PerssonSurface.example)
    course = np.linspace(1.0, 150.0, 12)
    loop = hysteresis(course, surface=skin, pressure=5e3, electrical_thickness=0.378e-6, spots=PullingSpots())
    assert not np.any(loop.up.jump)
    np.testing.assert_allclose(loop.up.gap, loop.down.gap[::-1], rtol=1e-9)
    assert np.all(np.diff(loop.up.gap) < 0)
    # the average pulls many times harder than one gap for all, as the share in contact carries it
    plates = functools.partial(PlateAttraction, electrical_thickness=0.378e-6)
    alone = follow(course, plates, surface=skin, pressure=5e3)
    assert np.all(loop.up.attraction > 10 * alone.attraction)
