"""One file for each publication, found automatically: its laws, values, scenarios and checks.

Its docstring says what the paper claims and what it does not. `CITATIONS`, `CITATION`, `STATUS` and a check are required;
laws are subclasses of a family, and `skins()`, `materials()`, `stacks()`, `scenarios()`, `measurements()` and `reproduce()`
are there if they have something to give. `PRESETS` states for each scenario what it shows. A scenario is a base and changes:
a pair is a value and its source, a table's source is that of the values in it without one, and what is not changed keeps the
source of the base.
"""
