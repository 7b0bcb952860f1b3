"""Parts of self-contained HTML pages, which load nothing from elsewhere."""

import json
import re
from base64 import b64encode
from hashlib import sha256
from importlib.resources import files
from typing import Any

from pymunk_dragon._extras import library


def asset(package: str, name: str) -> str:
    """Text of a package's file, as in `asset(__package__, "assets/page.css")`."""
    return files(package).joinpath(name).read_text("utf-8")


def substituted(template: str, **values: str) -> str:
    """A template with each {{name}} replaced by its value, which is HTML or a part of a script."""
    # All at once, so that no {{name}} within a value is replaced.
    return re.sub(r"\{\{(\w+)\}\}", lambda match: values[match[1]], template)


def embedded_json(value: Any) -> str:
    """JSON of a value for a `script` element of a page."""
    # "<" is escaped, since an HTML parser would take "</script>" or "<!--" for markup.
    made = json.dumps(value, separators=(",", ":"), allow_nan=False, ensure_ascii=False)
    return made.replace("<", "\\u003c")


def filled(package: str, template: str, **values: Any) -> str:
    """A Jinja2 template among a package's files, rendered with escaped `values`."""
    jinja2 = library("jinja2")
    loader = jinja2.FunctionLoader(lambda name: asset(package, name))
    environment = jinja2.Environment(
        loader=loader,
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return str(environment.get_template(template).render(values))


def data_address(content: bytes, media_type: str) -> str:
    """A `data:` address with the content of a file; `media_type` as in "image/png"."""
    return f"data:{media_type};base64,{b64encode(content).decode('ascii')}"


def policy(style: str, script: str) -> str:
    """Content security policy with this style, this script, and pictures in `data:` addresses."""
    return (
        f"default-src 'none'; script-src {_hashed(script)}; style-src {_hashed(style)}; "
        "img-src data:; base-uri 'none'; form-action 'none'"
    )


def _hashed(text: str) -> str:
    """Source of a policy that allows an element with this text."""
    digest = b64encode(sha256(text.encode()).digest())
    return f"'sha256-{digest.decode('ascii')}'"
