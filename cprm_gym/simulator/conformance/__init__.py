"""Proof by replay: recorded runs of a real server, and whole matches, played again by the simulator and compared.

`runner.run` takes files of every kind and returns a `report.Report`. A recording (`recording`) is replayed as a scenario (`scenario`, with
`trainer`, `texts`, `clock` and `noisy`) or compared as a sample of chance (`statistics`, `frequencies`, `sight`, `envelope`); a game log
with its command log is replayed as a match (`match`).
"""

from .match import replay_match
from .report import Check, Mismatch, Report, Result
from .runner import files_in, replay_scenario, run

__all__ = ["Check", "Mismatch", "Report", "Result", "files_in", "replay_match", "replay_scenario", "run"]
