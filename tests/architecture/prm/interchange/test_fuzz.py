"""The readers of models and nets take a hundred thousand damaged files each without an error that is not ours."""

from __future__ import annotations

import pytest
from ball_world import scene
from bif_texts import CHILD, DOG
from damaged import survives
from every_part import everything

from cprm_gym.architecture.prm.interchange.bif import from_bif, to_bif
from cprm_gym.architecture.prm.interchange.json import model_from_json, model_to_json, world_from_json, world_to_json

BIF = (to_bif(scene(2, 0).ground(first=True)), CHILD, DOG)
MODELS = (model_to_json(everything()),)


@pytest.mark.parametrize(("count", "seed"), [(1500, 1), pytest.param(100_000, 2, marks=pytest.mark.slow)])
def test_damaged_bif_is_refused_or_read(count, seed):
    refused, taken = survives(from_bif, BIF, count, seed)
    assert refused > count / 4
    assert taken > count / 50


@pytest.mark.parametrize(("count", "seed"), [(400, 3), pytest.param(100_000, 4, marks=pytest.mark.slow)])
def test_damaged_models_are_refused_or_read(count, seed):
    refused, taken = survives(model_from_json, MODELS, count, seed)
    assert refused > count / 4
    assert taken > count / 50


@pytest.mark.parametrize(("count", "seed"), [(200, 5), pytest.param(20_000, 6, marks=pytest.mark.slow)])
def test_damaged_worlds_are_refused_or_read(count, seed):
    refused, taken = survives(world_from_json, (world_to_json(scene(2, 1)),), count, seed)
    assert refused > count / 4
    assert taken > count / 50
