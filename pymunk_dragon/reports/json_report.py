"""Report as JSON; `schema.json` describes the keys."""

from __future__ import annotations

import json
from typing import Any

from pymunk_dragon.reports.summary import Summary


def json_text(summary: Summary) -> str:
    """Summary as JSON."""
    parts = [f"{json.dumps(name)}: {_lines(value)}" for name, value in summary.to_dict().items()]
    return "{\n" + ",\n".join(parts) + "\n}\n"


def _lines(value: Any) -> str:
    """JSON with one line for each entry of a list of objects, for readability."""
    if isinstance(value, list) and value and isinstance(value[0], dict):
        return "[\n" + ",\n".join(json.dumps(item, allow_nan=False) for item in value) + "\n]"
    return json.dumps(value, allow_nan=False)
