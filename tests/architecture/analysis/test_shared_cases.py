"""The public models with known answers, when they are at hand beside the repository."""

import json

import pytest
from paths import SHARED

from cprm_gym.architecture.analysis.behaviour.properties import analyze_structure
from cprm_gym.architecture.petri.files.pnml_reader import read_pnml

CASES = SHARED / "cases" / "petri"
INDEX = json.loads((CASES / "index.json").read_text()) if (CASES / "index.json").is_file() else {}

pytestmark = [
    pytest.mark.skipif(not INDEX, reason="data of ../shared absent"),
    pytest.mark.filterwarnings("ignore::cprm_gym.errors.FormatWarning"),
]


def answers(file):
    """Our answers in the words of the index."""
    s = analyze_structure(read_pnml(CASES / file))
    got = {
        "states": s.states,
        "edges": s.edges,
        "max_tokens_in_place": s.max_tokens_in_place,
        "max_tokens_in_marking": s.max_tokens_in_marking,
        "deadlocks": s.deadlocks,
        "dead_transitions": len(s.dead_transitions),
        "quasi_live": s.quasi_live.holds,
        "live": s.live.holds,
        "reversible": s.reversible.holds,
        "one_safe": s.one_safe.holds,
        "sccs": s.sccs,
        "bottom_sccs": s.bottom_sccs,
    }
    if s.soundness and s.soundness.dead_transitions is not None:
        got["soundness"] = {
            "option_to_complete": s.soundness.option_to_complete.holds,
            "proper_completion": s.soundness.proper_completion.holds,
            "dead_transitions": len(s.soundness.dead_transitions),
            "sound": s.soundness.sound,
        }
    return got


def params():
    for file, known in INDEX.items():
        marks = pytest.mark.slow if known["edges"] > 5_000_000 else ()
        yield pytest.param(file, id=file, marks=marks)


@pytest.mark.parametrize("file", list(params()))
def test_public_models_give_the_recorded_answers(file):
    got = answers(file)
    known = {key: value for key, value in INDEX[file].items() if key in got}
    assert len(known) >= 3
    assert {key: got[key] for key in known} == known
