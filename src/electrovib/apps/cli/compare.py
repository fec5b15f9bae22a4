"""``electrovib compare``."""

from __future__ import annotations

from electrovib.apps.cli.answers import answered
from electrovib.apps.cli.options import Arguments, takes
from electrovib.apps.cli.terminal import say, show
from electrovib.core.errors import InputError


@takes("""
[scenario]         A scenario; without one, the static forces of the published laws on two stacks.
[others]...
--set
--models A,B,...|FILE.py -> laws  Force laws, all if absent; or a Python file with laws of your own; repeatable.
--all
--over
--material
--layer
-o, --output FILE  Write an HTML page.
--force
""")
def command(given: Arguments) -> None:
    """Compare force laws, or materials, on one stack.

    State which law to believe and why they differ; with --material, compare materials of the insulator.
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
        given.only("scenario set all materials layer", "--material, which compares no laws", "force")
        _print_materials(given)
    else:
        given.only("scenario set all laws over output", "the comparison of force laws", "force")
        _print_laws(given)


def _print_static(given: Arguments) -> None:
    from electrovib.core.answer import laid_out
    from electrovib.studies.surfaces import ANSWER, compare_surfaces

    needing = [name for name in ("set", "materials", "laws", "over", "output") if given.get(name)]
    if flags := [given.flags[name] for name in needing]:
        example = "electrovib compare vezzoli_2014/fig6"
        raise InputError(f"{flag}: needs a scenario, for instance {example} {flag} ..." for flag in flags)
    say(ANSWER)
    show(laid_out(compare_surfaces()))


def _print_laws(given: Arguments) -> None:
    """Compare the laws that are named, or all; a Python file among the names is imported."""
    from electrovib.core.own_models import use_models
    from electrovib.studies.compare import Comparison, compare

    named = given.pop("laws", None)
    files = [name for name in named or () if name.endswith(".py")]
    for file in files:
        use_models(file)
    laws = [name for name in dict.fromkeys(named or ()) if name not in files]
    given.read_set()
    brief = not given.keys() & {"all", "output"}
    given["models"] = laws if laws or (named is not None and not files) else None
    answered(Comparison, compare, "comparing force laws", given)
    if brief:
        say("--all explains why the laws differ, and lists where their papers contradict each other.")


def _print_materials(given: Arguments) -> None:
    from electrovib.studies.compare import MaterialComparison, compare_materials

    given.put_changes()
    given["materials"] = None if given["materials"] == ["all"] else given["materials"]
    answered(MaterialComparison, compare_materials, "comparing materials", given)
