"""Build the documentation, for the Makefile: `documentation.py DIRECTORY PICTURE=ARGUMENTS...`.

The pages are made of the guides, the docstrings of the package (by pdoc), README and the other
texts of the top folder, and the commands of the pictures, which the Makefile passes:
`march.gif=render renders/march.npz` for that file of `renders/`. The pages that `make` has written
(lessons, player, report) are copied. All links are relative, and no page requests anything from a
network, until a program of a guide is run: its page then loads Pyodide from its CDN, or where
PYODIDE_RUNTIME names a folder with a copy and with its wheels, from the site.
"""

from __future__ import annotations

import inspect
import json
import os
import re
import shutil
import sys
from collections.abc import Iterable, Iterator, Mapping
from html import escape
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any
from unittest import mock

import click
from numpy.typing import ArrayLike
from pdoc import doc, render
from pdoc.render_helpers import to_html
from runnable import marked

import pymunk_dragon
from pymunk_dragon.cli import COMMANDS, command
from pymunk_dragon.errors import DragonError
from pymunk_dragon.lessons import LESSONS
from pymunk_dragon.lessons._framework.lesson import blocks
from pymunk_dragon.publish.site import write_engine
from pymunk_dragon.sessions.page import live_page
from pymunk_dragon.web.html import embedded_json

ROOT = Path(__file__).parent.parent
RENDERS = ROOT / "renders"
GUIDES = sorted(path.stem for path in RENDERS.glob("guides/*.md"))
# Texts: the file, its page and the title of the page, in the order of the sidebar; the last two
# stand at its end.
TEXTS = {
    "README.md": ("index.html", "Start"),
    "README.zh.md": ("index.zh.html", "中文"),
    **{f"renders/guides/{name}.md": (f"{name}.html", name.capitalize()) for name in GUIDES},
    "CONTRIBUTING.md": ("contributing.html", "Contributing"),
    "CHANGELOG.md": ("changelog.html", "Changes"),
}
# Headings in the sidebar, by the first page below each.
HEADINGS = {
    f"{GUIDES[0]}.html": "Guides",
    "pymunk_dragon/studies.html": "Modules",
    "names.html": "More",
}
# Pages by the addresses that texts have for the files: a guide names others without the folder.
PAGES = {name: page for file, (page, _) in TEXTS.items() for name in (file, Path(file).name)}
CITATION = "CITATION.cff"
# Modules with a page, in the order of the sidebar, and the titles of the pages.
MODULES = {
    "studies": "The contest's questions",
    "model": "Exact model",
    "model.dragon": "Dragon",
    "model.curves": "Curves",
    "model.speed": "Speeds",
    "model.march": "March",
    "model.scenario": "Scenario files",
    "model.run": "Runs",
    "model.contact": "Contact records",
    "collision": "First contact",
    "physics": "Engine",
    "dynamics": "Exact dynamics",
    "drawing": "Films",
    "drawing.figures": "Figures",
    "drawing.debug_draw": "Debug drawing",
    "player": "Player",
    "reports": "Reports",
    "sessions": "Live sessions",
    "sweeps": "Sweeps",
    "lessons": "Lessons",
    "cli": "Command line",
    "errors": "Errors",
}
# Pages of `renders/` that are copied where they exist, and their titles.
COPIES = {"lessons.html": "All lessons", "march.html": "A player", "report.html": "A report"}
# Pages that list something, and their titles.
LISTS = {"names.html": "All names", "gallery.html": "Gallery"}
PICTURES = (".gif", ".png", ".svg")
# The folder of what programs of the guides run with.
ENGINE = "engine"
# The address of a file in HTML: `src="renders/march.gif"`, `href="README.md"`.
ADDRESS = re.compile(r'\b(href|src)="([^"#:]+)')
# In the code of a text a module, a name or a member of one: `pymunk_dragon.physics`, `March`,
# `March.at`, `simulate(...)`. Not in a link.
NAME = re.compile(r"(?<!\">)<code>((\w+)(?:\.\w+)*)(\(.*?\))?</code>")
# A comment for doctest in an example.
DIRECTIVE = re.compile(r' *<span class="c1"># doctest:[^<]*</span>')
# A link within a page. pdoc makes some to members that a class has from a class without a page.
LOCAL = re.compile(r'<a href="#([^"]+)">(.*?)</a>')
# What pdoc's pages lack for keyboards and screen readers: names of links, headings that skip no
# level, focus on what scrolls. Each pattern and what stands there instead, without quotation marks,
# as in the index of the search.
ACCESSIBLE = {
    r'(<a class="headerlink" href="#([^"]+)")>': r"\1 aria-label=\2>",
    r"<(/?)h[456]\b": r"<\1h2",
    r"<(pre|table)>": r"<\1 tabindex=0>",
}
# A picture or a link with a relative address in Markdown, and the text of the link.
RELATIVE = re.compile(r"(!)?\[(?(1)[^]]*|([^]]*))\]\((?!https?:)[^)]*\)")
# The type behind `NDArray[np.float64]`.
ARRAY = re.compile(
    r"numpy\.ndarray\[tuple\[(?:typing\.)?Any, \.\.\.\], numpy\.dtype\[numpy\.(\w+)\]\]"
)
# How Python writes the annotations of parameters.
FORMAT = inspect.formatannotation
# A picture in Markdown or HTML.
SHOWN = re.compile(
    r"!\[([^]]*)\]\(renders/([^)]+)\)|<img src=\"renders/([^\"]+)\"[^>]* alt=\"([^\"]*)\""
)


