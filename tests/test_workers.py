"""Jobs of several processes: all results, in order if asked, whoever dies."""

import os
import socket
import sys
from importlib.util import find_spec

import pytest
from worker_jobs import dies, dies_once, raises, square

from cprm_gym.benchmark.plan import Plan
from cprm_gym.benchmark.runner import run
from cprm_gym.errors import CprmError, ModelError, ParameterError
from cprm_gym.workers import check_reachable, results

JOBS = [(k,) for k in range(12)]


@pytest.mark.parametrize("workers", [1, 3])
def test_every_job_gives_its_result(workers):
    assert sorted(results(square, JOBS, workers)) == [k * k for k in range(12)]
    assert list(results(square, JOBS, workers, ordered=True)) == [k * k for k in range(12)]
    assert list(results(square, [], workers)) == []


def test_a_worker_that_dies_costs_time_alone(tmp_path):
    found = list(results(dies_once, [(k, str(tmp_path)) for k in range(8)], 2, ordered=True))
    assert found == [k * k for k in range(8)]
    assert (tmp_path / "died").exists()


def test_workers_that_die_again_and_again_are_an_error():
    with pytest.raises(CprmError, match="ended from outside 3 times"):
        list(results(dies, JOBS[:3], 2))


def test_an_error_of_a_job_is_raised_here():
    with pytest.raises(ModelError, match="is none"):
        list(results(raises, JOBS[:3], 2))
    with pytest.raises(ParameterError, match="workers: 0 given"):
        list(results(square, JOBS, 0))


def test_who_stops_listening_ends_the_workers():
    found = results(square, JOBS * 100, 2)
    assert isinstance(next(found), int)
    found.close()


def test_ray_that_is_not_there_is_said():
    installed = find_spec("ray") is not None
    words = "ray: no cluster at 'auto'" if installed else r"pip install 'cprm-gym\[ray\]'"
    with pytest.raises(CprmError, match=words):
        list(results(square, JOBS, ray="auto"))


def test_an_address_at_which_nobody_listens_is_refused_at_once():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        for address in (f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}", "local", "auto"):
            check_reachable(address)
    for address in (f"127.0.0.1:{port}", f"ray://127.0.0.1:{port}"):
        with pytest.raises(CprmError, match=f"no cluster at '{address}'"):
            check_reachable(address)
    for address in ("", "nobody", "ray://host", "host:port", "host:0", "host:70000"):
        with pytest.raises(CprmError, match="allowed are 'local', 'auto'"):
            check_reachable(address)


@pytest.mark.filterwarnings("default")
def test_a_ray_cluster_gives_the_same(tmp_path, monkeypatch):
    pytest.importorskip("ray")
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(sys.path))  # what the tests import, the cluster's processes must find
    assert list(results(square, JOBS, ray="local", ordered=True)) == [k * k for k in range(12)]
    found = list(results(dies_once, [(k, str(tmp_path)) for k in range(6)], ray="local", ordered=True))
    assert found == [k * k for k in range(6)]
    with pytest.raises(ModelError, match="is none"):
        list(results(raises, JOBS[:2], ray="local"))
    plan = Plan(controllers=("random", "scripted"), episodes=130)
    alone = {r.block: (r.success, r.cycles, r.reward) for r in run(plan)}
    assert alone == {r.block: (r.success, r.cycles, r.reward) for r in run(plan, ray="local")}
