"""One way to read a net from wherever it lies: JSON, PNML, an installed module."""

from __future__ import annotations

import importlib
import os
import re
from pathlib import Path
from typing import Literal

from ....errors import FormatError, NetError, did_you_mean
from ....files import read_bounded
from ..net.net import PetriNet
from . import json as json_files
from .pnml_reader import parse_pnml, pnml_names
from .pnml_tree import MAX_BYTES

_MODULE = re.compile(r"[A-Za-z_]\w*(\.[A-Za-z_]\w*)*:[A-Za-z_]\w*")


def load_net(
    source: str | os.PathLike[str] | PetriNet,
    *,
    net: str | None = None,
    rates: Literal["refuse", "plain"] = "refuse",
    imports: bool = False,
) -> PetriNet:
    """The net in a file: our JSON or PNML, whichever it holds.

    Parameters
    ----------
    source : path, str or PetriNet
        A net is returned as it is.
    net : str, optional
        The one that is wanted of a file with several: the id or name of a PNML net, the key of a JSON definition.
    rates : {"refuse", "plain"}
        Exponential rates in PNML have no meaning here: refuse them, or read the transitions without.
    imports : bool
        Also take ``package.module:NAME``, a net in an installed module. Importing a module runs its code; a name is never called.

    Raises
    ------
    FormatError
        For files that cannot be read, are larger than is read (`MAX_BYTES` of each format), or hold what is not understood; the message
        names the file and the place.

    Warns
    -----
    FormatWarning
        When something in a PNML file was ignored that may mean something to another tool.
    """
    if isinstance(source, PetriNet):
        return source
    if rates not in ("refuse", "plain"):
        raise FormatError(f"rates={rates!r}: allowed are 'refuse' and 'plain'")
    name = os.fspath(source)
    if _MODULE.fullmatch(name) and not Path(name).is_file():
        if not imports:
            raise FormatError(f"no file {name!r}; nets in modules are read with imports=True, which runs the module's code")
        if net is not None:
            raise FormatError(f"{name} is one net; there is no net {net!r} in it")
        return _imported(*name.split(":"))
    data, is_json = _content(name)
    if not is_json:
        return parse_pnml(data, name, net=net, rates=rates)
    try:
        return json_files.net_from_json(data.decode(), net)
    except (UnicodeDecodeError, NetError) as error:
        raise FormatError(f"{name}: {error}") from error


def net_names(source: str | os.PathLike[str]) -> tuple[str, ...]:
    """What the nets in a file are called, as `load_net` takes it."""
    name = os.fspath(source)
    data, is_json = _content(name)
    if not is_json:
        return pnml_names(data, name)
    try:
        return json_files.json_names(data.decode())
    except (UnicodeDecodeError, NetError) as error:
        raise FormatError(f"{name}: {error}") from error


def _content(name: str) -> tuple[bytes, bool]:
    """The bytes of a file, and whether they are JSON (else XML)."""
    data = read_bounded(name, MAX_BYTES)
    start = data[:1000].removeprefix(b"\xef\xbb\xbf").lstrip()[:1]
    if start in (b"{", b"["):
        return data.removeprefix(b"\xef\xbb\xbf"), True
    if start == b"<" or data[:2] in (b"\xff\xfe", b"\xfe\xff"):
        return data, False
    suffix = Path(name).suffix.lower()
    if suffix in (".json", ".pnml", ".xml", ".tapn"):
        return data, suffix == ".json"
    raise FormatError(f"{name}: neither JSON nor PNML; a net is given as a file of either")


def _imported(module: str, name: str) -> PetriNet:
    """The net called `name` in an installed module."""
    try:
        found = importlib.import_module(module)
    except ImportError as error:
        raise FormatError(f"no module {module!r}: {error}") from None
    if name not in vars(found):
        raise FormatError(f"module {module!r} has no {name!r}.{did_you_mean(name, vars(found))}")
    net = vars(found)[name]
    if not isinstance(net, PetriNet):
        raise FormatError(f"{module}:{name} is no net, it is a {type(net).__name__}")
    return net
