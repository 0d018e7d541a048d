"""A server of ours that plays in a thread of its own, for tests of what joins it."""

import threading

from cprm_gym.server import Server, Settings, Transport, run_synchronously

SYNCHRONOUS = ("server::synch_mode=true", "server::coach_w_referee=true", "server::penalty_shoot_outs=false", "server::nr_extra_halfs=0")


class Field:
    """A server in a thread of its own."""

    def __init__(self, *words, run=run_synchronously, ports=(0, 0, 0), seed=0, **options):
        self.server = Server(Settings.from_words(words), seed)
        self.transport = Transport(self.server, ports=ports)
        self.thread = threading.Thread(target=run, args=(self.transport,), kwargs=options)

    def __enter__(self):
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.server.over = self.server.over or "told to end"
        self.thread.join(30)
        self.transport.close()
        assert not self.thread.is_alive()
