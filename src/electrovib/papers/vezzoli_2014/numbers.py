"""Every number that the paper states beside ours, with what can be concluded from it."""

from __future__ import annotations

import functools
from collections.abc import Sequence
from typing import Any

import numpy as np

from electrovib.core.constants import VACUUM_PERMITTIVITY as eps0
from electrovib.papers.vezzoli_2014 import compute, values
from electrovib.papers.vezzoli_2014.compute import row
from electrovib.papers.vezzoli_2014.values import scenarios
from electrovib.solve.simulate import simulate
from electrovib.studies.reproduction import Row


@functools.cache
def rows() -> tuple[Row, ...]:
    """Return all rows, in the order of the paper."""
    return (
        *_static(),
        *_suspended(),
        *_capacitances(),
        *_equations(),
        *_decays(),
        _own_reading(),
        *_trapezium(),
        *_figure_7(),
        *_surroundings(),
    )


def _static() -> tuple[Row, ...]:
    force, past = values.static_force(voltage=values.VOLTAGE), values.FORCE_PAST
    vanishing, micron = (compute.static_force("MaxwellStressInGap", gap=gap) for gap in (None, 1e-6))
    law, gap = (
        compute.static_force(name, skin=values.THICKNESSES[0])
        / compute.static_force(name, skin=values.THICKNESSES[1])
        for name in ("EffectiveMedium", "MaxwellStressInGap")
    )
    thin, thick = (1e6 * each for each in values.THICKNESSES)
    smallest, largest = values.FORCE_MEASURED
    return (
        row("past_force_law_1", force, less=past / force),
        row("past_force_gap", (micron, vanishing), micron=micron / past, vanishing=vanishing / past),
        row("static_force_1000V", force),
        row("gap_over_law_1", vanishing / force),
        row("thickness_spread_law_1", law, thin=thin, thick=thick, spread=largest / smallest),
        row("thickness_spread_gap", gap, thin=thin, thick=thick),
    )


def _suspended() -> tuple[Row, ...]:
    off = scenarios()["fig2"]
    return (
        row("static_constant", compute.over_hold(scenarios()["fig6_static"])),
        row("suspended_force_constant", compute.over_hold(off)),
        row("suspended_oscillation", compute.oscillation()),
        row("suspended_force_leaky", compute.over_hold(off.replace(compute.leaky_air(8.7e8)))),
    )


def _capacitances() -> tuple[Row, ...]:
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    tau = (film + skin) * values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    with_body, without = (
        compute.peak_force(scenarios()["fig6"].replace(_body(each)), ramp=values.RAMP) for each in (1e3, 0.0)
    )
    return (
        row("C_i", film),
        row("C_sc", skin),
        row("capacitance_ratio", skin / film),
        row("equation_3", tau / (eps0 * values.SKIN_PERMITTIVITY / values.CONDUCTIVITY)),
        row("deeper_tissue", 1 - with_body / without),
    )


def _body(resistance: float) -> dict[str, float]:
    return {"circuit.return_path.resistance": resistance}


def _equations() -> tuple[Row, ...]:
    """Check the equations against the solved stack of film and skin, which does not use them."""
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    tau = (film + skin) * values.SKIN_THICKNESS / (values.CONDUCTIVITY * values.AREA)
    scenario = scenarios()["fig6"].replace(_body(0.0))
    time = np.linspace(0.0, 5 * tau, 501)
    stepped = simulate(scenario.replace({"drive": {"model": "Step", "level": values.VOLTAGE}}), time=time)
    faded = np.exp(-time / tau)
    of_film, of_skin = (stepped.sel(layer=name) / values.VOLTAGE for name in ("insulator", "stratum_corneum"))
    charge = of_skin.displacement.values * values.AREA
    lost = of_film.displacement.values * values.AREA - charge
    share = film / (film + skin)
    static = values.static_force(voltage=values.VOLTAGE)
    friction = scenario.to_dict()["friction"]["coefficient"]
    lateral = friction * (scenario.load.normal_force + static * faded**2)
    held = compute.static_force("EffectiveMedium")
    found = {
        "1": held / static - 1,
        "2": (of_skin.field.values * values.SKIN_THICKNESS - share * faded) / share,
        "4": charge * (1 / film + 1 / skin) + lost / film - 1,
        "5": stepped.effective_voltage.values / values.VOLTAGE - faded,
        "6": stepped.lateral_force.values / lateral - 1,
    }
    return (
        *(row(f"equation_{number}", float(np.max(np.abs(miss)))) for number, miss in found.items()),
        row("third_configuration", compute.over_hold(scenario)),
    )


