"""Which kernel is used, and that it does not depend on the width of the vectors."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from electrovib.core.errors import InputError
from electrovib.solve.population.kernels import choice, kernel_name
from electrovib.solve.population.kernels.threads import in_threads, ranges, thread_count


def test_the_name_has_what_the_last_bits_depend_on(kernel):
    name, version, *width = kernel_name().replace(",", "").split()
    assert name == kernel
    assert version[0].isdigit()
    assert bool(width) == (kernel == "numba")


def test_another_kernel_is_refused(monkeypatch):
    monkeypatch.setenv(choice.CHOICE, "cuda")
    choice.compiled.cache_clear()
    with pytest.raises(InputError, match="numba or numpy"):
        kernel_name()
    choice.compiled.cache_clear()


def test_without_numba_it_is_numpy(monkeypatch):
    code = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None
from electrovib.solve.population.kernels import kernel_name, quantiles
print(kernel_name(), quantiles([[1.0], [3.0]], [0.5]))
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.startswith("numpy ")
    assert "[[2.]]" in done.stdout


def test_numba_that_is_missing_is_refused_where_it_is_asked_for():
    code = """
import sys
sys.modules["numba"] = sys.modules["llvmlite"] = None
from electrovib.solve.population.kernels import kernel_name
try:
    kernel_name()
except Exception as error:
    print(error)
"""
    environment = os.environ | {choice.CHOICE: "numba"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, env=environment
    )
    assert "cannot be imported" in done.stdout


@pytest.mark.slow  # compiles all kernels twice
@pytest.mark.parametrize("width", [1, 4])
def test_kernels_of_other_widths_pass_the_same_tests(width, tmp_path):
    """With vectors of four numbers, and as plain loops; the compiled code is kept elsewhere."""
    folder, names = Path(__file__).parent, ("stepping", "over_frequency")
    files = [str(folder / f"test_{name}.py") for name in names]
    environment = os.environ | {"ELECTROVIB_WIDTH": str(width), "NUMBA_CACHE_DIR": str(tmp_path)}
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-k", "numba", *files]
    done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
    assert done.returncode == 0, done.stdout[-3000:]


def test_threads_share_the_parts_and_pass_on_errors():
    done: list[int] = []
    for threads in (1, 3, None):
        in_threads(done.append, [1, 2, 3], threads)
    assert sorted(done) == [1, 1, 1, 2, 2, 2, 3, 3, 3]
    assert ranges(5, 2) == [(0, 2), (2, 4), (4, 5)]
    assert thread_count(0) == 1
    assert thread_count(None) >= 1

    def fails(part):
        raise ValueError(part)

    with pytest.raises(ValueError, match="7"):
        in_threads(fails, [7, 8], 2)


def test_code_compiled_from_other_files_counts_as_out_of_date():
    """The cache of numba looks at one file alone; a changed constant of another one once gave wrong machine code."""
    pytest.importorskip("numba")
    from electrovib.solve.population.kernels.compiled.selection import count_bins
    from electrovib.solve.recursion.vectors.jit import _stamp
    from electrovib.solve.recursion.vectors.width import WIDTH

    kept = count_bins._cache._cache_file._source_stamp
    named = {each[0] for each in kept[1:]}
    assert kept == _stamp(Path(count_bins.py_func.__code__.co_filename).parent)
    assert {"selection.py", "tiles.py", "stepping.py", "jit.py"} <= named
    assert kept[0] == WIDTH


def test_a_numba_without_that_mark_does_not_keep_compiled_code(monkeypatch):
    numba = pytest.importorskip("numba")
    from electrovib.solve.recursion.vectors import jit

    asked = []

    def njit(function, **options):
        asked.append(options)
        return function

    monkeypatch.setattr(numba, "njit", njit)
    assert jit.outer(abs) is abs
    assert [each.get("cache", False) for each in asked] == [True, False]
