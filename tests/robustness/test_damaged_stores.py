"""A damaged store of a study is answered in a sentence at every door, and stays as it was."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from stand_in_population import stand_in

from electrovib.core.answer import Document

pytestmark = pytest.mark.skipif(
    not hasattr(os, "mkfifo"), reason="pipes and links of POSIX are among the damages"
)


def wrong(found):
    """List the cases that were not refused in a sentence, and not read with the result of the whole store either."""
    return [case for case in found if not {said[0] for said in case[3].values()} <= {"refused", "accepted"}]


@pytest.fixture
def quarters(monkeypatch):
    """Studies and pages that cost nothing, in tiles of a quarter of a block."""
    from damaged_stores import in_quarters

    def shown(found, **_):
        return Document(title=str(found.attrs), sentences=[])

    monkeypatch.setattr("electrovib.studies.population.answer.study_document", shown)
    monkeypatch.setattr("electrovib.solve.population.Population", stand_in)
    monkeypatch.setattr("electrovib.studies.population.tiles.TileSizes.measured", in_quarters)


def test_some_damaged_stores_are_refused_at_every_door(tmp_path, quarters):
    from damaged_stores import cases

    found = list(cases(tmp_path, 1000, 1012))
    assert not wrong(found)
    assert sum(case[3]["study"][0] == "refused" for case in found) > 8


@pytest.mark.slow
def test_without_its_checksums_a_store_is_misread(tmp_path, quarters, monkeypatch):
    """The damages do harm: not all of them are refused for another reason."""
    from damaged_stores import cases

    monkeypatch.setattr("electrovib.studies.population.files.refuse_damaged", lambda *_: None)
    assert {said[0] for case in wrong(cases(tmp_path, 1000, 1060)) for said in case[3].values()} >= {
        "wrong",
        "crashed",
    }


@pytest.mark.slow
def test_500_damaged_stores_are_refused_within_a_gigabyte(tmp_path):
    here = Path(__file__).parent
    places = [os.environ.get("PYTHONPATH", ""), str(here.with_name("reference"))]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(filter(None, places))}
    command = [sys.executable, str(here / "damaged_stores.py"), str(tmp_path), "0", "500"]
    told = subprocess.run(
        command, stdout=subprocess.PIPE, text=True, env=environment, check=True, timeout=900
    )
    found = [json.loads(line) for line in told.stdout.splitlines()]
    assert len(found) == 500
    assert not wrong(found)
