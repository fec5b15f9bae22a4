"""Random scenarios of the whole declared space: each runs within its budget, or is refused in sentences."""

import os

import pytest

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(not hasattr(os, "fork"), reason="a scenario that may crash runs in a forked process"),
]
EACH, GROUPS = 15, 20


@pytest.mark.parametrize("group", range(GROUPS))
def test_a_random_scenario_runs_or_is_refused_in_sentences(group):
    from watched import HELD, outcome_of

    for seed in range(group * EACH, (group + 1) * EACH):
        found = outcome_of(seed)
        assert found.what in ("ran", "unread", "refused", "budget", "stopped"), found
        assert found.memory < HELD, found
        if found.what != "ran":
            assert found.said.strip(), found
            assert "Traceback" not in found.said, found
