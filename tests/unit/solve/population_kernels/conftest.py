"""Each test of a kernel runs with numpy and with numba."""

import pytest

from electrovib.solve.population.kernels import choice


@pytest.fixture(params=["numpy", "numba"])
def kernel(request, monkeypatch):
    """Choose the kernel of this test."""
    if request.param == "numba":
        pytest.importorskip("numba")
    monkeypatch.setenv(choice.CHOICE, request.param)
    choice.compiled.cache_clear()
    yield request.param
    choice.compiled.cache_clear()


@pytest.fixture
def with_kernel(monkeypatch):
    """Compute something with a kernel of a given name."""

    def compute(name, function, *arguments, **options):
        monkeypatch.setenv(choice.CHOICE, name)
        choice.compiled.cache_clear()
        return function(*arguments, **options)

    yield compute
    monkeypatch.undo()
    choice.compiled.cache_clear()
