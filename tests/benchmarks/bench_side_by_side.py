"""How long episodes take by how many are played side by side: ``python tests/benchmarks/bench_side_by_side.py``."""

import time

from cprm_gym.benchmark.chapter5.conditions import DEFAULT, condition
from cprm_gym.benchmark.chapter5.players import make_player
from cprm_gym.benchmark.episodes import play_episodes

EPISODES, SEED = 1000, 0


def main() -> None:
    """Measure and print."""
    how = condition(DEFAULT)
    print("| task | player | side by side | CPU s of 1000 | cycles | us a decision |\n|---|---|---|---|---|---|")
    for name, player in (("Goalie", "cprm"), ("PassAndAdvance", "fsm")):
        task, make = how.task(name), make_player(player, how)
        play_episodes(task, make, 4, 5)  # compiles
        for slots in (50, 250, 500):
            begin = time.process_time()
            found = play_episodes(task, make, EPISODES, SEED, slots=slots)
            spent = time.process_time() - begin
            decision = 1e6 * found.seconds / found.decisions
            print(f"| {name} | {player} | {slots} | {spent:.1f} | {found.cycles.mean():.1f} | {decision:.0f} |")


if __name__ == "__main__":
    main()
