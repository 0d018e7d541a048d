"""Ground nets in files and programs of others."""

from __future__ import annotations

import random
import time
import tracemalloc

import numpy as np
import pytest
from ball_world import scene
from bif_texts import CHILD, DOG
from cases import load, names, static_slice
from flat import marginal

from cprm_gym.architecture.prm.grounding.grounding import GroundCPD, GroundSlice, GroundVariable, unroll
from cprm_gym.architecture.prm.interchange.bif import from_bif, load_bif, plain_names, save_bif, to_bif
from cprm_gym.architecture.prm.interchange.pgmpy import from_pgmpy, to_pgmpy
from cprm_gym.errors import CprmError, FormatError, ModelError


def same(a: GroundSlice, b: GroundSlice) -> None:
    """Equal names, states, bins, parents and tables."""
    assert set(a.variables) == set(b.variables)
    assert set(a.given) == set(b.given)
    for name, v in a.variables.items():
        w = b.variables[name]
        kept = ("states", "circular", "class_name", "object_name", "attribute", "clip", "unit")
        assert [getattr(v, k) for k in kept] == [getattr(w, k) for k in kept]
        assert (v.edges is None and w.edges is None) or np.array_equal(v.edges, w.edges)
    for name, cpd in a.by_child.items():
        assert cpd.parents == b.by_child[name].parents
        assert np.array_equal(cpd.table, b.by_child[name].table)


@pytest.fixture(scope="module")
def two_slices() -> GroundSlice:
    world = scene(4, 1)
    return unroll([world.ground(first=True), world.ground(["attended(o1)", "possesses(o1,ball)"], entering=["possesses(o1,ball)"])])


def test_a_net_written_as_bif_and_read_back_is_the_same(two_slices, tmp_path):
    same(two_slices, from_bif(to_bif(two_slices)))
    save_bif(two_slices, tmp_path / "net.bif")
    same(two_slices, load_bif(tmp_path / "net.bif"))


@pytest.mark.parametrize("name", names("static"))
def test_recorded_nets_survive_bif(name):
    net = static_slice(load(name))
    same(net, from_bif(to_bif(net, name)))


def test_pgmpy_reads_our_bif_as_the_same_distribution():
    from pgmpy.readwrite import BIFReader

    net = static_slice(load("s11"))
    read = from_pgmpy(BIFReader(string=to_bif(net)).get_model())
    labels = dict(zip(net.variables, plain_names(net.variables)))
    for v in net.variables:
        assert np.abs(marginal(read, labels[v]) - marginal(net, v)).max() < 1e-12


def test_pyagrum_reads_our_bif_as_the_same_distribution(two_slices, tmp_path):
    gum = pytest.importorskip("pyagrum")
    path = tmp_path / "net.bif"
    save_bif(two_slices, path)
    net = gum.loadBN(str(path))
    labels = dict(zip(two_slices.variables, plain_names(two_slices.variables)))
    engine = gum.LazyPropagation(net)
    turn = {f"{labels[n]}": 2 for n in two_slices.given}
    engine.setEvidence(turn)
    for v in ("ball.dist#1", "o1.seen#1", "possesses(o1,ball).shoot#1"):
        ours = marginal(two_slices, v, dict.fromkeys(two_slices.given, 2))
        assert np.abs(engine.posterior(labels[v]).toarray() - ours).max() < 1e-6


def test_we_read_what_pgmpy_writes(tmp_path):
    from pgmpy.readwrite import BIFWriter

    net = static_slice(load("s12"))
    path = tmp_path / "theirs.bif"
    BIFWriter(to_pgmpy(net)).write(str(path))
    read = load_bif(path)
    for v in net.variables:
        assert np.abs(marginal(read, v) - marginal(net, v)).max() < 1e-12


def test_a_net_given_to_pgmpy_and_taken_back_is_the_same():
    net = static_slice(load("s12"))
    again = from_pgmpy(to_pgmpy(net))
    for name, cpd in net.by_child.items():
        assert again.by_child[name].parents == cpd.parents
        assert np.array_equal(again.by_child[name].table, cpd.table)
        assert again.variables[name].states == net.variables[name].states