def module_page(module: str) -> str:
    """Address of the page of a module of the package."""
    return f"pymunk_dragon/{module.replace('.', '/')}.html"


def names_text() -> str:
    """All public names, as Markdown."""
    lines = [
        "# All names",
        "",
        "Each is imported from `pymunk_dragon`.",
        "",
        "| name | what it is |",
        "| --- | --- |",
    ]
    for name, module in sorted(pymunk_dragon._MODULES.items(), key=lambda item: item[0].lower()):
        first = getattr(pymunk_dragon, name).__doc__.split("\n\n")[0]
        about = " ".join(first.split()).replace("|", r"\|")
        lines.append(f"| [{name}]({module_page(module)}#{name}) | {about} |")
    return "\n".join(lines)


def shown_pictures(texts: Mapping[str, str]) -> Iterator[tuple[str, str, str]]:
    """Path, caption and page of each picture in `texts`, Markdown by the address of the page."""
    for page, text in texts.items():
        for found in SHOWN.finditer(text):
            yield (found[2] or found[3]), (found[1] or found[4]), page


def gallery_text(texts: Mapping[str, str], commands: Mapping[str, str]) -> str:
    """All pictures with their captions and commands, as Markdown.

    A picture is described where a text shows it, in a docstring or in README.
    """
    captions: dict[str, tuple[str, str]] = {}
    for picture, caption, page in shown_pictures(texts):
        captions.setdefault(picture, (caption, page))

    lines = [
        "# Gallery",
        "",
        "Each picture leads to the text about it, and has its commands;"
        " where it has none, the text has its program.",
        "",
        '<div class="gallery">',
    ]
    made = [name for name in commands if name.endswith(PICTURES)]
    shown_only = [name for name in captions if name not in made]
    for picture in made + shown_only:
        caption, page = captions[picture]
        image = f'<img src="renders/{picture}" alt="" loading="lazy">'
        lines.append(f'<figure><a href="{page}">{image}{caption}</a>')
        if picture in made:
            # The commands of the runs that the picture shows, then its own.
            words = commands[picture].split()
            runs = [name for name in commands if name.endswith(".npz")]
            files = [name for name in runs if f"renders/{name}" in words] + [picture]
            shown = [f"{commands[name]} -o renders/{name}" for name in files]
            text = "\n".join(f"pymunk-dragon {each}" for each in shown)
            lines.append(f"<pre>{escape(text)}</pre>")
        lines.append("</figure>")
    return "\n".join([*lines, "</div>"])


