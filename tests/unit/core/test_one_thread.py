"""Linear algebra on one thread in a block, in one and in several threads of Python, and on as many as before after it."""

import sys
from threading import Event, Thread

import numpy as np
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from electrovib.core.budget import ONE_THREAD, one_thread


def threads():
    """How many threads each library of linear algebra may use."""
    return {each["num_threads"] for each in threadpool_info() if each["user_api"] == "blas"}


@pytest.fixture(autouse=True)
def two_threads(monkeypatch):
    for name in ONE_THREAD:
        monkeypatch.delenv(name, raising=False)
    with threadpool_limits(limits=2, user_api="blas"):
        yield
        assert threads() == {2}


def test_in_a_block_in_blocks_within_it_and_after_an_error():
    with one_thread():
        assert threads() == {1}
        with pytest.raises(np.linalg.LinAlgError), one_thread():
            np.linalg.inv(np.zeros((2, 2)))
        assert threads() == {1}
    assert threads() == {2}


def test_a_block_that_lasts_longer_than_that_of_another_thread_leaves_no_limit():
    begun, ended = Event(), Event()

    def other():
        with one_thread():
            begun.set()
            ended.wait()

    beside = Thread(target=other)
    with one_thread():
        beside.start()
        begun.wait()
    ended.set()
    beside.join()


def test_a_function_loads_the_library_of_scipy_before():
    @one_thread(with_scipy=True)
    def inside():
        return "scipy.linalg" in sys.modules, threads()

    assert inside() == (True, {1})


def test_where_the_environment_says_it_nothing_changes(monkeypatch):
    for name, value in ONE_THREAD.items():
        monkeypatch.setenv(name, value)
    with one_thread(with_scipy=True):
        assert threads() == {2}
