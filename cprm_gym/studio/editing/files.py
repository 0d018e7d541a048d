"""Files and drafts of an editor: read from one folder alone, written as a whole or not at all, asked about when they changed meanwhile."""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from ...architecture.petri import to_pnml
from ...architecture.petri.files.json import MAX_BYTES as JSON_BYTES
from ...architecture.petri.files.load import load_net
from ...architecture.petri.files.pnml_tree import MAX_BYTES
from ...architecture.petri.files.positions import pnml_positions
from ...errors import CprmError, FormatError
from ...files import parse_json, read_bounded, write_atomically
from .document import Document, form_of
from .python_source import python_source

FORMS = ("json", "pnml", "python")
ENDINGS = {".json": "json", ".pnml": "pnml", ".xml": "pnml", ".py": "python"}
LISTED = 500
"""Most files that are offered to be opened."""


class FileChanged(CprmError):
    """A file is not as it was when it was opened; the text says so. Writing it with `force` puts ours in its place."""


def draft_folder() -> Path:
    """Where drafts are kept: ``$XDG_STATE_HOME/cprm_gym/drafts``, else ``~/.local/state/cprm_gym/drafts``."""
    home = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(home) / "cprm_gym" / "drafts"


def stamp_of(path: Path) -> str:
    """What tells two contents of a file apart; empty where there is none."""
    try:
        return hashlib.sha256(path.read_bytes()).hexdigest()
    except OSError:
        return ""


