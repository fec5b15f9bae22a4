"""A notebook, from `load` to plot, run in a kernel as a user's is; one kernel, on this machine alone."""

from __future__ import annotations

import base64
import re

import pytest

nbformat = pytest.importorskip("nbformat")
pytest.importorskip("ipykernel")
nbclient = pytest.importorskip("nbclient")
pytestmark = pytest.mark.slow

CELLS = {
    "load": "import electrovib as ev\nscenario = ev.load('vezzoli_2014/fig6')\nscenario",
    "simulate": "trace = ev.simulate(scenario)\ntrace",
    "plot": "ev.plot.force(trace)",
    "sweep": "ev.sweep(scenario, {'drive.high': [100, 200]}, quantities=['peak electrostatic_force'])",
    "models": "ev.models()",
    "mistake": "def changed(**changes):\n    return scenario.replace(changes)\n\nchanged(**{'drive.hihg': '1 V'})",
    "imported": "import sys\nprint('matplotlib.pyplot' in sys.modules)",
    "dataset": "import xarray\nxarray.Dataset({'a': ('x', [1.0, 2.0])})",
    "pyplot": "import matplotlib.pyplot as plt\nev.plot.force(trace);",
}


@pytest.fixture(scope="module")
def outputs(tmp_path_factory):
    """Run all cells in one kernel; outputs of each cell, and what completion lists."""
    place = tmp_path_factory.mktemp("notebook")
    folders = {
        name: str(place / name.lower()) for name in ("IPYTHONDIR", "JUPYTER_CONFIG_DIR", "JUPYTER_DATA_DIR")
    }
    notebook = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell(cell) for cell in CELLS.values()])
    with pytest.MonkeyPatch.context() as patch:
        for name, folder in (folders | {"JUPYTER_RUNTIME_DIR": str(place / "runtime")}).items():
            patch.setenv(name, folder)
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
    return {name: cell.outputs for name, cell in zip(CELLS, notebook.cells, strict=True)}


def shown(outputs, form):
    found = [output.data[form] for output in outputs if form in output.get("data", {})]
    assert len(found) == 1, [output.output_type for output in outputs]
    return found[0]


def text_of(outputs):
    return " ".join(re.sub(r"<[^>]*>", " ", shown(outputs, "text/html")).split())


def test_a_scenario(outputs):
    text = text_of(outputs["load"])
    assert "90 µm" in text
    assert "Vezzoli 2014, section 3.1" in text
    assert shown(outputs["load"], "text/plain").splitlines()[1] == (
        "  drive: Trapezium(high = 1 kV, rise = 36 ms, hold = 100 ms, fall = 36 ms)"
    )


def test_a_trace(outputs):
    text = text_of(outputs["simulate"])
    assert text.index("above 661 V") < text.index("largest electrostatic force 2.562 mN")


def test_a_plot_in_a_fresh_kernel(outputs):
    picture = base64.b64decode(shown(outputs["plot"], "image/png"))
    assert picture.startswith(b"\x89PNG")
    assert "".join(output.text for output in outputs["imported"]) == "False\n"


def test_a_sweep(outputs):
    assert "at drive.high = 100 V" in text_of(outputs["sweep"])


def test_models(outputs):
    assert "Trapezium" in text_of(outputs["models"])


def test_a_mistake_is_a_sentence(outputs):
    (error,) = outputs["mistake"]
    assert error.output_type == "error"
    assert error.ename == "InputError"
    assert len(error.traceback) == 2
    assert "Did you mean 'high'?" in error.traceback[0]
    assert error.traceback[1] == "in line 2: return scenario.replace(changes)"


def test_another_dataset(outputs):
    assert "xarray.Dataset" in text_of(outputs["dataset"])


def test_with_pyplot_the_picture_comes_once(outputs):
    assert [output.output_type for output in outputs["pyplot"] if "image/png" in output.get("data", {})] == [
        "display_data"
    ]
