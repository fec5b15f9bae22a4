"""What all tests share: the same examples in every run, and no window system."""

from __future__ import annotations

import os

from hypothesis import settings

os.environ.setdefault("MPLBACKEND", "Agg")
# the same examples each time, so that a red run is red again; search for new ones with
# --hypothesis-profile=search
settings.register_profile("repeatable", deadline=None, derandomize=True, print_blob=True, max_examples=60)
settings.register_profile("search", deadline=None, print_blob=True, max_examples=1000)
settings.load_profile("repeatable")
