"""A slow, obvious reachability analysis in plain Python, to hold the fast one against."""

from __future__ import annotations

from cprm_gym.architecture.petri import ObjectPlace, PetriNet, Place

Marking = tuple[int, ...]


class Oracle:
    """The reachable markings of an untimed net, its edges, and what follows from them by definition."""

    def __init__(self, net: PetriNet, most: int = 20_000) -> None:
        self.net = net
        self.places = [p for p in net.places if isinstance(p, (Place, ObjectPlace))]
        self.names = [p.name for p in self.places]
        self.capacity = {p.name: 1 if isinstance(p, ObjectPlace) else p.capacity for p in self.places}
        start = tuple(p.tokens if isinstance(p, Place) else 0 for p in self.places)
        self.edges: dict[Marking, list[tuple[str, Marking]]] = {}
        front = [start]
        self.start = start
        while front:
            marking = front.pop()
            if marking in self.edges:
                continue
            assert len(self.edges) < most
            self.edges[marking] = [(t.name, after) for t in net.transitions if (after := self.fire(t, marking)) is not None]
            front += [after for _, after in self.edges[marking]]

    def fire(self, t, marking: Marking) -> Marking | None:
        """The marking after `t`, or None if it is not enabled."""
        m = dict(zip(self.names, marking))
        if any(m[p] < w for p, w in t.inputs.items() if p in m) or any(m[p] < w for p, w in t.tests.items() if p in m):
            return None
        if any(m[p] >= w for p, w in t.inhibitors.items() if p in m):
            return None
        if any(t.tests[p] >= w for p, w in t.inhibitors.items() if p not in m and p in t.tests):
            return None
        after = dict(m)
        for p, w in t.inputs.items():
            after[p] -= w
        for p, w in t.outputs.items():
            base = m[p] if self.net.semantics.capacity == "weak" else after[p]
            if self.capacity[p] is not None and base + w > self.capacity[p]:
                return None
            after[p] += w
        after.update(t.sets)
        return tuple(after[p] for p in self.names)

    def reach(self, start: Marking) -> set[Marking]:
        """Markings reachable from `start`."""
        seen, front = {start}, [start]
        while front:
            for _, after in self.edges[front.pop()]:
                if after not in seen:
                    seen.add(after)
                    front.append(after)
        return seen

    def facts(self) -> dict[str, object]:
        """Everything that is compared."""
        reach = {m: self.reach(m) for m in self.edges}
        fires = {m: {t for n in reach[m] for t, _ in self.edges[n]} for m in self.edges}
        names = {t.name for t in self.net.transitions}
        home = set.intersection(*reach.values())
        components = {frozenset(n for n in reach[m] if m in reach[n]) for m in self.edges}
        return {
            "states": len(self.edges),
            "edges": sum(map(len, self.edges.values())),
            "deadlocks": sum(not e for e in self.edges.values()),
            "max_tokens_in_place": max(map(max, self.edges)),
            "max_tokens_in_marking": max(map(sum, self.edges)),
            "dead_transitions": names - fires[self.start],
            "live_transitions": set.intersection(*fires.values()) if names else set(),
            "reversible": self.start in home,
            "home_markings": len(home),
            "sccs": len(components),
            "bottom_sccs": sum(all(reach[m] <= c for m in c) for c in components),
        }
