"""The example notebook, from `load` to plots, run in a kernel as a user's is; one kernel, on this machine alone."""

import base64
import math
import re
from pathlib import Path

import pytest

from electrovib.core.constants import eps0

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
nbclient = pytest.importorskip("nbclient")
pytestmark = pytest.mark.slow

EXAMPLE = Path(__file__).parents[2] / "examples" / "from_load_to_plot.ipynb"
MORE = {
    "imported": "import sys\nprint('matplotlib.pyplot' in sys.modules)",
    "mistake": "def changed(**changes):\n    return scenario.replace(changes)\n\nchanged(**{'drive.hihg': '1 V'})",
    "dataset": "import xarray\nxarray.Dataset({'a': ('x', [1.0, 2.0])})",
    "pyplot": "import matplotlib.pyplot as plt\nev.plot.force(trace);",
}
"""Cells that are run after those of the example."""
FOLDERS = ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR")


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Run all cells in one kernel; the outputs of each by its name."""
    place, notebook = tmp_path_factory.mktemp("notebook"), nbformat.read(EXAMPLE, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    notebook.cells += [nbformat.v4.new_code_cell(source, id=name) for name, source in MORE.items()]
    how = {"timeout": 60, "startup_timeout": 60, "allow_errors": True, "kernel_name": "python3"}
    with pytest.MonkeyPatch.context() as patch:
        for name in FOLDERS:
            patch.setenv(name, str(place / name.lower()))
        patch.delenv("MPLBACKEND", raising=False)  # a notebook's own, not that of these tests
        nbclient.NotebookClient(notebook, resources={"metadata": {"path": str(place)}}, **how).execute()
    return {cell.id: cell.outputs for cell in notebook.cells if cell.cell_type == "code"}


def shown(outputs, form):
    found = [output.data[form] for output in outputs if form in output.get("data", {})]
    assert len(found) == 1, [output.output_type for output in outputs]
    return found[0]


TEXTS = {
    "load": ["90 µm", "Vezzoli 2014, section 3.1"],
    "simulate": ["Validity:", "largest drive voltage 500 V", "time (2001), layer (2), frequency (121)"],
    "sweep": [
        "Swept: stack.insulator.thickness 10 µm … 100 µm (4 values)",
        "at stack.insulator.thickness = 10 µm",
    ],
    "models": ["Trapezium"],
    "dataset": ["xarray.Dataset"],
}


@pytest.mark.parametrize("cell", TEXTS)
def test_what_a_cell_shows(outputs, cell):
    page = re.sub(r"<[^>]*>", " ", shown(outputs[cell], "text/html")).replace("&#39;", "'")
    for words in TEXTS[cell]:
        assert words in " ".join(page.split())


def test_the_number_of_the_example(outputs):
    """Attraction at the end of a ramp of 36 ms to 500 V over 50 um, by equations (5) and (6) of Vezzoli et al. 2014."""
    (printed,) = (output.text for output in outputs["number"])
    film, skin = 50e-6 / 3.35, 200e-6 / 1560
    tau = eps0 * 1560 / 1.79384e-6 * (1 + skin / film)
    effective = 500 * tau / 36e-3 * (1 - math.exp(-36e-3 / tau))
    force = eps0 * 1e-4 * effective**2 / (2 * (film + skin) * 250e-6)
    assert float(re.search(r"[\d.]+", printed)[0]) == pytest.approx(1e3 * force, rel=1e-3)


def test_plots_in_a_fresh_kernel_and_with_pyplot_the_picture_comes_once(outputs):
    """Neither the cells nor this package have imported pyplot."""
    for name in ("plot", "stack", "quantity"):
        assert base64.b64decode(shown(outputs[name], "image/png")).startswith(b"\x89PNG"), name
    assert "".join(output.text for output in outputs["imported"]) == "False\n"
    pictures = [output.output_type for output in outputs["pyplot"] if "image/png" in output.get("data", {})]
    assert pictures == ["display_data"]


def test_only_the_mistake_fails_with_a_sentence(outputs):
    failed = [name for name, found in outputs.items() if any(each.output_type == "error" for each in found)]
    assert failed == ["mistake"]
    (error,) = outputs["mistake"]
    assert error.ename == "InputError"
    assert len(error.traceback) == 2
    assert "Did you mean 'high'?" in error.traceback[0]
    assert error.traceback[1] == "in line 2: return scenario.replace(changes)"
