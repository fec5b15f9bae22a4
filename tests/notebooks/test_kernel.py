"""The example notebook, from `load` to plots, run in a kernel as a user's is; one kernel, on this machine alone."""

from __future__ import annotations

import base64
import math
import re
from pathlib import Path

import pytest

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


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Run all cells in one kernel; the outputs of each by its name."""
    place = tmp_path_factory.mktemp("notebook")
    notebook = nbformat.read(EXAMPLE, as_version=4)
    assert not any(cell.get("outputs") for cell in notebook.cells)
    notebook.cells += [nbformat.v4.new_code_cell(source, id=name) for name, source in MORE.items()]
    with pytest.MonkeyPatch.context() as patch:
        for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR", "JUPYTER_RUNTIME_DIR"):
            patch.setenv(name, str(place / name.lower()))
        patch.delenv("MPLBACKEND", raising=False)  # a notebook's own, not that of these tests
        client = nbclient.NotebookClient(
            notebook,
            timeout=60,
            startup_timeout=60,
            allow_errors=True,
            kernel_name="python3",
            resources={"metadata": {"path": str(place)}},
        )
        client.execute()
    return {cell.id: cell.outputs for cell in notebook.cells if cell.cell_type == "code"}


def shown(outputs, form):
    found = [output.data[form] for output in outputs if form in output.get("data", {})]
    assert len(found) == 1, [output.output_type for output in outputs]
    return found[0]


def text_of(outputs):
    return " ".join(re.sub(r"<[^>]*>", " ", shown(outputs, "text/html")).replace("&#39;", "'").split())


def test_only_the_mistake_fails(outputs):
    failed = [
        name for name, found in outputs.items() if any(output.output_type == "error" for output in found)
    ]
    assert failed == ["mistake"]


def test_a_scenario(outputs):
    text = text_of(outputs["load"])
    assert "90 µm" in text
    assert "Vezzoli 2014, section 3.1" in text
    lines = shown(outputs["load"], "text/plain").splitlines()
    assert lines[1] == "  drive: Trapezium(high = 1 kV, rise = 36 ms, hold = 100 ms, fall = 36 ms)"


def test_the_number_of_the_example(outputs):
    """Attraction at the end of a ramp of 36 ms to 500 V over 50 um, by equations (5) and (6) of Vezzoli et al. 2014."""
    (printed,) = (output.text for output in outputs["number"])
    film, skin = 50e-6 / 3.35, 200e-6 / 1560
    tau = 8.8541878128e-12 * 1560 / 1.79384e-6 * (1 + skin / film)
    effective = 500 * tau / 36e-3 * (1 - math.exp(-36e-3 / tau))
    force = 8.8541878128e-12 * 1e-4 * effective**2 / (2 * (film + skin) * 250e-6)
    assert float(re.search(r"[\d.]+", printed)[0]) == pytest.approx(1e3 * force, rel=1e-3)


def test_a_trace(outputs):
    text = text_of(outputs["simulate"])
    assert "Validity:" in text
    assert "largest drive voltage 500 V" in text
    assert "Dimensions: time (2001), layer (2), frequency (121)" in text


def test_plots_in_a_fresh_kernel(outputs):
    """Neither the cells nor this package have imported pyplot."""
    for name in ("plot", "stack", "quantity"):
        assert base64.b64decode(shown(outputs[name], "image/png")).startswith(b"\x89PNG"), name
    assert "".join(output.text for output in outputs["imported"]) == "False\n"


def test_a_sweep(outputs):
    text = text_of(outputs["sweep"])
    assert "Swept: stack.insulator.thickness 10 µm … 100 µm (4 values)" in text
    assert "at stack.insulator.thickness = 10 µm" in text


def test_models(outputs):
    assert "Trapezium" in text_of(outputs["models"])


def test_a_mistake_is_a_sentence(outputs):
    (error,) = outputs["mistake"]
    assert error.ename == "InputError"
    assert len(error.traceback) == 2
    assert "Did you mean 'high'?" in error.traceback[0]
    assert error.traceback[1] == "in line 2: return scenario.replace(changes)"


def test_another_dataset(outputs):
    assert "xarray.Dataset" in text_of(outputs["dataset"])


def test_with_pyplot_the_picture_comes_once(outputs):
    pictures = [output.output_type for output in outputs["pyplot"] if "image/png" in output.get("data", {})]
    assert pictures == ["display_data"]
