"""The equations of a finger on a plate written once more, with everything at once, for a common integrator.

dD_k/dt = J - sigma_k E_k - J_leak(E_k), D_k = eps_k E_k + sum P_m, dP_m/dt = (eps0 s_m E_k - P_m)/tau_m for every
layer; a body that floats, the plate behind its amplifier, and a gap that yields beside them. Nothing of the
package's solvers is used but the Debye terms of a material.
"""

import cmath
import itertools
import math
import warnings

import numpy as np
from scipy.integrate import ODEintWarning, odeint, solve_ivp

from electrovib.physics.drive.parts import Linear, Tones
from electrovib.physics.motion import TremblingDistance

EPS0 = 8.8541878128e-12
TOLERANCE = 1e-10
AT_ONCE = 1e9
"""Rate at which the plate follows an amplifier without a pole but with a largest current [1/s]."""


def breaks_of(drive, distance, end):
    """Times at which drive or distance are not smooth [s], from 0 to the end."""
    found = [0.0, end, *(distance.breaks() if distance is not None else ())]
    for part in drive.parts():
        found += part.until(end).times.tolist() if isinstance(part, Linear) else [part.start, part.stop]
    kept = [0.0]
    for time in sorted(t for t in found if 0 < t < end * (1 - 1e-12)):
        if time - kept[-1] > 1e-12 * end:
            kept.append(time)
    return [*kept, end]


def smooth_piece(drive, start, stop):
    """Give value and slope of the drive between two of its breaks, as one function that knows nothing of jumps."""
    middle, level, rise, waves, formulas = (start + stop) / 2, 0.0, 0.0, [], []
    for part in drive.parts():
        if isinstance(part, Linear):
            at = np.array([middle - (stop - start) / 4, middle + (stop - start) / 4])
            low, high = part.value(at).tolist()
            rise += 2 * (high - low) / (stop - start)
            level += (low + high) / 2
        elif part.start <= middle < part.stop:
            if isinstance(part, Tones):
                waves += zip(part.frequencies.tolist(), part.amplitudes.tolist(), strict=True)
            else:
                formulas.append(part)

    def value(time):
        now, slope = level + rise * (time - middle), rise
        for frequency, amplitude in waves:
            angle = 2 * np.pi * frequency
            turned = amplitude * np.exp(1j * angle * time)
            now, slope = now + turned.real, slope - angle * turned.imag
        for part in formulas:
            now, slope = now + float(part.formula(time)), slope + float(part.derivative(time))
        return now, slope

    return value


def _distance(distance, time):
    """Gap and its rate of a finger that trembles, or touches and lifts: half a cosine in the logarithm."""
    if isinstance(distance, TremblingDistance):
        angle = 2 * np.pi * distance.frequency
        turned = cmath.exp(1j * angle * time)
        return distance.mean + distance.amplitude * turned.imag, angle * distance.amplitude * turned.real
    begin, top, lift, off = distance.breaks()
    depth = math.log(distance.near / distance.far)
    for first, last, sign in ((begin, top, 1), (lift, off, -1)):
        if first < time < last:
            turn = math.pi * (time - first) / (last - first)
            near = (1 - sign * math.cos(turn)) / 2
            rate = sign * math.pi / (last - first) * math.sin(turn) / 2
            gap = distance.far * math.exp(depth * near)
            return gap, gap * depth * rate
    return (distance.near if top <= time <= lift else distance.far), 0.0