class Files:
    """The files below one folder, and the drafts of what was not saved.

    Parameters
    ----------
    root : path
        Nothing outside this folder is read or written, but what `allow` names.
    drafts : path, optional
        Folder of the drafts; default `draft_folder`.
    """

    def __init__(self, root: Path, drafts: Path | None = None) -> None:
        self.root = root.resolve()
        self.drafts = drafts or draft_folder()
        self._allowed: set[Path] = set()

    def allow(self, path: str) -> None:
        """Let a file outside the folder be read and written: one that the command line named."""
        self._allowed.add(Path(path).resolve())

    def inside(self, path: str) -> Path:
        """The path of a file, relative ones from the root.

        Raises
        ------
        FormatError
            When it lies elsewhere.
        """
        if not isinstance(path, str) or not path.strip() or "\0" in path:
            raise FormatError(f"a file is given by its path, got {path!r:.80}")
        found = (self.root / path).resolve()
        if found not in self._allowed and self.root not in found.parents:
            raise FormatError(f"{path}: outside the folder {self.root} in which the studio was started")
        return found

    def shown(self, path: Path) -> str:
        """A path as it is shown: from the root, if it lies there."""
        return str(path.relative_to(self.root)) if self.root in path.parents else str(path)

    def listing(self, endings: tuple[str, ...] = (".json", ".pnml")) -> list[str]:
        """Files with one of these endings, those in hidden folders left out."""
        found: list[str] = []
        for folder, names, files in os.walk(self.root):
            names[:] = sorted(n for n in names if not n.startswith((".", "__")) and n not in ("node_modules",))
            found += [self.shown(Path(folder) / f) for f in sorted(files) if Path(f).suffix in endings]
            if len(found) >= LISTED or len(Path(folder).relative_to(self.root).parts) >= 4:
                names.clear()
        return found[:LISTED]

    def read(self, path: Path, net: str | None = None) -> tuple[dict[str, Any], str]:
        """The JSON form of what is in a file, and the stamp of its content.

        Raises
        ------
        CprmError
            When it cannot be read, or holds neither a net nor a model nor a CPRM.
        """
        data = read_bounded(path, MAX_BYTES)
        stamp = hashlib.sha256(data).hexdigest()
        if data[:1000].lstrip(b"\xef\xbb\xbf \t\r\n")[:1] == b"{":
            if len(data) > JSON_BYTES:
                raise FormatError(f"{path.name}: larger than the {JSON_BYTES:,} bytes that are read")
            form = parse_json(data.decode("utf-8-sig"), path.name)
            document = Document(path.name, form)
            document.value()
            return form, stamp
        found = load_net(path, net=net)
        return form_of(found, pnml_positions(data, path.name, found.name)), stamp

    def write(self, path: Path, document: Document, stamp: str, force: bool = False) -> str:
        """Write a document, in the form that the ending says; returns the new stamp.

        Parameters
        ----------
        path : path
        document : Document
        stamp : str
            Of the content that the document was made from; empty for a new file.
        force : bool
            Also over a content with another stamp.

        Raises
        ------
        FileChanged
            When the file was changed, or made, by somebody else.
        CprmError
            When the document is not valid, or the ending says no form.
        """
        form = ENDINGS.get(path.suffix)
        if form is None:
            raise FormatError(f"{path.name}: the ending says in which form it is written: {', '.join(ENDINGS)}")
        text = content(document, form)
        now = stamp_of(path)
        if now != stamp and not force:
            what = "was changed" if now and stamp else "is there already" if now else "is gone"
            raise FileChanged(f"{self.shown(path)} {what} since it was opened")
        try:
            write_atomically(path, text)
        except OSError as error:
            raise FormatError(f"{self.shown(path)}: cannot be written: {error.strerror or error}") from None
        return hashlib.sha256(text.encode()).hexdigest()

    # -- drafts ---------------------------------------------------------------------------------------------------------------------

    def _draft(self, source: str) -> Path:
        return self.drafts / (hashlib.sha256(f"{self.root}\n{source}".encode()).hexdigest()[:24] + ".json")

    def keep_draft(self, source: str, document: Document, stamp: str) -> None:
        """Keep what was not saved yet."""
        self.drafts.mkdir(parents=True, exist_ok=True)
        held = {"root": str(self.root), "source": source, "name": document.name, "stamp": stamp, "data": document.data}
        write_atomically(self._draft(source), json.dumps(held))

    def draft(self, source: str) -> tuple[dict[str, Any], str] | None:
        """The content that was not saved, and the stamp of the file it came from."""
        return self._read_draft(self._draft(source))

    def _read_draft(self, path: Path) -> tuple[dict[str, Any], str] | None:
        try:
            held = parse_json(read_bounded(path, MAX_BYTES).decode(), "draft")
            document = Document(held["name"], held["data"])
            if document.net is not None:
                document.definition()  # a net is valid, or nobody wrote this
            return held["data"], str(held["stamp"])
        except (CprmError, KeyError, TypeError, UnicodeDecodeError, AttributeError):
            return None

    def unnamed_drafts(self) -> list[str]:
        """Sources of drafts of this folder that belong to no file yet."""
        found = []
        for path in sorted(self.drafts.glob("*.json")) if self.drafts.is_dir() else ():
            try:
                held = parse_json(read_bounded(path, MAX_BYTES).decode(), "draft")
                if held["root"] == str(self.root) and held["source"].startswith("new:"):
                    found.append(held["source"])
            except (CprmError, KeyError, TypeError, UnicodeDecodeError, AttributeError):
                continue
        return found

    def forget_draft(self, source: str) -> None:
        """The draft is no longer needed."""
        self._draft(source).unlink(missing_ok=True)


def content(document: Document, form: str) -> str:
    """The text of a document's file.

    Parameters
    ----------
    document : Document
    form : {"json", "pnml", "python"}
        PNML for nets alone.

    Raises
    ------
    CprmError
        When it is not valid, or cannot be said in that form.
    """
    value = document.value()
    if form == "json":
        return document.text()
    if form == "python":
        return python_source(value)
    if form != "pnml":
        raise FormatError(f"form {form!r}: known are {', '.join(FORMS)}")
    if document.kind != "net":
        raise FormatError(f"{document.name}: only a net can be written as PNML; this is a {document.kind}")
    return to_pnml(document.definition(), document.positions)
