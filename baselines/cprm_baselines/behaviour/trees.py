"""Behaviour trees of py_trees: leaves that ask for a condition, let a skill work or send a command; one tree a world."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from cprm_gym.errors import ControllerError

from .scene import Scene
from .skill import Mask
from .worldwise import Moment

try:
    import py_trees
    from py_trees.behaviour import Behaviour
    from py_trees.common import Status
except ImportError as error:  # pragma: no cover - told when a tree is asked for
    raise ControllerError("behaviour trees need py_trees: pip install 'cprm-gym[trees]'") from error


class Leaf(Behaviour):
    """A leaf that knows its world.

    `tick` and `stop` are the library's, less the texts that it makes for its log at every step, whether or not anybody reads them: they
    took a fifth of the time of a tree.
    """

    def __init__(self, name: str, moment: Moment, world: int) -> None:
        super().__init__(name)
        self.moment, self.world = moment, world

    def tick(self) -> Iterator[Behaviour]:
        """One cycle."""
        if self.status is not Status.RUNNING:
            self.initialise()
        status = self.update()
        if status is not Status.RUNNING:
            self.stop(status)
        self.status = status
        yield self

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """It has ended, or something else goes first."""
        self.terminate(new_status)
        self.status = new_status
        self.iterator = self.tick()


class Holds(Leaf):
    """SUCCESS where a condition holds, else FAILURE."""

    def update(self) -> Status:
        """Ask."""
        return Status.SUCCESS if self.moment.holds(self.name, self.world) else Status.FAILURE


class Does(Leaf):
    """Lets a skill work: RUNNING, SUCCESS when it ends as it was meant to, FAILURE when it ends otherwise."""

    def initialise(self) -> None:
        """It begins."""
        self._fresh = True
        for flag in self.raises:
            self.moment.flag(flag, self.world, 1.0)

    def __init__(self, name: str, moment: Moment, world: int, raises: tuple[str, ...] = ()) -> None:
        super().__init__(name, moment, world)
        self.raises = raises

    def update(self) -> Status:
        """One cycle."""
        outcome = self.moment.run(self.name, self.world, self._fresh)
        self._fresh = False
        if not outcome:
            return Status.RUNNING
        return Status.SUCCESS if outcome == self.moment.scene.skills[self.name].outcomes[0] else Status.FAILURE

    def terminate(self, new_status: Status) -> None:
        """It has ended, or something else goes first."""
        for flag in self.raises:
            self.moment.flag(flag, self.world, 0.0)


class Keeps(Leaf):
    """Sends a command that is no skill in every cycle, or does nothing: always RUNNING."""

    def update(self) -> Status:
        """One cycle."""
        if self.name != "nothing":
            self.moment.order(self.name, self.world)
        return Status.RUNNING


class Lasts(Leaf):
    """SUCCESS where a condition has held for so many cycles, asked in each, else FAILURE."""

    def __init__(self, name: str, moment: Moment, world: int, cycles: int) -> None:
        super().__init__(name, moment, world)
        self.cycles, self._held = cycles, -1

    def update(self) -> Status:
        """Ask."""
        self._held = self._held + 1 if self.moment.holds(self.name, self.world) else -1
        return Status.SUCCESS if self._held >= self.cycles else Status.FAILURE


class Waits(Leaf):
    """RUNNING for so many cycles, then SUCCESS."""

    def __init__(self, name: str, moment: Moment, world: int, cycles: int) -> None:
        super().__init__(name, moment, world)
        self.cycles = cycles

    def initialise(self) -> None:
        """It begins."""
        self._waited = 0

    def update(self) -> Status:
        """One cycle."""
        self._waited += 1
        return Status.RUNNING if self._waited <= self.cycles else Status.SUCCESS


class Sequence(py_trees.composites.Sequence):
    """The library's, whose end is not written into its log, as that of a `Leaf` is not."""

    def stop(self, new_status: Status = Status.INVALID) -> None:
        """It has ended, or something else goes first."""
        py_trees.composites.Composite.stop(self, new_status)


