"""The numbers in the explanations of the documentation are those that the toolkit computes."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import electrovib as ev

FOLDER = Path(__file__).parent.parent / "docs" / "explanation"


def page(name):
    (found,) = FOLDER.glob(f"*_{name}.md")
    return found.read_text(encoding="utf-8")


def test_the_table_of_the_force_laws_is_that_of_compare():
    rows = re.findall(
        r"^\| \[\]\(.*?/(\w+)\.rst\)(.*?) \|.*?\$ \| (.*?) \| (.*?) \|$",
        page("why_forces_differ"),
        re.MULTILINE,
    )
    assert len(rows) == 5
    computed = [
        [cell.replace(" (beyond breakdown)", "") for cell in row] for row in ev.compare_surfaces().rows
    ]
    law, found = "", {}
    for row in computed:
        law = row[0] or law
        found[law, row[2]] = tuple(row[3:5])
    for name, gap, film, coating in rows:
        assert found[name, "5 um" if "5 um" in gap else "0"] == (film, coating)


def test_the_forces_of_floating_bodies_are_those_of_the_solver():
    text = page("how_it_works")
    shown = [float(number) for number in re.findall(r"([\d.]+) mN", text)]
    returns = [{}] + [
        {"circuit.return_path": {"model": "Floating", "capacitance": c}} for c in ("400 pF", "100 pF")
    ]
    base = ev.load("vezzoli_2014/fig6")
    forces = [1e3 * float(ev.simulate(base.replace(change)).electrostatic_force.max()) for change in returns]
    assert shown == pytest.approx(forces, rel=3e-3)


def test_what_a_held_voltage_does_depends_on_what_conducts():
    """The table of the page: nothing in the gap conducts, or the gap conducts, or the insulator more than the gap."""
    base = ev.load("vezzoli_2014/fig6_gap").replace({"drive": {"model": "Step", "level": "100 V"}})
    air = {"model": "Constant", "permittivity": 1.0}
    film = {"model": "Constant", "permittivity": 3.35, "conductivity": "10 nS/m"}
    times = [1e-6, 0.3]
    cases = {
        "kept": {"stack.gap.material": air},
        "lost": {},
        "raised": {"stack.gap.material": air, "stack.insulator.material": film},
    }
    late_over_early = {}
    for name, change in cases.items():
        force = ev.simulate(base.replace(change), time=times).electrostatic_force
        late_over_early[name] = float(force[1] / force[0])
    assert 1 <= late_over_early["kept"] < 1.02
    assert late_over_early["lost"] < 1e-6
    assert late_over_early["raised"] > 100
