"""Damaged and hostile files: a net or an error of ours, soon, never anything else; what is accepted is a net like any other."""

import random
import time
import warnings

import numpy as np
import pytest
from net_mutations import MARKUP, mutated_text, mutated_value
from orient_module import ORIENT, TWICE
from petri_random_nets import random_net

from cprm_gym.architecture.petri import net_from_json, net_to_json, parse_pnml, to_pnml
from cprm_gym.errors import FormatError, FormatWarning, NetError

NETS = [ORIENT, TWICE, *(random_net(np.random.default_rng(seed)) for seed in range(4))]
DIALECTS = [
    """<?xml version="1.0"?><pnml xmlns="http://www.pnml.org/version-2009/grammar/pnml"><net id="n" type="ptnet"><page id="g">
    <place id="p"><name><text>p</text></name><initialMarking><text>2</text></initialMarking></place><place id="q"/>
    <transition id="t"/><referencePlace id="r" ref="p"/><arc id="a" source="r" target="t"/>
    <arc id="b" source="t" target="q"><inscription><text>3</text></inscription></arc></page></net></pnml>""",
    """<pnml><net id="n" type="P/T net"><place id="p"><initialMarking><value>Default,2</value></initialMarking><capacity><value>4</value>
    </capacity></place><transition id="t"><timed><value>false</value></timed><rate><value>1.5</value></rate><priority><value>2</value>
    </priority></transition><arc id="a" source="p" target="t"><type value="inhibitor"/><inscription><value>Default,1</value></inscription>
    </arc></net></pnml>""",
    """<pnml><shared-place name="p" initialMarking="1"/><shared-transition name="t"/><net id="a" type="P/T net"><place id="p" name="p"
    initialMarking="1"/><transition id="t" name="t"/><arc id="x" source="p" target="t" type="normal" inscription="1" weight="2"/></net>
    <net id="b" type="P/T net"><place id="q" name="q" initialMarking="3" invariant="&lt; inf"/><transition id="t" name="t"/>
    <arc id="x" source="q" target="t" type="timed" inscription="[0,inf)"/></net></pnml>""",
]
DOCUMENTS = [*map(to_pnml, NETS), *DIALECTS]
JSON = list(map(net_to_json, NETS))
MARKS = ('"p"', "[", "{", "null", '"kind": "place"', "}", '"a": {')
SLOWEST = 5.0  # CPU s for one input; on a busy machine nothing comes near


def judge_pnml(seed):
    """Read what the seed makes; returns whether it was a net."""
    rng = random.Random(seed)
    text = mutated_text(rng, DOCUMENTS if rng.random() < 0.3 else DIALECTS, MARKUP)
    data = text if rng.random() < 0.7 else text.encode("utf-8", "surrogatepass")
    try:
        net = parse_pnml(data, rates=rng.choice(("refuse", "plain")), block=rng.random() < 0.7)
    except FormatError:
        return False
    assert parse_pnml(to_pnml(net)) == net
    return True


def judge_json(seed):
    """Read what the seed makes; returns whether it was a net."""
    rng = random.Random(seed)
    text = mutated_value(rng, JSON) if rng.random() < 0.7 else mutated_text(rng, JSON, MARKS)
    try:
        net = net_from_json(text)
    except NetError:
        return False
    assert net_from_json(net_to_json(net)) == net
    return True


def judge_all(judge, seeds):
    """How many of the seeds made nets; the first that made something else raises with its number."""
    nets = 0
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", FormatWarning)
        for seed in seeds:
            start = time.process_time()
            try:
                nets += judge(seed)
            except Exception as error:
                raise AssertionError(f"seed {seed}: {type(error).__name__}: {error}") from error
            assert time.process_time() - start < SLOWEST, f"seed {seed}"
    return nets


KEPT_PNML: tuple[int, ...] = ()
KEPT_JSON: tuple[int, ...] = ()


@pytest.mark.parametrize(("judge", "kept"), [(judge_pnml, KEPT_PNML), (judge_json, KEPT_JSON)])
def test_a_few_damaged_files_are_nets_or_refused(judge, kept):
    assert 20 < judge_all(judge, (*kept, *range(600))) < 580


@pytest.mark.slow
@pytest.mark.parametrize("part", range(4))
@pytest.mark.parametrize("judge", [judge_pnml, judge_json])
def test_many_damaged_files_are_nets_or_refused(judge, part):
    """A hundred thousand inputs for each reader, the same every time."""
    assert 100 < judge_all(judge, range(25_000 * part, 25_000 * (part + 1))) < 24_900
