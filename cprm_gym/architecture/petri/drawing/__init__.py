"""Nets as pictures: layout, SVG and DOT."""
