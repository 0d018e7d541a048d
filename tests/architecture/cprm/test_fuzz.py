"""The reader of CPRMs takes a hundred thousand damaged files without an error that is not ours."""

from __future__ import annotations

import pytest
from damaged import survives
from watcher import WATCHER

from cprm_gym.architecture.cprm import cprm_from_json, cprm_to_json


@pytest.mark.parametrize(("count", "seed"), [(200, 1), pytest.param(100_000, 2, marks=pytest.mark.slow)])
def test_damaged_cprms_are_refused_or_read(count, seed):
    refused, taken = survives(cprm_from_json, (cprm_to_json(WATCHER),), count, seed)
    assert refused > count / 4
    assert taken > count / 50
