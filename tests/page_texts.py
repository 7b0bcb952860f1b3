"""English texts of a page: those in its HTML, as texts.js finds them, and those that its scripts write."""

from __future__ import annotations

import json
import re
from html.parser import HTMLParser

UNTRANSLATED = {"script", "style", "svg", "canvas", "kbd", "code"}
VOID = {"input", "meta", "link", "br"}
LETTER = re.compile(r"[^\W\d_]")
CALL = re.compile(r"\blocalized\(\s*")
LITERAL = re.compile(r'"(?:[^"\\]|\\.)*"')


class Elements(HTMLParser):
    """Elements of a page with their source, their own text and their children; only what the body has."""

    def __init__(self, source):
        super().__init__()
        self.source, self.roots, self.open, self.attributes = source, [], [], []
        starts = [0, *(match.end() for match in re.finditer("\n", source))]
        self.position = lambda: starts[self.getpos()[0] - 1] + self.getpos()[1]
        self.feed(source)

    def handle_starttag(self, tag, attributes):
        found = dict(attributes)
        if tag != "meta":
            self.attributes += [found[name] for name in ("aria-label", "title") if found.get(name)]
        if tag in VOID:
            return
        skipped = tag in UNTRANSLATED or found.get("translate") == "no"
        begin = self.position() + len(self.get_starttag_text())
        element = {"tag": tag, "begin": begin, "text": "", "children": [], "skipped": skipped}
        (self.open[-1]["children"] if self.open else self.roots).append(element)
        self.open.append(element)

    def handle_startendtag(self, tag, attributes):
        """Nothing: only parts of drawings end themselves."""

    def handle_endtag(self, tag):
        if tag in VOID or not self.open:
            return
        element = self.open.pop()
        assert element["tag"] == tag
        element["inner"] = " ".join(self.source[element["begin"] : self.position()].split())

    def handle_data(self, data):
        if self.open:
            self.open[-1]["text"] += data


def _blocks(elements):
    for element in elements:
        if element["skipped"] or element["tag"] == "head":
            continue
        if LETTER.search(element["text"]):
            yield element["inner"]
        else:
            yield from _blocks(element["children"])


def html_texts(source):
    """Texts of the elements and attributes of a page; those with a {{placeholder}} are filled in elsewhere."""
    page = Elements(source.split("<body", 1)[1].split(">", 1)[1])
    return {text for text in [*_blocks(page.roots), *page.attributes] if LETTER.search(text) and "{{" not in text}


def script_texts(source):
    """First arguments of all calls of `localized`: literals, or sums of them."""
    found = set()
    for call in CALL.finditer(source):
        parts, here = [], call.end()
        while literal := LITERAL.match(source, here):
            parts.append(json.loads(literal[0]))
            here = literal.end()
            if plus := re.compile(r"\s*\+\s*").match(source, here):
                here = plus.end()
        assert parts, f"not a literal: {source[call.start() : call.start() + 60]}"
        found.add("".join(parts))
    return found
