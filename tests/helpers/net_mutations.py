"""Net files gone wrong: texts cut, doubled, spliced and salted with hostile words, and JSON values put where they do not belong."""

import copy
import json
import random

NUMBERS = ("0", "-1", "1_0", "3.5", "1e999", "NaN", "-0", "+2", "007", "9" * 20, "9" * 5000, "٣", "0x10", "1,2", "Default,1", "")
MARKUP = (
    "<text>2</text>",
    "<value>3</value>",
    "<inscription>",
    "</inscription>",
    "<inscription><text>2</text></inscription>",
    "<type value='inhibitor'/>",
    "type='inhibitor'",
    'type="reset"',
    "weight='2'",
    "kind='x'",
    "priority='1'",
    "<page id='g'>",
    "</page>",
    "<net id='m'>",
    "</net>",
    "<z:place/>",
    "xmlns:z='http://example.org/'",
    "<toolspecific tool='cprm_gym' version='1'>",
    "</toolspecific>",
    "<delay>3</delay>",
    "<capacity><text>1</text></capacity>",
    "<referencePlace id='r' ref='p'/>",
    "<!DOCTYPE x [<!ENTITY a 'b'>]>",
    "<![CDATA[2]]>",
    "&lt;",
    "&#0;",
    "&a;",
    "<!--",
    "-->",
    "<?pi?>",
    "\x00",
    "\ufffe",
    "<shared-place name='p'/>",
    "<place id='p2'/>",
    "<transition id='t2'/>",
    "<arc id='x' source='p' target='t'/>",
    "<a>" * 120,
    "<graphics/>",
    "initialMarking='3'",
    "<initialMarking><number>3</number></initialMarking>",
    "<priority><text>-1</text></priority>",
    "<name/>",
)
VALUES = (
    None,
    True,
    False,
    0,
    -1,
    3,
    10**30,
    10**3000,
    0.5,
    1e308,
    float("nan"),
    float("inf"),
    "",
    "p",
    "a.b",
    "x" * 300,
    "if",
    "abs(",
    "min(p, 3)",
    "p + a.b",
    [],
    ["p"],
    [["p"]],
    [1],
    {},
    {"p": 1},
    {"p": {}},
    {"kind": "place"},
    {"begin": "p"},
    {"format": 1},
    "place",
    "math",
    "object",
    "orient",
    "\ud800",
)

ENTRIES = ("fuse", "ports", "sets", "tests", "delay", "servers", "answers", "where", "k", "capacity")


def mutated_text(rng: random.Random, texts: list[str], words: tuple[str, ...]) -> str:
    """One of the texts after one to six accidents."""
    text = rng.choice(texts)
    for _ in range(rng.choice((1, 1, 1, 2, 3, 6))):
        a, b = sorted(rng.randrange(len(text) + 1) for _ in range(2))
        b = min(b, a + rng.choice((1, 3, 20, 200)))
        accident = rng.randrange(8)
        if accident == 0:
            text = text[:a] + text[b:]
        elif accident == 1:
            text = text[:b] + text[a:b] + text[b:]
        elif accident == 2:
            text = text[:a] + rng.choice(words) + text[a:]
        elif accident == 3:
            text = text[:a] + rng.choice(NUMBERS) + text[b:]
        elif accident == 4:
            text = text[:a] + chr(rng.randrange(1, 256)) + text[a + 1 :]
        elif accident == 5:
            other = rng.choice(texts)
            c = rng.randrange(len(other) + 1)
            text = text[:a] + other[c : c + rng.choice((5, 50, 500))] + text[b:]
        elif accident == 6:
            digits = [i for i, c in enumerate(text) if c.isdigit()]
            if digits:
                i = rng.choice(digits)
                text = text[:i] + rng.choice(NUMBERS) + text[i + 1 :]
        else:
            tags = [i for i, c in enumerate(text) if c in "<>{}[],:"]
            if tags:
                i = rng.choice(tags)
                text = text[:i] + rng.choice(words) + text[i + rng.randrange(2) :]
    return text


def hostile(rng: random.Random) -> object:
    """A value that fits hardly anywhere."""
    return copy.deepcopy(rng.choice(VALUES))


def mutated_value(rng: random.Random, documents: list[str]) -> str:
    """One of the JSON documents with one to three of its values replaced, renamed, dropped or doubled."""
    data = json.loads(rng.choice(documents))
    for _ in range(rng.choice((1, 1, 2, 3))):
        holder, key = None, None
        node = data
        while isinstance(node, (dict, list)) and node and rng.random() < 0.85:
            holder, key = node, rng.choice(list(node)) if isinstance(node, dict) else rng.randrange(len(node))
            node = node[key]
        if holder is None:
            continue
        accident = rng.randrange(4)
        if accident == 0:
            holder[key] = hostile(rng)
        elif accident == 1 and isinstance(holder, dict):
            holder[rng.choice((f"{key}x", "name", "places", "modules", "select", "emits"))] = holder.pop(key)
        elif accident == 2:
            del holder[key]
        elif isinstance(holder, list):
            holder.append(json.loads(json.dumps(rng.choice(holder))))
        else:
            holder[rng.choice(("fuse", "ports", "sets", "tests", "delay", "servers", "answers", "where", "k", "capacity"))] = hostile(rng)
    return json.dumps(data)
