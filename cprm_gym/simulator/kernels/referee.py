"""The referee: every event is given to ten modules in the server's order (SIMULATOR.md 7.1).

Time, BallStuck, Offside, FreeKick, Touch, Catch, Foul, IllegalDefense, Keepaway, Penalty; each is served only while its bit of
``p.rules`` is set. A change of mode is itself an event, nested inside whatever is running, so later modules see the new mode.

Kernels may not call each other in a circle. Therefore ``collisions`` has a part that knows no referee (find the overlaps, register and
apply the pushes); the referee uses that part in ``referee_places`` with `note_touch`; and the driver that calls `on_touch` imports this
file. Players are numbered 0 to 21 here.
"""

from __future__ import annotations

from cprm_gym.simulator.kernels import kernel


@kernel
def on_kick(w, p, i, accel):
    """Player `i` gave the ball an acceleration of length `accel` (m / cycle^2)."""


@kernel
def on_kick_fail(w, p, i):
    """Player `i` kicked without the ball in reach, in a mode in which kicks have an effect."""


@kernel
def on_tackle(w, p, i, accel, foul):
    """Player `i` tackled the ball; `foul`: intentionally with an opponent in reach of it."""


@kernel
def on_tackle_fail(w, p, i, foul):
    """The tackle of player `i` failed within reach, or was out of reach in front."""


@kernel
def on_touch(w, p, i):
    """The ball and player `i` overlap (each pass of a collision resolution), or he caught or punched it."""


@kernel
def on_caught(w, p, i):
    """Goalie `i` caught the ball; called after the collision resolution and `on_touch`."""


@kernel
def on_punched(w, p, i):
    """Goalie `i` failed to catch the ball within the catch rectangle."""


@kernel
def on_step(w, p):
    """One simulation step is done; called in every mode but time_over."""


@kernel
def set_mode(w, p, mode):
    """Change the play mode, tell all modules, then announce it (SIMULATOR.md 7.2)."""


@kernel
def kick_off(w, p):
    """The kick-off procedure of monitor, trainer and automatic mode (SIMULATOR.md 7.3)."""


@kernel
def automatic_kick_off(w, p, players_expected):
    """After each step with ``auto_mode``: count down the waits and kick off (SIMULATOR.md 7.15)."""


@kernel
def announce(w, kind, a, b, c):
    """Record an announcement of the referee, with the time at which it is made."""
