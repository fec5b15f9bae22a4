"""The whole netlist: header, drive, circuit, layers, force, analyses."""

from __future__ import annotations

import re
from importlib.metadata import version
from typing import TYPE_CHECKING

from electrovib.core.errors import InputError, NotCausalError
from electrovib.data.marks import Form, unsigned
from electrovib.export.spice.analyses import analyses, results, saved
from electrovib.export.spice.circuit import BuiltCircuit
from electrovib.export.spice.force import force_sources
from electrovib.export.spice.precision import check_digits, smallest_charge
from electrovib.export.spice.section import ReadSection
from electrovib.export.spice.text import remark
from electrovib.export.spice.timing import Timing
from electrovib.solve.stack.expand import Surroundings

if TYPE_CHECKING:
    from electrovib.scenario import Scenario

OF_A_LAYER = {"thickness", "role", "material", "leak", "initial_charge", "breakdown_field"}
"""Parameters of a layer that a netlist represents; a layer with any other is refused."""


def netlist(scenario: Scenario, *, name: str) -> str:
    """Return a scenario as a netlist that ngspice runs without further input, if every part has an exact form there."""
    _check(scenario)
    timing = Timing.of(scenario.drive, scenario.time)
    circuit = BuiltCircuit.of(scenario)
    roles = scenario.stack.roles
    section = ReadSection(slabs=circuit.slabs, roles=roles, start=circuit.start, area=scenario.contact_area)
    second = Surroundings.of(scenario).second
    check_digits(scenario, circuit, timing)
    force, nodes = force_sources(scenario.force, section, second=second)
    plain = re.sub(r"[^A-Za-z0-9_-]", "_", name) or "circuit"
    kept = [*circuit.nodes, *nodes.values(), "force"]
    blocks = [
        _header(scenario, timing, plain),
        [remark(f"drive: {type(scenario.drive).__name__}"), *circuit.sources(timing)],
        *circuit.blocks,
        force,
        [
            *analyses(timing, scenario.frequency, smallest_charge=smallest_charge(scenario, circuit, timing)),
            *saved(kept),
        ],
        [*results(section, nodes, plain, step=timing.step), ".end"],
    ]
    return "*\n".join("".join(f"{line}\n" for line in block) for block in blocks)


def _check(scenario: Scenario) -> None:
    law = scenario.force
    if not law.causal:
        raise NotCausalError(
            f"force = {type(law).__name__}: it gives the magnitude of a response at one frequency and is not causal, so no"
            f" circuit represents it. Use {law.instead or 'a causal law'}"
        )
    problems = [
        f"stack.{name}.{extra}: a netlist does not represent it; omit it, or use 'electrovib run'"
        for name, layer in scenario.stack.layers.items()
        for extra in sorted(set(type(layer).model_fields) - OF_A_LAYER)
        if getattr(layer, extra) != type(layer).model_fields[extra].default
    ]
    problems += [
        f"{path}: a netlist does not represent it; omit it, or use 'electrovib run'"
        for path in _moving(scenario)
    ]
    if scenario.contact.grows:
        problems.append(
            f"contact = {type(scenario.contact).__name__}: its area follows load and attraction, but that of a netlist is fixed;"
            " use contact.model = FixedArea with the gross_contact_area that 'electrovib run' gives"
        )
    if problems:
        raise InputError(problems)


def _moving(scenario: Scenario) -> list[str]:
    """Return the paths of parts of a scenario that change the circuit and that a netlist does not represent."""
    found = {
        "circuit.amplifier": scenario.circuit.amplifier is not None,
        "motion.distance": scenario.motion.moved_gap is not None,
        "motion.renews_film": scenario.motion.renews_film,
        "contact.closing": scenario.contact.closing is not None,
    }
    return [path for path, there in found.items() if there]


def _header(scenario: Scenario, timing: Timing, name: str) -> list[str]:
    title = " ".join(scenario.title.split()) or "a finger on a plate"
    texts = [
        title,
        f"electrovib {version('electrovib')}, scenario {scenario.digest()}",
        f"ngspice -b of this file writes {name}.time.txt and {name}.frequency.txt into the working folder.",
        f"Over time: steps of at most {timing.step:.6g} s; a step of the drive takes {timing.edge:.6g} s.",
        "Over frequency: small signals; permittivities are those of the sums below, not the declared ones.",
        unsigned(Form.NETLIST),
    ]
    return [remark(text) for text in texts]
