"""``electrovib compare``, ``evidence`` and ``reproduce``: laws beside each other, beside measurements and beside papers."""

from __future__ import annotations

from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import answered, say, show, show_answer
from electrovib.core.errors import InputError


@takes("""
[scenario]         A scenario; without one, the static forces of the published laws on two stacks.
[others]...
--set
--models A,B,...|FILE.py -> laws  Force laws, all if absent; or a Python file with laws of your own; repeatable.
--all
--over
--materials
--layer
-o, --output FILE|DIR  A page (.html), a figure (.pdf, .svg, .png), tables (.csv, .tex), or a folder with all.
--style
--force
""")
def compare(given: Arguments) -> None:
    """Compare force laws, or materials, on one stack.

    State which law to believe and why they differ; with --materials, compare materials of the insulator.
    """
    if "others" in given:
        listed = " ".join((given["scenario"], *given["others"]))
        raise InputError(
            f"{listed}: compare takes one scenario and compares laws or materials on it; 'electrovib report {listed} -o"
            " overlay.html' overlays several Traces"
        )
    if not given.get("scenario"):
        _print_static(given)
    elif "materials" in given:
        given.only("scenario set all materials layer output", "--materials, which compares no laws", "force")
        _print_materials(given)
    else:
        given.only("scenario set all laws over output", "the comparison of force laws", "force")
        _print_laws(given)


def _print_static(given: Arguments) -> None:
    from electrovib.core.answer import laid_out
    from electrovib.studies.surfaces import ANSWER, compare_surfaces

    if flags := given.surplus("scenario all force"):
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{flag}: needs a scenario, for instance {example} {flag} ..." for flag in flags)
    say(ANSWER)
    show(laid_out(compare_surfaces()))


def _print_laws(given: Arguments) -> None:
    """Compare the laws that are named, or all; a Python file among the names is imported."""
    from electrovib.studies.compare import Comparison, compare

    given["models"] = given.read_laws()
    given.read_set()
    brief = not given.keys() & {"all", "output"}
    answered(Comparison, compare, "comparing force laws", given)
    if brief:
        say("--all explains why the laws differ, and lists where their papers contradict each other.")


def _print_materials(given: Arguments) -> None:
    from electrovib.studies.compare import MaterialComparison, compare_materials

    given.put_changes()
    given["materials"] = None if given["materials"] == ["all"] else given["materials"]
    answered(MaterialComparison, compare_materials, "comparing materials", given)


@takes(
    """
[measured]...       Part of the name, title or group of measurements, all if absent; or a file of a measurement of your own
    (.toml), which is judged alone unless others are named beside it.
--all
-n N               Draws of what a publication does not print. [default: 64]
--seed N           Of the draws. [default: 0]
-o, --output FILE|DIR  A page (.html), a figure (.pdf, .svg, .png), tables (.csv, .tex), or a folder with all.
--style
--force
""",
    example="electrovib evidence vezzoli -o evidence",
)
def evidence(given: Arguments) -> None:
    """Judge every law by what was measured.

    Each law is compared with every published measurement that it can predict.
    """
    from electrovib.apps.progress import items_shown
    from electrovib.studies.evidence.function import evidence
    from electrovib.studies.evidence.result import Evidence

    with items_shown("comparing with measurements"):
        answered(Evidence, evidence, "comparing with measurements", given)


@takes("""
paper  author_year [default: vezzoli_2014]
-o, --output DIR  Folder to write to. [default: reproduction]
--skin FILE.csv   Table of your own skin: frequency, permittivity, resistivity (.csv).
--force
""")
def reproduce(given: Arguments) -> None:
    """Compute everything that a paper states.

    Write report.html, numbers.json and figures with their curves; this takes about a minute.
    """
    from electrovib.apps.progress import items_shown
    from electrovib.view.reproduce import reproduce

    with items_shown(f"reproducing {given['paper']}"):
        found = reproduce(**given)
    show_answer(found)
    say(f"written: {given['output']}/report.html")
