"""The colours of the studio's page are told apart by the colour-blind, and texts stand out from their ground, in light and dark.

Colour blindness is simulated after Machado, Oliveira and Fernandes (2009), severity 1, in linear RGB; differences are CIEDE2000 (Sharma, Wu
and Dalal 2005), contrast is that of WCAG 2.2. Run as a script it prints the table: ``python tests/studio/test_colours.py``.
"""

from __future__ import annotations

import itertools
import math
import re
from pathlib import Path

import numpy as np
import pytest

CSS = Path(__file__).parents[2] / "cprm_gym" / "studio" / "static" / "css"
SIGHT = {
    "all colours": np.eye(3),
    "protanopia": np.array([[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]]),
    "deuteranopia": np.array([[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]]),
    "tritanopia": np.array([[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]]),
}
"""Who sees -> what he sees of linear RGB."""
GROUPS = {
    "players and ball": (("left", "right", "ball", "belief"), 20.0),
    "states of a net": (("net-ink", "net-enabled", "net-fired"), 20.0),
    "marks of a net": (("net-chosen", "net-problem", "net-ink"), 20.0),
    "broken and holds": (("error", "good"), 20.0),
    "curves": (tuple(f"curve-{k}" for k in range(1, 7)), 20.0),
}
"""What colours tell apart -> the colours, and how far they lie apart at least; curves have numbers at their ends, too."""
TEXTS = {
    "panel": ("ink", "soft", "main", "error", "good", "fired", "net-ink", "net-problem"),
    "back": ("ink", "soft"), "left": ("on-player",), "right": ("on-player",), "main": ("main-ink",), "chosen": ("ink",),
}  # fmt: skip
"""Ground -> the colours of texts on it."""
SHAPES = {
    "panel": ("net-enabled", "net-fired", "net-chosen", "belief", *(f"curve-{k}" for k in range(1, 7))),
    "grass": ("left", "right", "ball", "belief"),
}
"""Ground -> the colours of shapes and lines on it."""


def colours(theme):
    """Name -> the colour of a theme, as the style sheets set it."""
    found = {}
    for sheet in ("studio.css", "net.css", "curves.css"):
        text = (CSS / sheet).read_text("utf-8")
        for selector, body in re.findall(r"([^{}]+)\{([^{}]*)\}", re.sub(r"/\*.*?\*/", "", text, flags=re.S)):
            dark = 'data-theme="dark"' in selector
            if (":root" in selector or selector.strip().endswith(".netcanvas")) and (not dark or theme == "dark"):
                found.update(re.findall(r"--([\w-]+):\s*([^;]+?)\s*(?:;|$)", body))

    def value(text):
        inner = re.fullmatch(r"var\(--([\w-]+)(?:,.*)?\)", text)
        return value(found[inner[1]]) if inner else text

    return {name: rgb(value(text)) for name, text in found.items() if value(text).startswith("#")}


def rgb(text):
    """``#1c2530`` or ``#fff`` as numbers from 0 to 1."""
    digits = text[1:]
    digits = "".join(2 * d for d in digits) if len(digits) == 3 else digits
    return np.array([int(digits[i : i + 2], 16) / 255 for i in (0, 2, 4)])


def linear(colour):
    return np.where(colour <= 0.04045, colour / 12.92, ((colour + 0.055) / 1.055) ** 2.4)


def seen(colour, sight):
    """Linear RGB as somebody sees it."""
    return np.clip(SIGHT[sight] @ linear(colour), 0.0, 1.0)