class Forever(py_trees.decorators.Decorator):
    """The child, begun again in the same cycle when it has ended: a cycle without a command costs the ball."""

    again = 3
    """Times in one cycle that it is begun at most."""

    def tick(self) -> Iterator[Behaviour]:
        """Until the child needs another cycle."""
        if self.status != Status.RUNNING:
            self.initialise()
        for _ in range(self.again):
            yield from self.decorated.tick()
            if self.decorated.status == Status.RUNNING:
                break
        self.status = Status.RUNNING
        yield self

    def update(self) -> Status:
        """It never ends."""
        return Status.RUNNING


class Leaves:
    """Makes the nodes of one world's tree, in the words of its users."""

    def __init__(self, moment: Moment, world: int) -> None:
        self._moment, self._world = moment, world

    def holds(self, text: str) -> Behaviour:
        """A condition over the scene's quantities."""
        return Holds(text, self._moment, self._world)

    def does(self, skill: str, *raises: str) -> Behaviour:
        """A skill; flags that are 1 while it works."""
        return Does(skill, self._moment, self._world, raises)

    def keeps(self, order: str = "nothing") -> Behaviour:
        """A command that is no skill, in every cycle."""
        return Keeps(order, self._moment, self._world)

    def lasts(self, text: str, cycles: int) -> Behaviour:
        """A condition that has held for so many cycles."""
        return Lasts(text, self._moment, self._world, cycles)

    def lacks(self, child: Behaviour) -> Behaviour:
        """The opposite of the child."""
        return py_trees.decorators.Inverter("not", child)

    def waits(self, cycles: int) -> Behaviour:
        """So many cycles."""
        return Waits(f"{cycles} cycles", self._moment, self._world, cycles)

    def sequence(self, *children: Behaviour, memory: bool = True) -> Behaviour:
        """One after the other, until one fails; without memory all are asked anew in each cycle."""
        return Sequence("sequence", memory=memory, children=list(children))

    def selector(self, *children: Behaviour, memory: bool = False) -> Behaviour:
        """The first that does not fail; without memory an earlier one may take over."""
        return py_trees.composites.Selector("selector", memory=memory, children=list(children))

    def parallel(self, *children: Behaviour) -> Behaviour:
        """All at once, for good."""
        return py_trees.composites.Parallel("parallel", py_trees.common.ParallelPolicy.SuccessOnAll(synchronise=False), list(children))

    def succeeds(self, child: Behaviour) -> Behaviour:
        """The child, whose failure is as good as its success."""
        return py_trees.decorators.FailureIsSuccess("whatever", child)

    def forever(self, child: Behaviour) -> Behaviour:
        """The child, begun again whenever it has ended."""
        return Forever("forever", child)


Grow = Callable[[Leaves], Any]


class Trees:
    """One tree for each world, ticked once a cycle.

    Parameters
    ----------
    scene : Scene
    grow : callable
        Makes the tree of one world.
    """

    def __init__(self, scene: Scene, grow: Grow) -> None:
        self._moment, self._grow = Moment(scene), grow

    @property
    def nodes(self) -> list[str]:
        """Names of the nodes of one tree."""
        return [node.name for node in self._grow(Leaves(self._moment, 0)).iterate()]

    def begin(self, worlds: int, seed: int) -> None:
        """New trees."""
        self._trees = [self._grow(Leaves(self._moment, world)) for world in range(worlds)]

    def restart(self, worlds: Mask) -> None:
        """Trees of some worlds at their beginning."""
        for world in worlds.nonzero()[0]:
            self._trees[world].stop(Status.INVALID)

    def decide(self, scene: Scene) -> None:
        """One tick of each."""
        self._moment.open()
        for tree in self._trees:
            tree.tick_once()
        self._moment.close()
