"""Versions of the parts, without importing them."""

from __future__ import annotations

import platform
from importlib.metadata import version

import numpy as np

from electrovib.core import versions as module


def test_versions_are_those_installed(monkeypatch):
    monkeypatch.setattr(module, "PARTS", ("electrovib", "numpy", "surely-not-installed"))
    found = module.versions()
    assert found["numpy"] == np.__version__
    assert found["electrovib"] == version("electrovib")
    assert found["python"] == platform.python_version()
    assert "surely-not-installed" not in found