def lab(colour):
    """CIELAB, D65, of linear RGB."""
    xyz = np.array([[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]) @ colour
    t = xyz / np.array([0.95047, 1.0, 1.08883])
    f = np.where(t > 216 / 24389, np.cbrt(t), (24389 / 27 * t + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def difference(one, other):
    """CIEDE2000 of two colours in CIELAB."""
    (l1, a1, b1), (l2, a2, b2) = one, other
    mean = (math.hypot(a1, b1) + math.hypot(a2, b2)) / 2
    g = 0.5 * (1 - math.sqrt(mean**7 / (mean**7 + 25.0**7)))
    a1, a2 = (1 + g) * a1, (1 + g) * a2
    c1, c2 = math.hypot(a1, b1), math.hypot(a2, b2)
    h1, h2 = (math.degrees(math.atan2(b, a)) % 360 if a or b else 0.0 for a, b in ((a1, b1), (a2, b2)))
    dh = 0.0 if c1 * c2 == 0 else (h2 - h1 + 180) % 360 - 180
    if c1 * c2 == 0:
        h = h1 + h2
    else:
        h = (h1 + h2) / 2 if abs(h1 - h2) <= 180 else ((h1 + h2 + 360) / 2 if h1 + h2 < 360 else (h1 + h2 - 360) / 2)
    dl, dc, dh = l2 - l1, c2 - c1, 2 * math.sqrt(c1 * c2) * math.sin(math.radians(dh / 2))
    lm, cm = (l1 + l2) / 2, (c1 + c2) / 2

    def cos(degrees):
        return math.cos(math.radians(degrees))

    t = 1 - 0.17 * cos(h - 30) + 0.24 * cos(2 * h) + 0.32 * cos(3 * h + 6) - 0.20 * cos(4 * h - 63)
    sl = 1 + 0.015 * (lm - 50) ** 2 / math.sqrt(20 + (lm - 50) ** 2)
    sc, sh = 1 + 0.045 * cm, 1 + 0.015 * cm * t
    turn = -math.sin(math.radians(60 * math.exp(-(((h - 275) / 25) ** 2)))) * 2 * math.sqrt(cm**7 / (cm**7 + 25.0**7))
    l, c, hue = dl / sl, dc / sc, dh / sh
    return math.sqrt(l * l + c * c + hue * hue + turn * c * hue)


def contrast(one, other):
    """Of two colours, 1 to 21."""
    low, high = sorted(float(np.array([0.2126, 0.7152, 0.0722]) @ linear(c)) for c in (one, other))
    return (high + 0.05) / (low + 0.05)


def nearest(theme, names, sight):
    """The two colours of a group that lie nearest to each other, and how far apart."""
    known = colours(theme)
    pairs = itertools.combinations(names, 2)
    return min((difference(lab(seen(known[a], sight)), lab(seen(known[b], sight))), a, b) for a, b in pairs)


THEMES = ("light", "dark")


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize("sight", SIGHT)
@pytest.mark.parametrize("group", GROUPS)
def test_colours_that_tell_things_apart_lie_apart_for_everybody(group, sight, theme):
    names, least = GROUPS[group]
    far, a, b = nearest(theme, names, sight)
    assert far >= least, f"{a} and {b}"


@pytest.mark.parametrize("theme", THEMES)
@pytest.mark.parametrize(
    ("ground", "names", "least"), [*((g, n, 4.5) for g, n in TEXTS.items()), *((g, n, 3.0) for g, n in SHAPES.items())]
)
def test_texts_and_shapes_stand_out_from_their_ground(ground, names, least, theme):
    known = colours(theme)
    for name in names:
        assert contrast(known[name], known[ground]) >= least, name


def test_the_difference_of_colours_is_that_of_the_published_pairs():
    """Pairs 1, 7, 17 and 25 of the table of Sharma, Wu and Dalal."""
    for one, other, far in (
        ((50, 2.6772, -79.7751), (50, 0, -82.7485), 2.0425),
        ((50, 0, 0), (50, -1, 2), 2.3669),
        ((50, 2.5, 0), (73, 25, -18), 27.1492),
        ((60.2574, -34.0099, 36.2677), (60.4626, -34.1751, 39.4387), 1.2644),
    ):
        assert difference(one, other) == pytest.approx(far, abs=1e-4)


def main():
    print(f"{'':18}" + "".join(f"{f'{theme}, {sight}':>22}" for theme in THEMES for sight in SIGHT))
    for group, (names, _) in GROUPS.items():
        found = [nearest(theme, names, sight) for theme in THEMES for sight in SIGHT]
        print(f"{group:18}" + "".join(f"{far:>6.1f} {f'{a[-7:]} {b[-7:]}':>15}" for far, a, b in found))


if __name__ == "__main__":
    main()
