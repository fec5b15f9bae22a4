"""Every number the paper states, against ours, with what can and cannot be concluded."""

from __future__ import annotations

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.scenarios import scenarios
from electrovib.physics.drive.edges import Constant as Step
from electrovib.physics.skin import time_constant
from electrovib.solve.expand import modes
from electrovib.solve.transient import transient
from electrovib.study.reproduction import Row


def rows() -> tuple[Row, ...]:
    """Give all rows, in the paper's order."""
    return (
        *_capacitances(),
        *_equations(),
        *_static(),
        *_time_constants(),
        *_suspended(),
        *_trapezium(),
        *_figure_7(),
        *_surroundings(),
    )


def _capacitances() -> tuple[Row, ...]:
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    return (
        Row("C_i", "capacitance of the insulator", 32.0, film / 1e-12, "pF", "reproduced",
            "the paper cuts 32.96 off; rounding gives 33"),
        Row("C_sc", "capacitance of the stratum corneum", 6.9, skin / 1e-9, "nF", "reproduced", ""),
        Row("capacitance_ratio", "C_sc over C_i, which the paper calls large", None, skin / film, "1", "consistent",
            "so tau = C_sc R_sc is within 0.5 % of (C_i + C_sc) R_sc on this film"),
    )  # fmt: skip


def _equations() -> tuple[Row, ...]:
    """Check equations (2) to (5) on the solved stack of film and skin, which knows nothing of them."""
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    resistance = values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    tau = (film + skin) * resistance
    scenario = scenarios()["fig6"].replace({"circuit.return_path.resistance": 0.0})
    section, _ = modes(scenario)
    effective = scenario.force.effective_voltage(section)
    wanted = {"v_e": effective, "v_sc": section["stratum_corneum"].field * values.SKIN_THICKNESS}
    wanted |= {"D_i": section["insulator"].displacement, "D_s": section["stratum_corneum"].displacement}
    time = np.linspace(0.0, 5 * tau, 501)
    found = transient(wanted, Step(level=1.0), time)
    decay = np.exp(-time / tau)
    charge = found["D_s"] * values.AREA
    lost = (found["D_i"] - found["D_s"]) * values.AREA
    residual_2 = np.max(np.abs(found["v_sc"] - film / (film + skin) * decay)) / (film / (film + skin))
    residual_4 = np.max(np.abs(charge * (1 / film + 1 / skin) + lost / film - 1))
    residual_5 = np.max(np.abs(found["v_e"] - decay))
    ratio = tau / (eps0 * values.SKIN_PERMITTIVITY / values.CONDUCTIVITY)
    note = "largest difference from the solved stack of two layers after a 1 V step; 0 is exact"
    return (
        Row("equation_2", "equation (2), voltage of the stratum corneum", None, float(residual_2), "1", "consistent", note),
        Row("equation_3", "exact tau over the thick-film tau of equation (3)", None, float(ratio), "1", "consistent",
            "the thick-film form is short by C_i/C_sc"),
        Row("equation_4", "equation (4), sum of the charges' voltages", None, float(residual_4), "1", "consistent", note),
        Row("equation_5", "equation (5), effective voltage", None, float(residual_5), "1", "consistent", note),
    )  # fmt: skip


def _static() -> tuple[Row, ...]:
    force = values.static_force(voltage=values.VOLTAGE)
    spread = compute.thickness_spread()
    law, gap = (thin / thick for thin, thick in spread.values())
    return (
        Row("static_force_1000V", "static force of equation (1) at 1000 V", None, force / 1e-3, "mN", "consistent",
            "not printed; from the printed inputs. The gap plane gives 607.6 mN: 10.74 times more"),
        Row("thickness_spread_law_1", "static force with a skin of 100 um over that with 400 um, law (1)", None, law, "1",
            "consistent", "about the 2.5 of the paper's 2 to 5 mN; but it is the geometric thickness in law (1) that spreads it"),
        Row("thickness_spread_gap", "the same ratio at the gap plane", None, gap, "1", "open",
            "on a thick film the skin's thickness hardly changes the force in the gap: that the spread between"
            " persons comes from thickness follows from law (1), not from the field"),
    )  # fmt: skip


def _time_constants() -> tuple[Row, ...]:
    others = {key: skin for key, skin in compute.all_skins().items() if key != "vezzoli_2014/point"}
    taus = sorted((float(time_constant(s.material, 100.0)) / 1e-3, s.name) for s in others.values())
    low, high = taus[0], taus[-1]
    note = (
        f"at 100 Hz the cited skins give {low[0]:.2g} ms ({low[1]}) to {high[0]:.2g} ms ({high[1]}); the paper prints"
        " neither the frequency of its eps 1560 nor a resistivity, so 5.57e5 ohm m is only 7.7 ms written otherwise"
    )
    ours = (low[0], high[0])
    return (
        Row("tau_giraud", "time constant for Giraud's conditions, by the paper's model", 7.7, ours, "ms", "open", note),
        Row("tau_giraud_measured", "the same, as measured by Giraud", 6.0, ours, "ms", "open",
            "of the same order; a decay of the finger pulp of 4 ms (Pawluk and Howe 1999) may be part of it"),
    )  # fmt: skip


