"""The page of materials is as the library is."""

import importlib
from pathlib import Path

from electrovib.physics.material.library import materials

DOCS = Path(__file__).parents[3] / "docs"


def test_the_page_is_as_the_library_is_and_every_value_stands_with_its_status(monkeypatch):
    monkeypatch.syspath_prepend(str(DOCS / "_ext"))
    page = importlib.import_module("materials_page").as_markdown()
    # to renew it: python docs/_ext/materials_page.py > docs/materials.md
    assert (DOCS / "materials.md").read_text(encoding="utf-8") == page
    for words in (
        "| relative permittivity 3.4 | 1 kHz, 25 um, 23 C | unverified |",
        "| breakdown strength 236 MV/m | measured at 25.4 um; minimum of the data sheet, 60 Hz | full text |",
        "| conductivity, upper bound 0.1 fS/m |",
        "over frequency: ConstantPhase, permittivity = 3.1, reference_frequency = 1000, exponent = 0.99325",
    ):
        assert words in page
    assert page.count("\n## ") == len(materials()) + 1
    for substance in materials():
        section = page.partition(f"\n## {substance.name}\n")[2].partition("\n## ")[0]
        for value in (*substance.permittivity, *substance.strengths):
            assert f"| {value.status} | {value.source} |" in section
