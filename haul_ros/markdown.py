"""Text for pages in Markdown."""

from __future__ import annotations


def cell(text: str) -> str:
    """Text as it stands in a cell of a table."""
    return text.replace("|", "\\|").replace("<", "&lt;")