def _decays() -> tuple[Row, ...]:
    """Return the time constants of the paper under both readings, and the check that they rest on."""
    usual, slowest = compute.USUAL, compute.SLOWEST
    voltage = compute.time_constants(usual)[0], compute.time_constants(slowest)[1]
    force = [values.force_decay(tau=each) for each in voltage]
    band: dict[str, Any] = {"usual": usual, "slowest": slowest}
    ends = ", ".join(
        f"{compute.time_constants(f)[1] / 1e-3:.3g} ms at {f:g} Hz" for f in (usual, 10.0, slowest)
    )
    constructed = (skin for skin in values.skins().values() if not skin.reproduces_force)
    _, through = compute.time_constants(usual, constructed)
    decays = [each.decay for each in (compute.BY_VOLTAGE, compute.BY_FORCE)]
    short, long = (each / compute.MEASURED.decay for each in decays)
    film = 1 + values.insulator_capacitance() / values.skin_capacitance()
    edges = [
        [compute.time_constants(each, [skin])[0] for each in (100.0, 1e4)]
        for skin in compute.published_skins().values()
    ]
    simulated = compute.lateral_decay(compute.point(values.TAU_MODEL))
    return (
        row("tau_giraud", voltage, ends=ends, through=through / 1e-3, **band),
        row("tau_giraud_force", force, tau=compute.BY_FORCE.tau / 1e-3, **band),
        row("tau_giraud_measured", force, tau=compute.MEASURED.tau / 1e-3, **band),
        row("tau_giraud_decay", decays, short=short, long=long),
        row("fig4_dispersion", [low / high for low, high in edges]),
        row("force_decay_over_tau", simulated / (values.TAU_MODEL * film)),
    )


def _own_reading() -> Row:
    """Return the force of figure 6 by the paper's own equations (1) and (5), without a solver."""
    ramp, tau = values.RAMP, values.TAU_MODEL
    own, by_force = (_by_equations(each, ramp) for each in (tau, compute.BY_FORCE.tau))
    return row("own_reading", own, tau=tau / 1e-3, ramp=ramp / 1e-3, by_force=by_force / 1e-3)


def _by_equations(tau: float, ramp: float) -> float:
    """Return the attraction [N] at the end of a ramp [s], for a time constant of the effective voltage [s]."""
    effective = tau / ramp * -float(np.expm1(-ramp / tau))  # over the voltage
    return values.static_force(voltage=values.VOLTAGE) * effective**2


def _trapezium() -> tuple[Row, ...]:
    own = {compute.POINT_BY_FORCE, values.skins()["point"].name}
    gaps = [case for case in compute.figure_6() if case.name in compute.LEAKY_GAPS]
    published = [case for case in compute.figure_6() if case.name not in own and case not in gaps]
    slippery, rough = values.FRICTION
    printed = values.FORCE_MODEL / 1e-3
    ramps = [reading.ramp(values.FORCE_MODEL) / 1e-3 for reading in (compute.BY_VOLTAGE, compute.BY_FORCE)]
    residuals = [
        compute.causality_residual(skin.material)
        for name, skin in compute.force_skins().items()
        if name.startswith(("palmar", "1963", "Gabriel wet"))
    ]
    film, skin = values.insulator_capacitance(), values.skin_capacitance()
    charge = film * skin / (film + skin) * values.VOLTAGE
    return (
        *_under(published, "law_1"),
        *_under(gaps, "gap"),
        row(
            "attraction_measured",
            values.attraction_of(values.FORCE_MEASURED),
            slippery=slippery,
            rough=rough,
            least=slippery * printed,
            most=rough * printed,
            by_voltage=ramps[0],
            by_force=ramps[1],
        ),
        row("causality_residual", residuals),
        row("shortest_ramp", charge / scenarios()["fig6"].to_dict()["limits"]["current"]),
    )


def _under(cases: Sequence[compute.TrapeziumForce], law: str) -> tuple[Row, ...]:
    """Return what follows for figure 6 under one law, over the skins or gaps that are known for it."""
    return (
        row(f"trapezium_force_{law}", [case.force for case in cases]),
        row(f"trapezium_ramp_{law}", [case.ramp for case in cases]),
        row(f"falling_edge_asymmetry_{law}", [case.edges for case in cases]),
    )


def _figure_7() -> tuple[Row, ...]:
    shapes = {
        name: shape for name, shape in compute.figure_7().items() if name != values.skins()["point"].name
    }
    agree = [name for name, shape in shapes.items() if shape.words.startswith("consistent")]
    counts: dict[str, Any] = {"agree": len(agree), "all": len(shapes)}
    materials = [compute.force_skins()[name].material for name in agree]
    thin, thick = (
        [compute.frequency_force(each, samples=21, thickness=thickness)[1] for each in materials]
        for thickness in values.THICKNESSES
    )
    spread = (np.array(thin) / np.array(thick)).ravel().tolist()
    coating = values.capacitance(
        permittivity=values.COATING_PERMITTIVITY, thickness=values.COATING_THICKNESS, area=values.AREA
    )
    ends: dict[str, Any] = {
        name: 1e6 * each for name, each in zip(("thin", "thick"), values.THICKNESSES, strict=True)
    }
    return (
        row("fig7_rise", [each.rise for each in shapes.values()], **counts),
        row("fig7_saturation", [each.saturation for each in shapes.values()], **counts),
        row("fig7_thickness", spread, **ends),
        row("fig7_capacitances", coating / values.skin_capacitance()),
    )


def _surroundings() -> tuple[Row, ...]:
    film = scenarios()["fig6_static"]
    coating = scenarios()["fig7"].replace({"force.model": "EffectiveMedium"})
    return tuple(
        row(
            f"return_path_{name}",
            [compute.floating_factor(scenario, capacitance=each) for each in (100e-12, 400e-12)],
        )
        for name, scenario in (("film", film), ("coating", coating))
    )
