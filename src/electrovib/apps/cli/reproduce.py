"""``electrovib reproduce``."""

from __future__ import annotations

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import say, warned


@takes("""
paper  author_year [default: vezzoli_2014]
-o, --output DIR  Folder to write to. [default: reproduction]
--skin FILE.csv   Table of your own skin: frequency, permittivity, resistivity (.csv).
--force
""")
def command(given: Arguments) -> None:
    """Compute everything that a paper states.

    Write report.html, numbers.json and figures with their curves; this takes about a minute.
    """
    from electrovib.apps.progress import items_shown
    from electrovib.studies.reproduction import COMPARED
    from electrovib.view.reproduce import reproduce

    with items_shown(f"reproducing {given['paper']}"):
        found = reproduce(**given)
    say(f"{given['paper']}: {found.count()}")
    for number, finding in enumerate(found.findings, 1):
        say(f"{number}. {finding}")
    for row in found.ordered:
        unit = "" if row.unit == "1" else f" {row.unit}"
        printed = row.stated if row.stated and row.paper is None else shown(row.paper)
        held = f" (paper: {printed})" if row.verdict in COMPARED else ""
        say(f"{row.verdict:<11} {row.what}: {shown(row.ours)}{unit}{held}")
    say(*warned(found))
    say(f"written: {given['output']}/report.html")


def shown(value: float | tuple[float, float] | None) -> str:
    """Format a number or an interval."""
    if value is None:
        return "not given"
    return f"{value:.4g}" if isinstance(value, (int, float)) else f"{value[0]:.3g} to {value[1]:.3g}"
