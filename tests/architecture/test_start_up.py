"""What is imported when: nothing by importing the package, nothing heavy by asking for help or one run."""

import ast
import json
import subprocess
import sys

import pytest
from source import SOURCE, tree_of

NAMES = (
    "scipy xarray matplotlib numba pandas pint jinja2 h5py h5netcdf tomlkit emcee dynesty sympy mpmath dask zarr nicegui"
    " plotly pyvisa serial nptdms soundfile control jax"
)
HEAVY = tuple(NAMES.split())
"""Costly or optional: imported only inside the function that needs it."""


def loaded_after(statement):
    """Names of all modules in a fresh interpreter after a statement."""
    script = f"import json, sys\n{statement}\nsys.stdout.write('\\n' + json.dumps(sorted(sys.modules)))"
    command = [sys.executable, "-c", script]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    assert done.returncode == 0, done.stderr
    return set(json.loads(done.stdout.splitlines()[-1]))


def among(modules, names):
    return sorted({module.split(".")[0] for module in modules} & set(names))


def test_importing_the_package_imports_nothing():
    """And every name that it offers can be had."""
    loaded = loaded_after("import electrovib")
    assert not among(loaded, ["numpy", "scipy", "xarray", "pydantic", "matplotlib", "typer", "rich", *HEAVY])
    assert [name for name in loaded if name.startswith("electrovib")] == ["electrovib"]
    loaded_after("import electrovib as ev; assert len([getattr(ev, name) for name in dir(ev)]) > 8")


def loaded_by(command, said):
    """Names of all modules after a command has said something."""
    statement = f"""
import contextlib, io, runpy
sys.argv = {["electrovib", *command.split()]}
text = io.StringIO()
with contextlib.redirect_stdout(text):
    try:
        runpy.run_module("electrovib", run_name="__main__", alter_sys=True)
    except SystemExit as end:
        assert not end.code
assert "{said}" in text.getvalue()
"""
    return loaded_after(statement)


@pytest.mark.parametrize("command", ["", "run", "report", "reproduce", "init", "find-value", "list", "fit"])
def test_help_imports_nothing_heavy(command):
    unused = [*HEAVY, "numpy", *([] if command else ["pydantic"])]
    assert not among(loaded_by(f"{command} --help", command or "reproduce"), unused)


@pytest.mark.parametrize(
    ("command", "said", "needed", "unused"),
    [
        (
            "run vezzoli_2014/fig6",
            "lateral force: 250 mN to",
            ["pandas", "xarray"],
            "studies.sweep scenario.space",
        ),
        ("list", "MaxwellStressInGap", [], "solve.stack solve.expanded scenario.space"),
        ("list parylene", "parylene_c", [], "solve.expanded"),
    ],
)
def test_a_command_imports_what_it_needs(command, said, needed, unused):
    """Whatever is installed: no plots, no compiler, no chunks, and of our own folders none that does not take part."""
    loaded = loaded_by(command, said)
    assert among(loaded, [*HEAVY, "llvmlite"]) == needed
    assert not [name for name in unused.split() if f"electrovib.{name}" in loaded]


def test_one_run_imports_what_it_needs():
    """A Trace needs xarray, which brings pandas; no units, no chunks, no plots, no compiler, no filters."""
    loaded = loaded_after("import electrovib as ev; ev.simulate(ev.load('vezzoli_2014/fig6'))")
    assert "xarray" in loaded
    unwanted = ["dask", "pint", "numba", "llvmlite", "matplotlib", "sympy", "jinja2", "typer"]
    assert not among(loaded, unwanted)
    assert "scipy.signal" not in loaded
    for rare in ("nonlinear.", "electrics.moving_gap", "electrics.amplifier"):
        assert not [name for name in loaded if name.startswith(f"electrovib.solve.{rare}")]
    assert among(loaded, HEAVY), "the check can fail"


def top_level_imports(path):
    """Modules imported when a file is, type-checking blocks left out."""
    waiting = list(tree_of(path).body)
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom):
            yield node.module or ""
        elif isinstance(node, ast.If) and "TYPE_CHECKING" in ast.unparse(node.test):
            waiting += node.orelse
        elif not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            waiting += [child for child in ast.iter_child_nodes(node) if isinstance(child, ast.stmt)]


PAGE = SOURCE / "apps" / "explorer" / "page"
"""The only folder whose modules are made of a heavy one; `explore` alone imports them."""
STUDY = SOURCE / "studies" / "population" / "answer.py"
"""A class that is an xarray.Dataset; no module imports it on its own import."""


def test_heavy_modules_are_imported_inside_functions():
    found = [
        f"{path.relative_to(SOURCE)}: {name}"
        for path in sorted(SOURCE.rglob("*.py"))
        for name in top_level_imports(path)
        if name.split(".")[0] in HEAVY
        if (PAGE not in path.parents or name != "nicegui") and (path, name) != (STUDY, "xarray")
    ]
    assert not found, "\n".join(found)


def test_the_class_that_is_a_dataset_is_imported_inside_functions():
    imported = [
        path
        for path in sorted(SOURCE.rglob("*.py"))
        if "electrovib.studies.population.answer" in top_level_imports(path)
    ]
    assert not imported


def test_top_level_imports_are_seen(tmp_path):
    source = tmp_path / "module.py"
    source.write_text(
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    import pandas\ntry:\n    import numba\n"
        "except ImportError:\n    pass\nclass A:\n    import xarray\n    def f(self):\n        import scipy\n",
        encoding="utf-8",
    )
    assert set(top_level_imports(source)) == {"typing", "numba", "xarray"}
