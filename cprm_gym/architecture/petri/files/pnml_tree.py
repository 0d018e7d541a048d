"""PNML (ISO/IEC 15909-2): the tree of an XML document that a stranger wrote, and the names that reading and writing share.

Entities and external references are refused (defusedxml), nothing in a file is executed.
"""

from __future__ import annotations

import io
import xml.sax.handler
import xml.sax.xmlreader
from dataclasses import dataclass, field
from xml.sax import SAXParseException

from defusedxml.common import DefusedXmlException
from defusedxml.expatreader import DefusedExpatParser

from ....errors import FormatError

TOOL = "cprm_gym"
"""Our name in ``toolspecific`` elements."""
VERSION = "1"
"""Of our extensions."""
PTNET = "http://www.pnml.org/version-2009/grammar/ptnet"
MAX_DEPTH = 100


@dataclass
class Node:
    """One XML element: local name, attributes, children, text and line."""

    tag: str
    attributes: dict[str, str]
    line: int
    children: list[Node] = field(default_factory=list)
    text: str = ""

    def all(self, tag: str) -> list[Node]:
        """The children of that name."""
        return [c for c in self.children if c.tag == tag]

    def first(self, tag: str) -> Node | None:
        """The first child of that name."""
        return next((c for c in self.children if c.tag == tag), None)

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
        self.locator: xml.sax.xmlreader.Locator | None = None

    def setDocumentLocator(self, locator: xml.sax.xmlreader.Locator) -> None:
        self.locator = locator

    def startElement(self, name: str, attrs: xml.sax.xmlreader.AttributesImpl) -> None:
        line = (self.locator.getLineNumber() if self.locator else 0) or 0
        node = Node(name.rpartition(":")[2], {k.rpartition(":")[2]: v for k, v in attrs.items()}, line)
        if self.stack:
            self.stack[-1].children.append(node)
        else:
            self.root = node
        self.stack.append(node)
        if len(self.stack) > MAX_DEPTH:
            raise FormatError(f"line {line}, <{node.tag}>: elements nested more than {MAX_DEPTH} deep")

    def endElement(self, name: str) -> None:
        self.stack.pop()

    def characters(self, content: str) -> None:
        if self.stack:
            self.stack[-1].text += content


def parse_xml(data: bytes | str, source: str) -> Node:
    """The tree of an XML document.

    Raises
    ------
    FormatError
        When it is not well-formed, nested too deeply, or declares entities or external references.
    """
    builder = _Builder()
    parser = DefusedExpatParser(forbid_dtd=False, forbid_entities=True, forbid_external=True)
    parser.setContentHandler(builder)
    try:
        parser.parse(io.BytesIO(data.encode() if isinstance(data, str) else data))
    except SAXParseException as error:
        raise FormatError(f"{source}, line {error.getLineNumber()}: not well-formed XML: {error.getMessage()}") from None
    except DefusedXmlException as error:
        raise FormatError(f"{source}: refused, since it declares entities or external references: {error}") from None
    except FormatError as error:
        raise FormatError(f"{source}, {error}") from None
    except (ValueError, LookupError, UnicodeError) as error:
        raise FormatError(f"{source}: not an XML document: {error}") from None
    if builder.root is None:
        raise FormatError(f"{source}: empty document")
    return builder.root