class Plain:
    """One scenario as ordinary differential equations."""

    def __init__(self, scenario, debye):
        self.layers = list(scenario.stack.layers.items())
        self.count = len(self.layers)
        self.drive, self.area = scenario.drive, scenario.contact_area
        path = scenario.circuit.return_path
        self.repeats = 1 + path.second_contact(self.area)
        element = scenario.circuit.element()
        self.resistance, self.elastance, self.body_rate = element.resistance, element.elastance, element.rate
        self.thickness = [layer.thickness for _, layer in self.layers]
        self.eps = [EPS0 * debye[name].high for name, _ in self.layers]
        self.sigma = [layer.material.conductivity for _, layer in self.layers]
        self.leaks = [layer.leak for _, layer in self.layers]
        self.terms = [
            (k, EPS0 * strength, 1 / time)
            for k, (name, _) in enumerate(self.layers)
            for strength, time in zip(debye[name].strengths, debye[name].relaxation_times, strict=True)
            if strength > 0
        ]
        charges = [layer.initial_charge for _, layer in self.layers]
        self.held = [sum(charges[:k]) for k in range(self.count)]
        self.body = sum(charges) * self.area * self.elastance
        self.gap = [name for name, _ in self.layers].index("gap") if "gap" in scenario.stack.layers else None
        self.distance = scenario.motion.distance
        self.surface = scenario.contact.surface if scenario.contact.closing is not None else None
        self.damping = scenario.contact.closing.damping if self.surface is not None else 1.0
        self.load = scenario.load.normal_force / self.area
        self.share = 1.0 if self.gap is None else self.layers[self.gap][1].material.pulling_share
        self.amplifier = amplifier = scenario.circuit.amplifier
        self.current = self.drive.quantity == "current"
        self.gain = 1.0 if amplifier is None else amplifier.gain
        self.stray = 0.0 if amplifier is None else amplifier.stray_capacitance
        self.lowest, self.highest = (-np.inf, np.inf) if amplifier is None else amplifier.current_limits
        self.largest = np.inf if amplifier is None or amplifier.saturation is None else amplifier.saturation
        band = None if amplifier is None else amplifier.bandwidth
        limited = np.isfinite(self.highest)
        # a plate that may jump: nothing of its own holds it back
        self.jumps = limited and band is None and self.resistance > 0 and self.stray == 0
        self.follows = band is None and not limited
        self.lags = not self.follows and not self.jumps
        self.corner = None if band is None else 2 * np.pi * band
        self.size = self.count + len(self.terms) + 3  # body, gap, plate

    def aim(self, value):
        voltage, slope = value
        aimed = self.gain * voltage
        return (
            (aimed, self.gain * slope) if abs(aimed) <= self.largest else (np.sign(aimed) * self.largest, 0.0)
        )

    def gap_now(self, time, state):
        """Gap and its rate where it is given."""
        if self.distance is not None:
            return _distance(self.distance, time)
        return state[self.size - 2], 0.0

    def at(self, time, state, value):
        """Fields, flows, current density, rates of everything, and the plate."""
        count, eps = self.count, self.eps
        polarised = state[count : count + len(self.terms)]
        free = list(state[:count])
        for (k, _, _), p in zip(self.terms, polarised, strict=True):
            free[k] -= p
        field = [d / e for d, e in zip(free, eps, strict=True)]
        thickness, closing = list(self.thickness), 0.0
        if self.gap is not None:
            thickness[self.gap], closing = self.gap_now(time, state)
        yielded = 0.0
        if self.surface is not None:
            pull = EPS0 * self.share * field[self.gap] ** 2 / 2
            repelled = float(self.surface.pressure(np.array(state[self.size - 2])))
            yielded = closing = (repelled - self.load - pull) / self.damping
        flow = [s * e for s, e in zip(self.sigma, field, strict=True)]
        for k, leak in enumerate(self.leaks):
            if leak is not None:
                flow[k] += float(leak.current_density(field[k]))
        creep = [
            rate * (strength * field[k] - p)
            for (k, strength, rate), p in zip(self.terms, polarised, strict=True)
        ]
        lost = list(flow)
        for (k, _, _), c in zip(self.terms, creep, strict=True):
            lost[k] += c
        body = state[self.size - 3]
        stack = self.repeats * sum(t * e for t, e in zip(thickness, field, strict=True)) + body
        inverse = self.repeats * sum(t / e for t, e in zip(thickness, eps, strict=True))
        inverse += self.area * self.elastance
        loss = self.repeats * sum(t * f / e for t, f, e in zip(thickness, lost, eps, strict=True))
        if self.gap is not None:
            loss -= self.repeats * closing * field[self.gap]
        loss += body * self.body_rate
        plate, slope, density = self._supply(state, value, stack, inverse, loss)
        rates = np.empty(self.size)
        rates[:count] = [density - f for f in flow]
        rates[count : count + len(creep)] = creep
        rates[-3] = density * self.area * self.elastance - body * self.body_rate
        rates[-2] = yielded
        rates[-1] = slope if self.lags else 0.0
        return rates, field, thickness, density, plate, slope, stack

    def _supply(self, state, value, stack, inverse, loss):
        """Voltage of the plate, its rate of change and the current density."""
        area, resistance = self.area, self.resistance
        if self.current:
            density = value[0] / area
            return stack + resistance * value[0], np.nan, density
        aimed, rising = self.aim(value)
        if self.follows:
            density = (aimed - stack) / (resistance * area) if resistance > 0 else (rising + loss) / inverse
            return aimed, rising, density
        if self.jumps:
            current = min(max((aimed - stack) / resistance, self.lowest), self.highest)
            density = current / area
            slope = rising if self.lowest < current < self.highest else density * inverse - loss
            return stack + resistance * current, slope, density
        plate = state[self.size - 1]
        wanted = self.corner * (aimed - plate) if self.corner else rising + AT_ONCE * (aimed - plate)
        if resistance == 0:
            free = (self.stray + area / inverse) * wanted + area * loss / inverse
            held = min(max(free, self.lowest), self.highest)
            slope = (held - area * loss / inverse) / (self.stray + area / inverse)
            return plate, slope, (slope + loss) / inverse
        flows = (plate - stack) / resistance
        if self.stray > 0:
            slope = (min(max(self.stray * wanted + flows, self.lowest), self.highest) - flows) / self.stray
            return plate, slope, flows / area
        slope = wanted
        for limit, side in ((self.lowest, -1), (self.highest, 1)):
            # the plate cannot leave the stack behind faster than the current allows
            if side * (flows - limit) >= 0:
                along = limit / area * inverse - loss - AT_ONCE * resistance * (flows - limit) * 1e-2
                slope = side * min(side * wanted, side * along)
        return plate, slope, min(max(flows, self.lowest), self.highest) / area

    def begin(self, start, value):
        """State just after a beginning: charge and its image in their places, no voltage, nothing polarised."""
        state = np.zeros(self.size)
        state[: self.count] = self.held
        state[-3] = self.body
        if self.surface is not None:
            state[-2] = float(self.surface.gap(np.array(self.load)))
        elif self.gap is not None:
            state[-2] = self.thickness[self.gap]
        if not self.current:
            self.shift(start, state, self.aim(value)[0] if self.follows and self.resistance == 0 else 0.0)
        return state

    def shift(self, time, state, wanted):
        """Charge the plate at once until the stack holds a voltage."""
        _, field, thickness, *_ = self.at(time, state, (0.0, 0.0))
        stack = self.repeats * sum(t * e for t, e in zip(thickness, field, strict=True)) + state[-3]
        inverse = self.repeats * sum(t / e for t, e in zip(thickness, self.eps, strict=True))
        inverse += self.area * self.elastance
        charge = (wanted - stack) / inverse
        state[: self.count] += charge
        state[-3] += charge * self.area * self.elastance

    def solve(self, times, *, start=0.0, added=None, tolerance=TOLERANCE):
        """Signals at increasing times [s] of what begins at rest at `start`, a state added at each if that is given."""
        states, values = self.follow(times, start=start, tolerance=tolerance)
        if added is not None:
            states = [state + added(time) for time, state in zip(times, states, strict=True)]
        rows = [self.named(*each) for each in zip(times, states, values, strict=True)]
        return {name: np.array([row[name] for row in rows]) for name in rows[0]}

    def follow(self, times, *, start=0.0, tolerance=TOLERANCE):
        """States at increasing times [s], and the drive as it is from there on."""
        end = max(float(times[-1]), start + 1e-9)
        marks = [start, *(t for t in breaks_of(self.drive, self.distance, end) if t > start)]
        found, values, state = [], [], None
        for first, last in itertools.pairwise(marks):
            value = smooth_piece(self.drive, first, last)
            if state is None:
                state = self.begin(first, value(first))
            elif self.resistance == 0 and self.follows and not self.current:
                self.shift(first, state, self.aim(value(first))[0])
            inside = times[(times >= first - 1e-12 * end) & (times < last - 1e-12 * end)]
            grid = np.unique([first, *inside, last])
            states = self._integrate(state, grid, value, tolerance)
            found += [states[np.searchsorted(grid, t)] for t in inside]
            values += [value] * len(inside)
            state = states[-1].copy()
        if len(found) < len(times):  # the end itself, after a jump that may be there
            value = smooth_piece(self.drive, end, end * (1 + 1e-6))
            if self.resistance == 0 and self.follows and not self.current:
                self.shift(end, state, self.aim(value(end))[0])
            found.append(state)
            values.append(value)
        return found, values

    def sizes(self):
        """Size of each state."""
        volts = 100.0
        found = np.full(self.size, volts / sum(t / e for t, e in zip(self.thickness, self.eps, strict=True)))
        found[-3:] = volts, 1e-6, volts
        return found

    def conserved(self, still):
        """What neither time nor the drive changes, as rows over the states: of linear layers of fixed thickness."""
        unit = np.eye(self.size)
        blocking = [unit[k] for k in range(self.count) if self.sigma[k] == 0]
        if self.elastance > 0 and self.body_rate == 0:
            blocking.append(unit[-3] / (self.area * self.elastance))
        rows = blocking if self.current else [each - blocking[0] for each in blocking[1:]]
        rows += [unit[-2]] + ([] if self.lags else [unit[-1]]) + ([] if self.elastance > 0 else [unit[-3]])
        if self.resistance == 0 and not self.current:  # the stack holds what the plate has
            begun = self.stack(still)
            rows.append(np.array([self.stack(still + each) - begun for each in unit]) - self.lags * unit[-1])
        return np.array(rows)

    def stack(self, state):
        """Voltage across both contacts and the body."""
        return self.at(0.0, state, (0.0, 0.0))[-1]

    def _integrate(self, state, grid, value, tolerance):
        def rate(time, now):
            return self.at(time, now, value(time))[0]

        errors = {"rtol": tolerance, "atol": tolerance * self.sizes()}
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            try:
                return odeint(rate, state, grid, tfirst=True, mxstep=5_000, tcrit=[grid[-1]], **errors)
            except ODEintWarning:  # a kink that it does not get over
                found = solve_ivp(rate, grid[[0, -1]], state, method="Radau", t_eval=grid, **errors)
        assert found.success, found.message
        return found.y.T

    def named(self, time, state, value):
        """Signals by their names in a record of the package."""
        if self.lags and self.corner is None:  # what is left of following at once is no rate of change
            aimed = self.aim(value(time))[0]
            if abs(aimed - state[-1]) < 1e-4:
                state = np.append(state[:-1], aimed)
        _, field, thickness, density, plate, slope, stack = self.at(time, state, value(time))
        body = state[-3]
        found = {
            "stack_voltage": (stack - body) / self.repeats,
            "current": self.area * density,
            "drive_voltage": plate if self.current else value(time)[0],
        }
        if self.amplifier is not None:
            found |= {"plate_voltage": plate, "amplifier_current": self.area * density + self.stray * slope}
        if self.surface is not None or self.distance is not None:
            found["gap"] = thickness[self.gap]
        for k, (name, _) in enumerate(self.layers):
            found[f"field {name}"] = field[k]
            found[f"displacement {name}"] = state[k]
        return found