def test_pgmpy_eliminates_our_unrolled_scene_to_our_marginal():
    from pgmpy.inference import VariableElimination

    world = scene(3, 1)
    net = unroll([world.ground(first=True), world.ground(["possesses(o1,ball)"], entering=["possesses(o1,ball)"])])
    evidence = dict.fromkeys(net.given, 2) | {"ball.seen#1": 1, "ball.obs_dist#1": 2, "o1.obs_dist#1": 1, "o1.seen#1": 1}
    named = {n: net.variables[n].states[k] for n, k in evidence.items()}
    answer = VariableElimination(to_pgmpy(net)).query(["ball.dist#1"], named, show_progress=False)
    assert np.abs(answer.values - marginal(net, "ball.dist#1", evidence)).max() < 1e-12


def test_time_must_be_unrolled_before_export():
    ground = scene(3, 0).ground()
    for export in (to_bif, to_pgmpy):
        with pytest.raises(ModelError, match=r"'ball.dist' has the parent 'ball.dist' in another slice; unroll"):
            export(ground)


FOREIGN = """
// a comment
network unknown { property software "x" ; }
variable rain { type discrete [ 2 ] { Asy/Patch, <5 }; property position = (10, 20) ; }
variable wet { type discrete[2]{ yes, no }; }
probability ( rain ) { table 0.3333, 0.6666; }
/* another
   comment */
probability ( wet | rain ) {
  default 0.5, 0.5;
  (<5) 0.1, 0.9;
}
"""


def test_foreign_files_with_odd_states_comments_defaults_and_rounded_rows_are_read():
    net = from_bif(FOREIGN)
    assert net.variables["rain"].states == ("Asy/Patch", "<5")
    assert net.by_child["rain"].table.tolist() == pytest.approx([1 / 3, 2 / 3], abs=1e-4)
    assert net.by_child["rain"].table.sum() == pytest.approx(1.0, abs=1e-15)
    assert net.by_child["wet"].table.tolist() == [[0.5, 0.5], [0.1, 0.9]]


def test_a_table_with_parents_has_the_child_slowest():
    text = FOREIGN.replace("default 0.5, 0.5;\n  (<5) 0.1, 0.9;", "table 0.2, 0.3, 0.8, 0.7;")
    assert from_bif(text).by_child["wet"].table.tolist() == [[0.2, 0.8], [0.3, 0.7]]


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("( wet | rain )", "( wet | rian )", r"line 9: unknown variable 'rian'. Did you mean 'rain'"),
        ("(<5) 0.1, 0.9", "(<6) 0.1, 0.9", r"line 11: probability of 'wet': 'rain' has no state '<6'"),
        ("(<5) 0.1, 0.9", "(<5) 0.1, 0.5", r"line 11: .*row \('<5',\) is not a distribution"),
        ("(<5) 0.1, 0.9", "(<5) 0.1", r"line 11: .*1 numbers for 2"),
        ("(<5) 0.1, 0.9", "(<5) a, b", r"line 11: .*numbers expected, got a b"),
        ("default 0.5, 0.5;", "", r"no row for \('Asy/Patch',\)"),
        ("[ 2 ] { Asy/Patch", "[ 3 ] { Asy/Patch", r"line 4: variable 'rain' has 2 states, announced are 3"),
        ("variable wet", "varible wet", r"line 5: .*got 'varible'. Did you mean 'variable'"),
        ("variable wet", "variable rain", r"line 5: variable 'rain' is defined twice"),
        ("probability ( rain ) { table 0.3333, 0.6666; }", "", r"variable 'rain' has no probability"),
        ("0.9;\n}", "0.9;", r"the text ends where"),
    ],
)
def test_a_mistake_in_a_file_is_named_with_its_line(old, new, message):
    assert old in FOREIGN
    with pytest.raises(FormatError, match=f"x.bif.*{message}"):
        from_bif(FOREIGN.replace(old, new, 1), "x.bif")


def test_states_may_be_comparisons_as_in_the_child_net():
    net = from_bif(CHILD)
    assert net.variables["CO2Report"].states == ("<7.5", ">=7.5")
    assert net.by_child["CO2Report"].table[2].tolist() == [0.1, 0.9]
    assert net.variables["Age"].unit == "d"
    same(net, from_bif(to_bif(net)))


