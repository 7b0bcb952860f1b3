"""No command line and no file makes the program fail in a way that it should not.

`make fuzz CASES=5000` runs that many cases of each kind, different ones each time; the suite runs a few, always the
same. A fault is shown with the shortest of its cases.
"""

from __future__ import annotations

import os
from collections.abc import Iterator

import command_lines
import csv_files
import hypothesis
import pytest
import run_files
import scenario_files
from harness import Case, Worker, faults
from hypothesis import strategies as st

CASES = int(os.environ.get("FUZZ_CASES", "0"))
REPEATS = 4
KINDS = {
    "command-lines": command_lines.cases(),
    "scenario-files": scenario_files.cases(),
    "csv-files": csv_files.cases(),
    "run-files": run_files.cases(),
}


@pytest.fixture(scope="module")
def worker() -> Iterator[Worker]:
    with Worker() as one:
        yield one


def found_in(worker: Worker, cases: st.SearchStrategy[Case], count: int) -> dict[str, str]:
    """Run `count` cases, no two of them the same: each fault, with the shortest case that has it."""
    found: dict[str, str] = {}
    seen: set[int] = set()
    slowest = (0.0, Case(()))
    largest = 0
    codes: dict[object, int] = {}

    @hypothesis.settings(
        # Hypothesis tries many cases again.
        max_examples=REPEATS * count,
        derandomize=not CASES,
        database=None,
        phases=[hypothesis.Phase.generate],
        suppress_health_check=list(hypothesis.HealthCheck),
    )
    @hypothesis.given(cases)
    def run(case: Case) -> None:
        nonlocal slowest, largest
        one = hash((case.arguments, *sorted(case.files.items())))
        if one in seen or len(seen) == count:
            return
        seen.add(one)
        outcome = worker.run(case)
        codes[outcome.code] = codes.get(outcome.code, 0) + 1
        slowest = max(slowest, (outcome.seconds, case), key=lambda one: one[0])
        largest = max(largest, outcome.memory)
        for fault in faults(case, outcome):
            shown = shown_in_full(case)
            if fault not in found or len(shown) < len(found[fault]):
                found[fault] = shown

    run()
    print(
        f"\n{len(seen)} different cases; exit codes {codes}; {len(found)} faults; at most {largest / 1e6:.0f} MB, ",
        end="",
    )
    print(f"{slowest[0]:.1f} s: {slowest[1].arguments!r:.200}")
    return found


def shown_in_full(case: Case) -> str:
    """What it takes to run a case again."""
    named = {name: content for name, content in case.files.items() if name in case.arguments}
    return f"{' '.join(map(repr, case.arguments))}\n    {named!r}"


@pytest.mark.parametrize("kind", KINDS)
def test_no_case_fails_in_a_way_that_it_should_not(kind, worker):
    found = found_in(worker, KINDS[kind], CASES or 12)
    assert not found, "\n".join(f"{fault}\n    {case}" for fault, case in found.items())


@pytest.mark.thorough
@pytest.mark.parametrize("kind", KINDS)
def test_no_case_of_many_fails_in_a_way_that_it_should_not(kind, worker):
    found = found_in(worker, KINDS[kind], 100)
    assert not found, "\n".join(f"{fault}\n    {case}" for fault, case in found.items())
