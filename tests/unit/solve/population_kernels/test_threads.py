"""Parts on several threads, the name of what computes, and compiled code without a folder for it."""

import numba
import pytest

from electrovib.solve.population.kernels import kernel_name, loops
from electrovib.solve.population.kernels.percentiles import in_threads, ranges, thread_count


def test_the_name_has_what_the_last_bits_depend_on():
    assert kernel_name() == f"numba {numba.__version__}"


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


def test_without_a_folder_compiled_code_is_not_kept(monkeypatch):
    asked = []

    def njit(function, **options):
        asked.append(options.get("cache", False))
        if asked[-1]:
            raise RuntimeError("cannot cache function: no locator available")
        return function

    monkeypatch.setattr(numba, "njit", njit)
    assert loops.outer(abs) is abs
    assert asked == [True, False]
