"""The static comparison of the published force laws and the exact identities between its rows."""

from __future__ import annotations

import pytest

from electrovib.study.surfaces import FILM, SCREEN, cell, compare_surfaces

# computed apart from this code and printed to four digits; 0.5 % is what the table is asked for, 1e-3 what four digits bear
FILM_CELLS = {
    ("EffectiveMedium", 0.0): 56.55e-3,
    ("MaxwellStressInGap", 0.0): 607.6e-3,
    ("MaxwellStressInGap", 1e-6): 564.9e-3,
    ("MaxwellStressInGap", 5e-6): 432.5e-3,
    ("MaxwellStressInGap", 25e-6): 163.8e-3,
    ("MaxwellStressInGap", 100e-6): 27.5e-3,
    ("MaxwellStressInStratumCorneum", 0.0): 0.389e-3,
    ("MaxwellStressInInsulator", 0.0): 181.4e-3,
}
SCREEN_CELLS = {
    ("EffectiveMedium", 0.0): 58.33e-3,
    ("MaxwellStressInGap", 0.0): 31.05,
    ("MaxwellStressInGap", 0.1e-6): 19.41,
    ("MaxwellStressInGap", 1e-6): 2.333,
    ("MaxwellStressInGap", 3e-6): 0.3881,
    ("MaxwellStressInGap", 10e-6): 41.11e-3,
    ("MaxwellStressInStratumCorneum", 0.0): 18.82e-3,
    ("MaxwellStressInInsulator", 0.0): 7.960,
}
CELLS = [(FILM, *key, value) for key, value in FILM_CELLS.items()]
CELLS += [(SCREEN, *key, value) for key, value in SCREEN_CELLS.items()]


@pytest.mark.parametrize(
    ("stack", "law", "gap", "force"), CELLS, ids=lambda value: str(getattr(value, "name", value))
)
def test_cells(stack, law, gap, force):
    digits = 2e-3 if force in {27.5e-3, 0.389e-3} else 5e-4  # half of the last of three or four digits
    assert cell(stack, law, gap=gap) == pytest.approx(force, rel=digits)
    assert cell(stack, law, gap=gap) != pytest.approx(force * (1 + 3 * digits), rel=digits)


@pytest.mark.parametrize("stack", [FILM, SCREEN], ids=lambda stack: stack.name)
def test_the_forms_are_one_displacement_divided_by_the_permittivity_of_a_plane(stack):
    gap = cell(stack, "MaxwellStressInGap")
    electrical = stack.film / stack.film_permittivity + stack.skin / stack.skin_permittivity
    medium = (stack.film + stack.skin) / electrical
    # identities, to rounding
    assert gap / cell(stack, "EffectiveMedium") == pytest.approx(medium, rel=1e-12)
    assert gap / cell(stack, "MaxwellStressInStratumCorneum") == pytest.approx(
        stack.skin_permittivity, rel=1e-12
    )
    assert gap / cell(stack, "MaxwellStressInInsulator") == pytest.approx(stack.film_permittivity, rel=1e-12)


def test_the_printed_table_has_every_cell_and_says_how_its_stacks_were_read():
    table = compare_surfaces()
    text = "\n".join(" ".join(row) for row in table.rows)
    for shown in ("56.55 mN", "607.6 mN", "31.05 N", "2.333 N", "7.96 N", "18.82 mN"):
        assert shown in text
    assert "(unverified)" in table.headings[-1]
    assert "value cited from memory, unverified" in table.caption
    marked = {(row[0], row[2]) for row in table.rows if "beyond breakdown" in row[-1]}
    assert marked == {
        ("MaxwellStressInGap", "0"),
        ("MaxwellStressInGap", "100 nm"),
    }  # 265 and 209 MV/m; 73 MV/m at 1 um is not
    # on the film 37 MV/m at most; across 25 um 481 V, where Paschen's law allows 381 V
    assert {(row[0], row[2]) for row in table.rows if "beyond breakdown" in row[-2]} == {
        ("MaxwellStressInGap", "25 um")
    }
