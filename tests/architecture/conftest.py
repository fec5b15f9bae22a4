"""Parsed files are forgotten after the tests of this folder: the collector of garbage would visit them in all others."""

import pytest
import source


@pytest.fixture(scope="package", autouse=True)
def forgotten_afterwards():
    yield
    for kept in (source.nodes_of, source.tree_of, source.text_of):
        kept.cache_clear()