def _suspended() -> tuple[Row, ...]:
    constant, leaking = compute.suspended_constancy(0.0), compute.suspended_constancy(1 / 8.7e8)
    what = "figure 2, force at the end of a 1 s hold over that at its beginning"
    return (
        Row("suspended_force_constant", f"{what}, gap that does not conduct", None, constant, "1", "consistent",
            "the stack with an ideal gap; law (5) has no gap and would decay. The gap is not printed: 100 um"),
        Row("suspended_force_leaky", f"{what}, gap that leaks with 8.7e8 ohm m", None, leaking, "1", "consistent",
            "with a leak the force would be gone: figure 2 says that air between finger and film does not leak"),
    )  # fmt: skip


def _trapezium() -> tuple[Row, ...]:
    cases = compute.figure_6_cases()
    force = {name: compute.peak_force(case, ramp=values.RAMP) / 1e-3 for name, case in cases.items()}
    ramps = {name: compute.ramp_for(case, values.FORCE_MODEL) / 1e-3 for name, case in cases.items()}
    edges = {name: compute.edge_ratio(case) for name, case in cases.items()}
    point = scenarios()["fig6"]
    exact = compute.ramp_for(point, values.FORCE_MODEL) / 1e-3
    residuals = [
        compute.causality_residual(skin.material)
        for name, skin in compute.force_skins().items()
        if name.startswith(("palmar", "1963", "Gabriel wet"))
    ]
    return (
        Row("trapezium_force", "peak force under a 0 to 1000 V trapezium", 2.5, _range(force), "mN", "open",
            "the paper prints no ramp; taken as 36 ms. Over skins and planes: " + _list(force)),
        Row("trapezium_force_measured", "the same, as measured", values_in_mn(), _range(force), "mN", "open",
            "of this order for some skins at some ramps; neither is printed"),
        Row("trapezium_ramp", "ramp that would give 2.5 mN", None, _range(ramps), "ms", "open",
            f"{exact:.3g} ms with law (1) and 7.7 ms. " + _list(ramps)),
        Row("falling_edge_asymmetry", "force after the falling edge over that after the rising edge", None,
            _range(edges), "1", "open",
            "the paper says only that the discharging parts differ, not how nor by how much: it may mean the ramp or"
            " the hold. One relaxation time gives nearly equal pulses, a dispersive skin a smaller second one: "
            + _list(edges)),
        Row("causality_residual", "law as printed: share of the peak already there 1 ms before a 20 ms ramp", None,
            (min(residuals), max(residuals)), "1", "open",
            "real capacitances that depend on frequency are not causal; the paper does not say how it made its curve"),
    )  # fmt: skip


def values_in_mn() -> tuple[float, float]:
    """Give the measured range in mN."""
    low, high = values.FORCE_MEASURED
    return (low / 1e-3, high / 1e-3)


def _figure_7() -> tuple[Row, ...]:
    measured = {
        name: compute.rise_and_saturation(skin.material) for name, skin in compute.force_skins().items()
    }
    rise = {name: value[0] for name, value in measured.items()}
    saturation = {name: value[1] for name, value in measured.items()}
    shapes = "; ".join(f"{name}: {verdict(*value)}" for name, value in measured.items())
    open_note = (
        "the paper prints no insulator, voltage, area or load. A coat of 1 um with eps 3.9 is taken. Per skin (rise ="
        f" F(10 kHz)/F(100 Hz), saturation = F(10 kHz)/largest F): {shapes}"
    )
    return (
        Row("fig7_rise", "figure 7, F(10 kHz)/F(100 Hz)", None, _range(rise), "1", "open", _list(rise)),
        Row("fig7_saturation", "figure 7, F(10 kHz)/largest F", None, _range(saturation), "1", "open", open_note),
    )  # fmt: skip


def verdict(rise: float, saturation: float, before: float) -> str:
    """Say in words what a skin does in figure 7.

    Parameters
    ----------
    rise, saturation, before : float
        F(10 kHz)/F(100 Hz), F(10 kHz)/largest F, F(5 kHz)/F(10 kHz).

    Returns
    -------
    str
        Begins with ``consistent`` or ``open``.
    """
    numbers = f"rise {rise:.3g}, saturation {saturation:.2f}"
    if rise < 1:
        return f"open, falls ({numbers})"
    if rise < 1.2:
        return f"open, flat ({numbers})"
    if saturation < 0.9:
        return f"open, peaks and falls again ({numbers})"
    if before < 0.95:
        return f"open, still rising at 10 kHz ({numbers})"
    return f"consistent, rises and saturates ({numbers})"


def _surroundings() -> tuple[Row, ...]:
    film, coat = (
        scenarios()["fig6_static"],
        scenarios()["fig7"].replace({"force.model": "EffectiveMediumPlane"}),
    )
    found = []
    for name, scenario in (("film", film), ("coat", coat)):
        factors = tuple(compute.floating_factor(scenario, capacitance) for capacitance in (100e-12, 400e-12))
        found.append(
            Row(
                f"return_path_{name}",
                f"force with a floating body of 100 to 400 pF over that of a grounded one, {name}",
                None,
                (min(factors), max(factors)),
                "1",
                "open",
                "the paper does not say whether the subject was grounded",
            )
        )
    return tuple(found)


def _range(named: dict[str, float]) -> tuple[float, float]:
    return (min(named.values()), max(named.values()))


def _list(named: dict[str, float]) -> str:
    return ", ".join(f"{name} {value:.3g}" for name, value in named.items())
