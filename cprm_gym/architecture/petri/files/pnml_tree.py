"""PNML (ISO/IEC 15909-2): the tree of an XML document that a stranger wrote, and the names that reading and writing share.

Entities and external references are refused (defusedxml), nothing in a file is executed, and what a document may take is bounded:
`MAX_BYTES` of text, `MAX_ELEMENTS` elements, `MAX_DEPTH` levels; time and memory are proportional to the file.
"""

from __future__ import annotations

import io
import xml.sax.handler
import xml.sax.xmlreader
from collections.abc import Iterator, Mapping
from xml.sax import SAXException, SAXParseException

from defusedxml.common import DefusedXmlException
from defusedxml.expatreader import DefusedExpatParser

from ....errors import FormatError

TOOL = "cprm_gym"
"""Our name in ``toolspecific`` elements."""
VERSION = "1"
"""Of our extensions."""
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"
PNML = "http://www.pnml.org/version-2009/grammar/pnml"
"""The namespace of the standard."""
HARMLESS = frozenset(("http://www.w3.org/XML/1998/namespace", "http://www.w3.org/2001/XMLSchema-instance"))
"""Namespaces of attributes that say nothing about a net: language and white space, where the schema lies."""

MAX_DEPTH = 100
MAX_ELEMENTS = 1_000_000
MAX_BYTES = 2**26


class Node:
    """One XML element: local name, namespace, attributes, children, text and line.

    Attributes of other namespaces have names ``{namespace}name``.
    """

    __slots__ = ("_text", "attributes", "children", "line", "namespace", "tag")

    def __init__(self, tag: str, attributes: dict[str, str], line: int, namespace: str = "") -> None:
        self.tag = tag
        self.attributes = attributes
        self.line = line
        self.namespace = namespace
        self.children: list[Node] = []
        self._text: list[str] = []

    @property
    def text(self) -> str:
        """What stands in it outside its children."""
        return "".join(self._text)

    def add_text(self, content: str) -> None:
        """Append to the text."""
        self._text.append(content)

    def all(self, tag: str) -> list[Node]:
        """The children of that name."""
        return [c for c in self.children if c.tag == tag]

    def first(self, tag: str) -> Node | None:
        """The first child of that name."""
        return next((c for c in self.children if c.tag == tag), None)

    def walk(self) -> Iterator[Node]:
        """It and everything in it."""
        waiting = [self]
        while waiting:
            node = waiting.pop()
            yield node
            waiting += reversed(node.children)

    def label(self) -> str:
        """The content of a PNML label: its ``<text>`` or ``<value>``, its ``value`` attribute or its own text."""
        for tag in ("text", "value"):
            inner = self.first(tag)
            if inner is not None:
                return inner.text.strip()
        return self.attributes.get("value", self.text).strip()


class _Builder(xml.sax.handler.ContentHandler):
    """Builds the tree of `Node` and remembers lines."""

    def __init__(self) -> None:
        super().__init__()
        self.root: Node | None = None
        self.stack: list[Node] = []
        self.count = 0
        self.own: frozenset[str] = frozenset()
        self.locator: xml.sax.xmlreader.Locator | None = None

    def setDocumentLocator(self, locator: xml.sax.xmlreader.Locator) -> None:
        self.locator = locator

    def startElementNS(self, name: tuple[str | None, str], qname: str | None, attrs: Mapping[tuple[str | None, str], str]) -> None:  # type: ignore[override]
        line = (self.locator.getLineNumber() if self.locator else 0) or 0
        namespace, tag = name[0] or "", name[1]
        if self.root is None:
            self.own = frozenset((namespace, PNML, ""))
        attributes = {}
        for (where, key), value in attrs.items():
            if not where or where in self.own:
                attributes[key] = value
            elif where not in HARMLESS:
                attributes[f"{{{where}}}{key}"] = value
        node = Node(tag, attributes, line, "" if namespace in self.own else namespace)
        if self.stack:
            self.stack[-1].children.append(node)
        else:
            self.root = node
        self.stack.append(node)
        self.count += 1
        if len(self.stack) > MAX_DEPTH:
            raise FormatError(f"line {line}, <{node.tag}>: elements nested more than {MAX_DEPTH} deep")
        if self.count > MAX_ELEMENTS:
            raise FormatError(f"line {line}: more than {MAX_ELEMENTS} elements")

    def endElementNS(self, name: tuple[str | None, str], qname: str | None) -> None:
        self.stack.pop()

    def characters(self, content: str) -> None:
        if self.stack and (content.strip() or self.stack[-1]._text):
            self.stack[-1].add_text(content)


def parse_xml(data: bytes | str, source: str) -> Node:
    """The tree of an XML document.

    Raises
    ------
    FormatError
        When it is not well-formed, larger or nested more deeply than is read here, or declares entities or external references.
    """
    try:
        content = data.encode() if isinstance(data, str) else data
    except UnicodeError as error:
        raise FormatError(f"{source}: not an XML document: {error}") from None
    if len(content) > MAX_BYTES:
        raise FormatError(f"{source}: {len(content):,} bytes; PNML files of up to {MAX_BYTES:,} bytes are read")
    builder = _Builder()
    parser = DefusedExpatParser(forbid_dtd=False, forbid_entities=True, forbid_external=True)
    parser.setFeature(xml.sax.handler.feature_namespaces, True)
    parser.setContentHandler(builder)
    try:
        parser.parse(io.BytesIO(content))
    except SAXParseException as error:
        raise FormatError(f"{source}, line {error.getLineNumber()}: not well-formed XML: {error.getMessage()}") from None
    except DefusedXmlException as error:
        raise FormatError(f"{source}: refused, since it declares entities or external references: {error}") from None
    except FormatError as error:
        raise FormatError(f"{source}, {error}") from None
    except (SAXException, ValueError, LookupError, UnicodeError) as error:
        raise FormatError(f"{source}: not an XML document: {error}") from None
    if builder.root is None:
        raise FormatError(f"{source}: empty document")
    return builder.root