def lessons_text() -> str:
    """What each lesson needs, takes and teaches: a table in Markdown, without LaTeX."""
    lines = [
        "| lesson | for whom, and what they know | minutes | goal |",
        "| --- | --- | --- | --- |",
    ]
    for name, lesson in LESSONS.items():
        [block] = blocks(lesson.sections()["Teacher"])
        needs, minutes, _ = re.split(r"\. (\d+) minutes: ", block.items[0])
        goal = block.items[1].removeprefix("Goal: ")
        link = f"[{name}](renders/lessons.html#{name})"
        lines.append(f"| {link} | {needs} | {minutes} | {goal[0].upper()}{goal[1:]} |")
    return re.sub(r"[$\\]", "", "\n".join(lines))


def commands_text() -> str:
    """The help of every command, as Markdown."""
    lines = ["## The commands"]
    for name in COMMANDS:
        context = click.Context(
            command(name), info_name=f"pymunk-dragon {name}", max_content_width=80
        )
        lines += ["", f"### {name}", "", "```text", command(name).get_help(context), "```"]
    return "\n".join(lines)


def with_links(page: str, text: str, members: Mapping[str, set[str]]) -> str:
    """The HTML `text` of a page, with the site's addresses, and links for names in code.

    `members` has the anchors of each module's page.
    """
    top = "../" * page.count("/")
    names = pymunk_dragon._MODULES

    def address(found: re.Match[str]) -> str:
        attribute, path = found.groups()
        path = top + PAGES[path] if path in PAGES else path.replace("renders/", top, 1)
        return f'{attribute}="{path}'

    def name(found: re.Match[str]) -> str:
        whole, first, call = found.groups()
        module = whole.removeprefix("pymunk_dragon.")
        if whole != module and module in MODULES and module_page(module) != page:
            return f'<a href="{top}{module_page(module)}">{found[0]}</a>'
        # A lower-case word in code may also be a command, as `report`, or a parameter.
        if first not in names or not (call or first != first.lower() or "_" in first):
            return found[0]
        anchor = whole if whole in members[names[first]] else first
        target = module_page(names[first])
        if target == page:
            target = ""
        return f'<a href="{top if target else ""}{target}#{anchor}">{found[0]}</a>'

    def local(found: re.Match[str]) -> str:
        return found[0] if f'id="{found[1]}"' in text else found[2]

    return ADDRESS.sub(address, NAME.sub(name, LOCAL.sub(local, DIRECTIVE.sub("", text))))


def short_annotation(annotation: object, *arguments: Any, **options: Any) -> str:
    """An annotation as in the code: `ArrayLike` and `NDArray`, not the NumPy types behind them."""
    members = FORMAT(ArrayLike).removeprefix("Union[").removesuffix("]")
    text = (
        FORMAT(annotation, *arguments, **options)
        .replace(members, "ArrayLike")
        .replace("Union[ArrayLike]", "ArrayLike")
    )
    return ARRAY.sub(r"NDArray[\1]", text)


def write(path: Path, text: str) -> None:
    """Write a page, or the index of the search."""
    path.parent.mkdir(parents=True, exist_ok=True)
    for pattern, instead in ACCESSIBLE.items():
        text = re.sub(pattern, instead, text)
    path.write_text(text, encoding="utf-8", newline="\n")


def page_titles(copied: Iterable[str]) -> dict[str, str]:
    """The titles of all pages by their addresses, in the order of the sidebar."""
    *first, contributing, changes = TEXTS.values()
    modules = {module_page(module): title for module, title in MODULES.items()}
    copies = [(page, COPIES[page]) for page in copied]
    return dict([*first, *modules.items(), *LISTS.items(), *copies, contributing, changes])


def configure(titles: Mapping[str, str]) -> None:
    """Set the options of pdoc, and what the templates of this project use."""
    version = pymunk_dragon.__version__
    render.configure(
        docformat="numpy",
        show_source=False,
        footer_text=f"pymunk_dragon {version}",
        template_directory=RENDERS / "templates",
    )
    public = {f"pymunk_dragon.{name}" for name in pymunk_dragon._MODULES.values()}
    render.env.globals.update(titles=titles, headings=HEADINGS, public=public, version=version)


def documented_modules() -> dict[str, doc.Module]:
    """The modules that have a page, by their names in `MODULES`."""
    modules = {name: doc.Module(import_module(f"pymunk_dragon.{name}")) for name in MODULES}
    # pdoc computes the docstring on first use.
    vars(modules["cli"])["docstring"] = f"{modules['cli'].docstring}\n\n{commands_text()}"
    return modules


