"""CPRMs as JSON text; what is read back is equal to what was written."""

from __future__ import annotations

import json
import os
from dataclasses import asdict

from ...errors import FormatError
from ...files import parse_json, write_atomically
from ..petri.files.json import net_from_dict, net_to_dict
from ..prm.interchange.json import model_from_json, model_to_json, read_text
from .value import CPRM, Cluster, Event, Observe

FORMAT, VERSION = "cprm_gym cprm", 1


def cprm_to_json(cprm: CPRM) -> str:
    """The CPRM as JSON text; what `cprm_from_json` reads back is equal to it."""
    data = {
        "format": FORMAT,
        "version": VERSION,
        "name": cprm.name,
        "net": net_to_dict(cprm.net),
        "model": None if cprm.model is None else json.loads(model_to_json(cprm.model)),
        "objects": dict(cprm.objects),
        "observations": [asdict(o) for o in cprm.observations],
        "clusters": [asdict(c) for c in cprm.clusters],
        "period": cprm.period,
        "references": {name: {slot: list(to) for slot, to in slots.items()} for name, slots in cprm.references.items()},
        "present": dict(cprm.present),
        "events": [{"name": e.name, "states": dict(e.states)} for e in cprm.events],
    }
    return json.dumps(data, indent=1) + "\n"


def cprm_from_json(text: str, where: str = "cprm") -> CPRM:
    """The CPRM that a JSON text holds, checked like any other; nothing in it is executed.

    Raises
    ------
    FormatError
        When the text is not such a document; `where` names it in the message.
    """
    data = parse_json(text, where)
    if not isinstance(data, dict) or data.get("format") != FORMAT:
        raise FormatError(f"{where}: not a document of the format {FORMAT!r}")
    if data.get("version") != VERSION:
        raise FormatError(f"{where}: version {data.get('version')!r} is not known; known is {VERSION}")
    try:
        return CPRM(
            name=data["name"],
            net=net_from_dict(data["net"]),
            model=None if data["model"] is None else model_from_json(json.dumps(data["model"]), f"{where}, model"),
            objects=data["objects"],
            observations=tuple(Observe(**o) for o in data["observations"]),
            clusters=tuple(Cluster(**c) for c in data["clusters"]),
            period=data["period"],
            references=data.get("references", {}),
            present=data.get("present", {}),
            events=tuple(Event(**e) for e in data.get("events", ())),
        )
    except (KeyError, TypeError, AttributeError) as error:
        raise FormatError(f"{where}: a part is missing or of the wrong kind: {error}") from None


def save_cprm(cprm: CPRM, path: str | os.PathLike[str]) -> None:
    """Write a CPRM to a file, all of it or nothing."""
    write_atomically(path, cprm_to_json(cprm))


def load_cprm(path: str | os.PathLike[str]) -> CPRM:
    """Read a CPRM from a file.

    Raises
    ------
    FormatError
        When the file cannot be read or is not a CPRM; the message names it.
    """
    return cprm_from_json(read_text(path), str(path))
