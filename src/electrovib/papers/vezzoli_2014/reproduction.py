"""Everything that the paper states, in one object."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import chain
from typing import TYPE_CHECKING, Final

from electrovib.core.budget import computed
from electrovib.papers.vezzoli_2014.values import CITATION

if TYPE_CHECKING:
    from electrovib.physics.material.tabulated import Tabulated
    from electrovib.studies.reproduction import Reproduction

EQUATIONS: Final[Mapping[str, str]] = {
    "1": r"$f_e = \frac{\varepsilon_0 A v^2}{2 (T_i/\varepsilon_i + T_s/\varepsilon_s)(T_s + T_i)}$",
    "2": r"$v_{sc} = \frac{C_i}{C_i + C_s} \frac{\tau s}{1 + \tau s} v, \quad \tau = (C_i + C_s) R_s$",
    "3": r"$C = \varepsilon_0 \varepsilon A/T, \quad R = \rho T/A, \quad \tau \approx \varepsilon_0 \varepsilon_s \rho_s$",
    "4": r"$v = \frac{Q_s}{C_e} + \frac{Q_i}{C_i}, \quad C_e = \frac{C_i C_s}{C_i + C_s}$",
    "5": r"$v_e = \frac{Q_s}{C_e} = \frac{\tau s}{1 + \tau s} v$",
    "6": r"$f_e = \frac{\varepsilon_0 A v_e^2}{2 (T_i/\varepsilon_i + T_s/\varepsilon_s)(T_s + T_i)},"
    r" \quad f_t = \mu (f_n + f_e)$",
}


def reproduce(*, skin: str | None = None) -> Reproduction:
    """Compute everything that Vezzoli et al. 2014 states.

    `skin` is a table of one's own skin, columns frequency, permittivity and resistivity, which is drawn
    beside the others; one that is not a passive dielectric is refused.
    """
    from electrovib.papers.vezzoli_2014 import (
        compute,
        falling_edge,
        figures,
        measured,
        numbers,
        population,
        report,
    )
    from electrovib.studies.reproduction import Reproduction

    own = None if skin is None else _own_skin(skin)
    found = computed(
        [
            ("printed numbers", numbers.rows),
            ("measured numbers", measured.rows),
            ("numbers of the falling edge", falling_edge.rows),
            ("numbers of the population", population.rows),
            ("figures of the paper", lambda: figures.panels(own)),
            ("figures of what was measured", measured.panels),
            ("figures of the falling edge", falling_edge.panels),
            ("figures of the population", population.panels),
            ("tables by skin", lambda: [compute.decay_table(), *compute.skin_tables(own)]),
            ("further tables", lambda: [each.table() for each in (measured, falling_edge, population)]),
        ]
    )
    rows, printed, further, tables = (
        tuple(chain(*part)) for part in (found[:4], found[4:5], found[5:8], found[8:])
    )
    named = {row.id: row for row in rows}
    return Reproduction(
        paper="vezzoli_2014",
        citation=CITATION,
        rows=rows,
        panels=(*printed, *(replace(each, folded=True) for each in further)),
        pages=(report.page(named),),
        tables=tables,
        equations=EQUATIONS,
        references=tuple(sorted({each.source for each in compute.all_skins().values()} - {CITATION})),
        title="Vezzoli et al. 2014, recomputed",
        findings=(report.finding(named),),
        parts=report.parts(named),
    )


def _own_skin(file: str) -> Tabulated:
    from electrovib.core.errors import InputError
    from electrovib.physics.material.tabulated import Tabulated
    from electrovib.scenario import read_part, skins

    if file in skins():
        raise InputError(
            f"skin = {file}: is a published skin, and beside the others already; give a table of your own, .csv"
        )
    content = {"file": file, "loss": {"model": "Resistivity"}, "conductivity": 0.0}
    try:
        return read_part(Tabulated, content)
    except InputError as error:
        faults = [problem.reason.removeprefix(f"{file}: ") for problem in error.problems]
        raise InputError(f"skin = {file}: {fault}" for fault in faults) from None
