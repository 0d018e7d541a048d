"""Jobs played by several processes of this machine, or by a Ray cluster. What a job gives does not depend on who plays it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import socket
import threading
from collections import deque
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from typing import Any

from .errors import CprmError, ParameterError

TRIES = 3
"""So often processes may end one after the other, without a result between them."""
PATIENCE = 5.0
"""Seconds to wait for an answer of a host."""
LOCAL = "local"
"""Address of a Ray cluster that is started on this machine, for this run."""


def check_workers(workers: int | None) -> None:
    """Refuse a number of workers below one; None leaves it to who plays."""
    if workers is not None and workers < 1:
        raise ParameterError(f"workers: {workers!r} given, at least 1 is needed")


def results(
    function: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], workers: int = 1, ray: str | None = None, ordered: bool = False
) -> Iterator[Any]:
    """``function(*job)`` of each job.

    A process that is killed costs time alone: what it was doing is done again by another one.

    Parameters
    ----------
    function : callable
        Of a module, so that other processes find it.
    jobs : sequence of tuple
    workers : int
        Processes; 1 plays in this process.
    ray : str, optional
        Address of a Ray cluster that plays instead (``local``: one that is started here, ``auto``: the one that runs here); `workers` then
        means nothing.
    ordered : bool
        In the order of the jobs, instead of that in which they are finished.

    Raises
    ------
    ParameterError
        For fewer workers than one.
    CprmError
        When processes end again and again, or Ray is not installed or not to be reached.
    """
    check_workers(workers)
    if ray is not None:
        done = _by_ray(function, jobs, ray)
    elif workers == 1 or len(jobs) < 2:
        for job in jobs:
            yield function(*job)
        return
    else:
        done = _here(function, jobs, min(workers, len(jobs)))
    if not ordered:
        for _, result in done:
            yield result
        return
    early: dict[int, Any] = {}
    following = 0
    for k, result in done:
        early[k] = result
        while following in early:
            yield early.pop(following)
            following += 1


def _here(function: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], workers: int) -> Iterator[tuple[int, Any]]:
    """Numbers and results of the jobs, by processes of this machine."""
    todo, deaths = deque(range(len(jobs))), 0
    while todo:
        broken = False
        # fresh processes: threads and compiled code of this one are not copied into them
        pool = ProcessPoolExecutor(workers, mp_context=multiprocessing.get_context("spawn"), initializer=_end_with_parent)
        before = set(multiprocessing.active_children())
        pending: dict[Future[Any], int] = {}
        try:
            while (todo or pending) and not broken:
                try:
                    with deaf_to_interrupts():
                        while todo and len(pending) < 2 * workers:
                            pending[pool.submit(function, *jobs[todo[0]])] = todo[0]
                            todo.popleft()
                except BrokenProcessPool:
                    broken = True
                for future in wait(pending, return_when=FIRST_COMPLETED)[0]:
                    k = pending[future]
                    try:
                        result = future.result()
                    except BrokenProcessPool:
                        broken = True
                        continue
                    del pending[future]
                    deaths = 0
                    yield k, result
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            for process in set(multiprocessing.active_children()) - before:
                process.terminate()
            raise
        finally:
            pool.shutdown()
        todo.extendleft(sorted(pending.values(), reverse=True))
        deaths += broken
        if deaths >= TRIES:
            raise CprmError(f"workers were ended from outside {TRIES} times, perhaps for want of memory: take fewer --workers")


def check_reachable(address: str) -> None:
    """Refuse an address ``host:port`` (with or without ``ray://``) at which nobody listens, instead of waiting for minutes.

    Raises
    ------
    CprmError
        Naming the address and what the network says.
    """
    if address in (LOCAL, "auto"):
        return
    host, _, port = address.removeprefix("ray://").rpartition(":")
    if not host or not port.isdigit() or not 0 < int(port) < 65536:
        raise CprmError(f"ray: address {address!r} given; allowed are 'local', 'auto', 'host:port' and 'ray://host:port'")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=PATIENCE).close()
    except OSError as error:
        raise CprmError(f"ray: no cluster at {address!r}: {error}") from None


def _by_ray(function: Callable[..., Any], jobs: Sequence[tuple[Any, ...]], address: str) -> Iterator[tuple[int, Any]]:
    """Numbers and results of the jobs, by a Ray cluster."""
    try:
        import ray
    except ImportError:
        raise CprmError("ray: it is not installed: pip install 'cprm-gym[ray]'") from None
    ours = not ray.is_initialized()
    if ours:
        check_reachable(address)
        try:
            ray.init(None if address == LOCAL else address, include_dashboard=False, log_to_driver=False, logging_level="error")
        except (ConnectionError, ValueError, RuntimeError) as error:
            raise CprmError(f"ray: no cluster at {address!r}: {str(error).splitlines()[0]}") from None
    try:
        # a process that dies is another one's job
        task = ray.remote(num_cpus=1, max_retries=TRIES)(function)
        ahead = max(2, 2 * int(ray.cluster_resources().get("CPU", 1)))
        todo = deque(range(len(jobs)))
        pending: dict[Any, int] = {}
        while todo or pending:
            while todo and len(pending) < ahead:
                k = todo.popleft()
                pending[task.remote(*jobs[k])] = k
            for reference in ray.wait(list(pending), num_returns=1)[0]:
                try:
                    result = ray.get(reference)
                except ray.exceptions.RayTaskError as error:
                    raise error.as_instanceof_cause() from None
                except ray.exceptions.RayError as error:
                    raise CprmError(f"ray: a job was given up: {str(error).splitlines()[0]}") from None
                yield pending.pop(reference), result
    finally:
        if ours:
            ray.shutdown()


def _end_with_parent() -> None:
    """In a worker: end when the process that started it does, killed or not."""
    parent = multiprocessing.parent_process()

    def follow() -> None:
        if parent is not None:
            parent.join()
            os._exit(1)

    threading.Thread(target=follow, daemon=True).start()


@contextmanager
def deaf_to_interrupts() -> Iterator[None]:
    """Processes started here leave Ctrl-C to this one, which ends them; one that comes meanwhile is met afterwards."""
    if hasattr(signal, "pthread_sigmask"):
        before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
        try:
            yield
        finally:
            signal.pthread_sigmask(signal.SIG_SETMASK, before)
        return
    if threading.current_thread() is not threading.main_thread():  # only that one may say so
        yield
        return
    previous = signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous)
