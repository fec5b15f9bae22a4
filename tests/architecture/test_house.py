"""The house stays one that a newcomer can read: few doors in `solve/`, one place of choice, one word for one idea."""

import ast
import importlib
import re
import subprocess
import sys
import tomllib
from collections import Counter

import pytest
from packaging.requirements import Requirement
from packaging.version import Version
from source import ROOT, SOURCE, nodes_of

from electrovib.solve.choice import SOLVERS

FLAT = 8
LONG_FUNCTION, SHARE = 25, 0.9
LONGEST_FUNCTION = 60
ROOMS = "electrics mechanics nonlinear diagnostics equilibrium choice.py effort.py"
FAMILIES = "friction contact finger.py time_profile.py rig.py"


def modules():
    return {path.relative_to(SOURCE).as_posix(): nodes_of(path) for path in sorted(SOURCE.rglob("*.py"))}


def within(parent, names):
    """Return the modules of folders and files of a room."""
    places = [SOURCE / parent / name for name in names.split()]
    return [path for place in places for path in ([place] if place.is_file() else sorted(place.glob("*.py")))]


def classes(nodes):
    return [node.name for node in nodes if isinstance(node, ast.ClassDef)]


def test_few_modules_lie_flat_in_solve():
    flat = [path.name for path in (SOURCE / "solve").glob("*.py") if path.name != "__init__.py"]
    assert len(flat) <= FLAT, flat
    assert {"simulate.py", "choice.py"} <= set(flat)


def test_one_module_lists_the_solvers_and_nobody_steers_by_their_names():
    """Which solver runs is decided by what it takes; what follows from it is in its `Method`."""
    names = {solver.method.name for solver in SOLVERS}
    makers = []
    for path, nodes in modules().items():
        if any(isinstance(node, ast.Name) and node.id == "Solver" for node in nodes):
            makers.append(path)
        for node in nodes:
            if isinstance(node, ast.Compare):
                compared = {each.value for each in ast.walk(node) if isinstance(each, ast.Constant)}
                assert not names & compared, f"{path}:{node.lineno}"
    assert makers == ["solve/choice.py"]


def asked(tree):
    """Classes that `isinstance` compares with; an assertion, which narrows a type for the checker, is not a question."""
    for node in ast.iter_child_nodes(tree):
        if isinstance(node, ast.Assert):
            continue
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "isinstance":
            yield from (name.id for name in ast.walk(node.args[1]) if isinstance(name, ast.Name))
        yield from asked(node)


def test_no_solver_asks_for_the_class_of_a_model():
    """It asks what a model can do, so that a contributed one takes the way of the shipped ones."""
    models = {name for path in within("physics", FAMILIES) for name in classes(nodes_of(path))}
    assert {"Coulomb", "FixedArea", "MassSpringDamper", "Steady"} <= models
    solvers = within("solve", ROOMS)
    assert len(solvers) > 30
    for path in solvers:
        assert not models & set(asked(nodes_of(path)[0])), path
    tree = ast.parse("x = 1 if isinstance(law, (Coulomb, int)) else 0\nassert isinstance(law, Dahl)")
    assert set(asked(tree)) & models == {"Coulomb"}


def test_no_class_name_twice():
    found = Counter(name for nodes in modules().values() for name in classes(nodes))
    assert not [name for name, count in found.items() if count > 1]
    assert len(found) > 200
    assert classes(ast.walk(ast.parse("def f():\n    class Layer: pass\n"))) == ["Layer"], (
        "also inside functions"
    )


def code_lines(node):
    """Lines of a function without its docstring."""
    text = ast.get_docstring(node, clean=False)
    docstring = node.body[0].end_lineno - node.body[0].lineno + 1 if text is not None else 0
    return node.end_lineno - node.lineno + 1 - docstring


def test_functions_fit_a_screen():
    sizes = {
        f"{path}:{node.lineno} {node.name}": code_lines(node)
        for path, nodes in modules().items()
        for node in nodes
        if isinstance(node, ast.FunctionDef)
    }
    assert not [name for name, size in sizes.items() if size > LONGEST_FUNCTION]
    assert sum(size < LONG_FUNCTION for size in sizes.values()) > SHARE * len(sizes)


@pytest.mark.parametrize("path", sorted((ROOT / "benchmarks").glob("*.py")), ids=lambda path: path.stem)
def test_names_that_a_benchmark_imports_exist(path):
    """Although no test runs the benchmarks."""
    for node in nodes_of(path):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("electrovib"):
            module = importlib.import_module(node.module)
            for alias in node.names:
                if not hasattr(module, alias.name):
                    importlib.import_module(f"{node.module}.{alias.name}")


def test_version_addresses_and_requirements_are_the_same_in_every_file_that_states_them():
    """The build reads the version from `CITATION.cff`, where its date stands; the recipe and the changelog repeat it."""
    settings = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    project, source = settings["project"], settings["tool"]["hatch"]["version"]
    names = (source["path"], "conda/recipe.yaml", "CHANGELOG.md")
    citation, recipe, changes = ((ROOT / name).read_text(encoding="utf-8") for name in names)
    (version,) = re.findall(source["pattern"], citation, re.MULTILINE)
    (date,) = re.findall(r"^date-released: (.*)$", citation, re.MULTILINE)
    assert str(Version(version)) == version, "as the names of the built files have it"
    assert re.findall(r'^  version: "(.*)"$', recipe, re.MULTILINE) == [version]
    assert re.findall(r"^## (\[\d.*)$", changes, re.MULTILINE)[0] == f"[{version}] - {date}"
    assert project["dynamic"] == ["version"]
    assert all(f'url: "{address}"' in citation for address in project["urls"].values())
    listed = recipe.partition("  run:\n")[2].partition("\n\n")[0].replace("matplotlib-base", "matplotlib")
    needed = ["python" + project["requires-python"], *project["dependencies"]]
    assert [line.strip("- ").replace(" ", "") for line in listed.splitlines()] == needed


def test_the_extra_all_is_every_extra_of_a_user():
    optional = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"][
        "optional-dependencies"
    ]
    (extras,) = re.findall(r"^extras=(.*)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    assert optional["all"] == [f"electrovib[{extras}]"]


def test_the_job_with_the_lowest_versions_installs_what_is_stated_for_every_extra_of_a_user():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    optional = project["optional-dependencies"]
    (extras,) = re.findall(r"^extras=(.*)$", (ROOT / ".ci" / "run").read_text(encoding="utf-8"), re.MULTILINE)
    assert set(extras.split(",")) == set(optional) - {"all", "benchmarks", "docs", "dev"}
    command = [sys.executable, ROOT / ".ci" / "lowest_versions.py", extras]
    printed = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60).stdout
    required = [*project["dependencies"], *(each for extra in extras.split(",") for each in optional[extra])]
    for line, each in zip(printed.splitlines(), required, strict=True):
        pinned, requirement = Requirement(line), Requirement(each)
        (lowest,) = [one.version for one in requirement.specifier if one.operator == ">="]
        assert (pinned.name, pinned.extras) == (requirement.name, set())  # pip refuses extras in constraints
        assert str(pinned.specifier) == f"=={lowest}"
