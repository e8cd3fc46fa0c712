"""Pages for a keyboard and a narrow screen: levels of headings, places to break, focus."""

import re

SCROLLING = re.compile(
    r"<(pre|p(?=><img)|figure(?= class)"
    r'|div(?=><math| class="(?:table-wrapper|cell_output)))(?=[ >])'
)
"""Begin of an element that may be wider than a narrow page."""
NAME = re.compile(r'(?<=<span class="pre">)[^<]+')
"""Part of inline code."""


def accessible(text: str) -> str:
    """Give headings their level, long names places to break, and what scrolls the keyboard.

    Args:
        text: HTML of the theme.
    """
    text = text.replace('role="heading">', 'role="heading" aria-level="2">')
    # its own words are the name of a button
    text = text.replace(' aria-label="Toggle hidden content"', "")
    # after these characters, not within words
    text = NAME.sub(lambda name: re.sub(r"(?<=[_./=])(?=\w)", "<wbr>", name[0]), text)
    return SCROLLING.sub(r'<\1 tabindex="0"', text)


def _change(app, page, template, context, doctree):
    for part in ("body", "furo_navigation_tree"):
        context[part] = accessible(context.get(part) or "")


def setup(app):
    """Change each page after the theme."""
    app.connect("html-page-context", _change, priority=900)
    return {"parallel_read_safe": True}
