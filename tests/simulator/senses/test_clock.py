"""The phase of asynchronous seeing is found from a recording's messages."""

from senses_recordings import ROW, recording

from cprm_gym.simulator.conformance.clock import compare_late, set_asynchronous_clocks


def test_views_counts_and_phase_are_those_of_the_recorded_players():
    """sight_v17: six views in turn; with them every message comes at its moment, before and after each step."""
    recorded = recording("sight_v17")
    sim = recorded.simulator()
    sim.team_names = ("L", "R")
    set_asynchronous_clocks(sim, recorded)
    w = sim.world[0]
    for key in recorded.header["client_versions"]:
        number = (int(key[1:]) - 1) % 6
        assert (w["view_width"][ROW[key]], w["view_quality"][ROW[key]]) == (number // 2 + 1, number % 2 + 1), key
    moments = 0
    for case in recorded.records:
        for step in case["steps"]:
            w["time"] = step["T"]
            late = [row for row in compare_late(sim, step) if row[1] == "late see messages"]
            assert all(told == own for _, _, told, own in late)
            sim.advance()
            for key in recorded.header["client_versions"]:
                told = sum(text.startswith(f"(see {step['T'] + 1}") for text in step.get("msgs", {}).get(key, ()))
                assert int(w["saw"][ROW[key]] & 3).bit_count() == told, (step["i"], key)
                moments += told
    assert moments == 348


def test_synchronous_recordings_are_left_alone():
    recorded = recording("view")
    sim = recorded.simulator()
    before = sim.world.copy()
    set_asynchronous_clocks(sim, recorded)
    assert (sim.world == before).all()
