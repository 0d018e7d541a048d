"""Absorption in large chains: ``python tests/benchmarks/bench_markov.py [STATES] [family ...]``.

CPU seconds (median of three runs, kernels warm) and the peak of extra memory for a chain like a behaviour, a random one, a sheet and
a walk, of a million states by default; each also without lumping. Where stormpy is installed Storm solves the same chain in the same
run: probability of one outcome, its sound default (relative 1e-6).
"""

from __future__ import annotations

import multiprocessing
import resource
import statistics
import sys
import tempfile
import time
from importlib.util import find_spec

from cprm_gym.architecture.analysis.markov.absorption import absorption
from cprm_gym.architecture.analysis.markov.chain import MarkovChain
from cprm_gym.architecture.analysis.markov.files import chain_to_drn
from cprm_gym.architecture.analysis.markov.generators import behaviour_chain, grid_chain, random_chain, walk_chain

FAMILIES = {
    "behaviour": lambda n: behaviour_chain(max(1, n // 1000)),
    "random": random_chain,
    "grid": lambda n: grid_chain(int(n**0.5)),
    "walk": walk_chain,
}


def peak() -> float:
    """Bytes that this process ever used."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def measure(family: str, n: int, lump: bool) -> None:
    """One line: what was solved, how, in which time."""
    absorption(FAMILIES[family](2000), lump=lump)
    chain = FAMILIES[family](n)
    before, seconds = peak(), []
    for _ in range(3):
        start = time.process_time()
        found = absorption(chain, lump=lump)
        seconds.append(time.process_time() - start)
    first = found.outcomes[0]
    methods = ", ".join(f"{name} {count:,}" for name, count in found.methods.items())
    extra = (peak() - before) / chain.n
    print(
        f"{family:10} {chain.n:>9,} states  lump {lump!s:5} {statistics.median(seconds):7.2f} s  {extra:6.0f} bytes a state  "
        f"error {found.error:.0e}  {first} {found.probability(first).value:.10g}  ({methods})",
        flush=True,
    )


def storm(family: str, n: int) -> None:
    """The same by Storm."""
    import stormpy

    chain: MarkovChain = FAMILIES[family](n)
    name = next(iter(chain.outcomes))
    with tempfile.NamedTemporaryFile("w", suffix=".drn") as file:
        file.write(chain_to_drn(chain))
        file.flush()
        model = stormpy.build_model_from_drn(file.name)
    (formula,) = stormpy.parse_properties(f'P=? [F "{name}"]')
    start = time.process_time()
    found = stormpy.model_checking(model, formula)
    print(
        f"{family:10} {chain.n:>9,} states  Storm      {time.process_time() - start:7.2f} s  {name} {found[model.initial_states[0]]:.10g}",
        flush=True,
    )


def main() -> None:
    """Each measurement in a process of its own, so that its memory is its own."""
    words = sys.argv[1:]
    n = int(float(words.pop(0))) if words and words[0][0].isdigit() else 1_000_000
    context = multiprocessing.get_context("spawn")
    for family in words or FAMILIES:
        jobs = [(measure, (family, n, True)), (measure, (family, n, False))]
        if find_spec("stormpy") is not None:
            jobs.append((storm, (family, n)))
        for job, arguments in jobs:
            process = context.Process(target=job, args=arguments)
            process.start()
            process.join(600)
            if process.is_alive():
                process.kill()
                print(f"{family:10} {job.__name__}: more than 600 s", flush=True)


if __name__ == "__main__":
    main()
