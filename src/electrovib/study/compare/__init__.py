"""Comparison of all force laws on one stack: how much they differ, in size and in time, and why."""

from electrovib.study.compare.entry import Comparison as Comparison
from electrovib.study.compare.entry import Entry as Entry
from electrovib.study.compare.laws import compare as compare
from electrovib.study.compare.static import static_force as static_force