def test_the_older_dialect_has_the_child_first_no_bar_and_no_commas():
    net = from_bif(DOG)
    assert net.by_child["light-on"].parents == (("family-out", 0),)
    assert net.by_child["light-on"].table.tolist() == [[0.6, 0.4], [0.05, 0.95]]
    assert net.variables["family-out"].states == ("true", "}")
    rows = DOG.replace("table 0.6 0.05 0.4 0.95 ;", '("true") 0.6 0.4 ; default 0.05 0.95 ;')
    assert np.array_equal(from_bif(rows).by_child["light-on"].table, net.by_child["light-on"].table)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (FOREIGN.replace("0.1, 0.9", "0.1, 0.9_0"), "numbers expected, got 0.9_0"),
        (FOREIGN.replace("0.1, 0.9", "0.1, nan"), "numbers expected, got nan"),
        (FOREIGN.replace("comment */", "comment"), "line 7: a comment is not closed"),
        (FOREIGN + 'variable "a', "line 13: a text is not closed"),
        (FOREIGN.replace("default 0.5, 0.5;", "default 0.5, 0.5; default 0.1, 0.9;"), "two defaults"),
        (FOREIGN.replace("( wet | rain )", "( wet | rain, rain )"), "stands twice"),
        (FOREIGN.replace("variable wet { ", "variable wet { type discrete [ 1 ] { a }; "), "two types"),
        (FOREIGN.replace("[2]{ yes, no }", "[0]{ }"), "has no states"),
    ],
)
def test_what_only_looks_like_bif_is_refused(text, message):
    with pytest.raises(FormatError, match=message):
        from_bif(text)


def test_a_small_file_cannot_ask_for_tables_that_fill_the_memory():
    """Sixty variables of twenty parents each, in 20 kB: 2.4 GB of tables before there was a limit for the whole file."""
    names = [f"v{k}" for k in range(60)]
    text = "".join(f"variable {n} {{ type discrete [ 2 ] {{ a, b }}; }}\n" for n in names)
    for k, n in enumerate(names):
        parents = f" | {', '.join(names[max(0, k - 20) : k])}" if k else ""
        text += f"probability ( {n}{parents} ) {{ default 0.5, 0.5; }}\n"
    assert len(text) < 20_000
    tracemalloc.start()
    with pytest.raises(FormatError, match="the file has more than 5000000 cells"):
        from_bif(text)
    assert tracemalloc.get_traced_memory()[1] < 150e6
    tracemalloc.stop()


@pytest.mark.parametrize("text", ["/* " * 60_000, '"' + '\\"' * 60_000, "network a { property b " + "c " * 60_000, "x" * 200_000])
def test_reading_time_grows_with_the_length_of_a_text_and_no_faster(text):
    """Each of these took time with the square of its length: a comment or a text that never ends."""
    begun = time.process_time()
    with pytest.raises(FormatError):
        from_bif(text)
    assert time.process_time() - begun < 2.0


def test_a_net_with_a_cycle_is_refused():
    text = FOREIGN.replace("probability ( rain ) { table 0.3333, 0.6666; }", "probability ( rain | wet ) { default 0.5, 0.5; }")
    with pytest.raises(FormatError, match="cycle"):
        from_bif(text)


def test_names_that_become_alike_stay_distinct():
    assert plain_names(["a.b", "a_b", "a-b", "1"]) == ["a_b_2", "a_b", "a_b_3", "s1"]
    table = np.array([0.25, 0.75])
    net = GroundSlice(
        {n: GroundVariable(n, ("0..1|x", "%7C")) for n in ("a.b", "a_b")},
        tuple(GroundCPD(n, (), table, n) for n in ("a.b", "a_b")),
    )
    same(net, from_bif(to_bif(net)))


def test_a_damaged_file_is_refused_and_never_breaks_the_reader():
    rng = random.Random(6)
    text = to_bif(scene(2, 1).ground(first=True))
    refused = 0
    for _ in range(300):
        damaged = list(text)
        for _ in range(rng.randint(1, 6)):
            at = rng.randrange(len(damaged))
            damaged[at : at + rng.randint(0, 12)] = rng.choice(['"', "{", "}", ";", "|", ",", "nan", "-1", "9e999", "\\", "²", "/*", ""])
        try:
            from_bif("".join(damaged))
        except CprmError:
            refused += 1
    assert refused > 100