def anchors(module: doc.Module) -> set[str]:
    """The anchors of the classes and functions of a module, and of the members of the classes."""
    members = module.flattened_own_members
    inner = [
        own for member in members if isinstance(member, doc.Class) for own in member.own_members
    ]
    return {member.qualname for member in (*members, *inner)}


def engine(directory: Path, runtime: str | None) -> str | None:
    """Write the folder with which programs run: what a page posts to its worker, as JSON."""
    try:
        site = write_engine(directory, runtime, {})
    except DragonError as error:
        click.echo(f"no program of a guide runs in its page: {error}", err=True)
        return None
    page, _ = live_page("A program", "en", "", embedded_json(site))
    (directory / "live.html").write_text(page, encoding="utf-8", newline="\n")
    return json.dumps(site)


def build(
    directory: Path,
    commands: Mapping[str, str],
    copies: Path = RENDERS,
    runtime: str | None = None,
) -> None:
    """Write the site to `directory`, which is made anew.

    `commands` has the arguments of the program that make each file of `renders/`; `copies` is the
    folder of the pages that are copied; `runtime` is a folder with a copy of Pyodide.
    """
    copied = [name for name in COPIES if (copies / name).exists()]
    titles = page_titles(copied)
    configure(titles)
    modules = documented_modules()
    members = {name: anchors(module) for name, module in modules.items()}

    texts = {
        page: (ROOT / file).read_text("utf-8").replace("](../", "](renders/")
        for file, (page, _) in TEXTS.items()
    }
    texts["teachers.html"] = texts["teachers.html"].replace(
        "`make docs` writes the table here.", lessons_text()
    )
    docstrings = {module_page(name): module.docstring for name, module in modules.items()}
    lists = {"names.html": names_text(), "gallery.html": gallery_text(docstrings | texts, commands)}

    shutil.rmtree(directory, ignore_errors=True)
    site = engine(directory / ENGINE, runtime)
    if site:
        texts |= {f"{name}.html": marked(texts[f"{name}.html"]) for name in GUIDES}
        shutil.copyfile(RENDERS / "templates" / "programs.js", directory / "programs.js")
    template = render.env.get_template("page.html.jinja2")
    for page, text in (texts | lists).items():
        language = "zh" if page.endswith(".zh.html") else "en"
        given = {"title": titles[page], "content": to_html(text), "current": page}
        whole = template.render(engine=site, **given)
        write(
            directory / page,
            with_links(page, whole.replace('lang="en"', f'lang="{language}"', 1), members),
        )

    everything = {module.modulename: module for module in modules.values()}
    # There is no setting for annotations: pdoc calls this function of Python's for those of results
    # and fields, and Python itself for those of parameters.
    formats = [
        mock.patch.object(where, "formatannotation", short_annotation) for where in (inspect, doc)
    ]
    with formats[0], formats[1]:
        for name, module in modules.items():
            page = module_page(name)
            write(
                directory / page, with_links(page, render.html_module(module, everything), members)
            )
        # pdoc searches docstrings of modules only.
        everything |= {name: doc.Module(ModuleType(name, texts[f"{name}.html"])) for name in GUIDES}
        for module in everything.values():
            # Results of a search are shown on pages in other folders, where relative addresses lead
            # nowhere.
            vars(module)["docstring"] = RELATIVE.sub(lambda found: found[2] or "", module.docstring)
        order = (RENDERS / "templates" / "search_order.js").read_text(encoding="utf-8")
        write(directory / "search.js", f"{render.search_index(everything)}\n{order}")

    (directory / "figures").mkdir()
    for source in [*(copies / name for name in copied), ROOT / CITATION]:
        shutil.copyfile(source, directory / source.name)
    for source in [*RENDERS.glob("*.*"), *RENDERS.glob("figures/*.*")]:
        if source.suffix in PICTURES:
            shutil.copyfile(source, directory / source.relative_to(RENDERS))


if __name__ == "__main__":
    build(
        Path(sys.argv[1]),
        dict(argument.split("=", 1) for argument in sys.argv[2:]),
        runtime=os.environ.get("PYODIDE_RUNTIME"),
    )
