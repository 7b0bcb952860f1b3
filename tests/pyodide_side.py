"""What Pyodide runs for `test_pyodide.py`: facts, a film, and the tests of model and collision."""

import json
import os
import sys
from importlib.machinery import ModuleSpec
from importlib.util import module_from_spec
from pathlib import Path

import numpy as np
import PIL
import pyodide_facts
import pytest

from pymunk_dragon import render

TESTS = Path("/repository/tests")
RESULTS = Path("/results")

# Files of tests of the model and of collisions.
FILES = "chain", "collision", "curve_kinds", "dragon", "first_contact", "march", "scenario"
# They parse or free what has thousands of levels: that ends the runtime, whose stack is short.
TOO_DEEP = {
    "test_curves_nest_as_deep_as_python_can_evaluate_them",
    "test_files_that_are_no_scenario_are_refused",
}
# Each takes more than 0.3 s here. They run where PYODIDE_TESTS is "all".
LONG = {
    "test_a_curve_is_marched_to_its_end_and_no_further",
    "test_a_handle_pushed_past_the_begin_of_the_curve_and_drawn_on_again_is_lost",
    "test_a_head_bench_longer_than_the_turn_is_wide_jackknifes_and_goes_on",
    "test_answer_is_a_value_from_which_a_run_gets_its_contact",
    "test_bound_on_the_bends_is_above_all_of_them_and_not_far_above",
    "test_contact_of_four_milliseconds_is_found_though_a_scan_misses_it",
    "test_dragon_of_another_size_or_speed_does_the_same_at_its_scale",
    "test_every_handle_is_where_the_oracle_has_it",
    "test_excess_of_a_long_dragon_of_equal_benches_is_as_documented",
    "test_first_time_and_handle_without_a_place_are_named",
    "test_handle_is_pushed_back_and_motion_ends_for_good_where_the_closed_form_has_them",
    "test_handles_in_the_u_turn_are_where_many_digits_have_them",
    "test_impossible_times_and_settings_are_refused_by_name",
    "test_march_past_the_last_place_is_unreachable_there",
    "test_march_without_a_contact_is_clear_until_the_end",
    "test_no_digit_depends_on_earlier_calls",
    "test_no_overlap_is_seen_before_the_first_contact_on_random_paths",
    "test_nothing_touches_before_the_answer_and_every_near_miss_is_told",
    "test_path_is_the_spline_to_the_last_digits",
    "test_points_are_right_to_8_last_digits_of_the_largest_coordinate",
    "test_random_paths_are_followed_to_where_small_steps_end",
    "test_ranges_near_the_centre_of_a_spiral_contain_a_handle_that_reverses_there",
    "test_scan_agrees_with_the_certified_answer_and_knows_the_other_endings",
    "test_states_do_not_depend_on_the_order_of_questions",
    "test_ten_thousand_short_benches_are_answered_in_seconds",
    "test_the_end_of_a_curve_is_reached_whatever_rounding_does",
    "test_the_first_contact_is_at_the_same_place_however_fast_the_head_goes",
    "test_the_next_handle_is_the_nearest_along_the_path_that_a_scan_sees",
}
ALL = os.environ["PYODIDE_TESTS"] == "all"
# Random examples of a property, where there are a hundred in the profile of all tests.
EXAMPLES = 100 if ALL else 5
# Points of the longest path of which `spline` has a matrix.
MOST_POINTS = 500


class Selection:
    """The plugin of pytest that selects tests, and notes how many ended in which way."""

    def __init__(self):
        self.counts = {"passed": 0, "failed": 0, "skipped": 0}

    @pytest.hookimpl(trylast=True)
    def pytest_configure(self):
        # Pytest loads the plugin of hypothesis before anything else does.
        import hypothesis

        profile = hypothesis.settings.get_profile("house")
        hypothesis.settings.register_profile("pyodide", profile, max_examples=EXAMPLES)
        hypothesis.settings.load_profile("pyodide")

    def pytest_collection_modifyitems(self, items):
        left_out = TOO_DEEP if ALL else TOO_DEEP | LONG
        items[:] = [item for item in items if item.originalname not in left_out]

    def pytest_runtest_logreport(self, report):
        if report.when == "call" or report.outcome != "passed":
            self.counts[report.outcome] += 1


def stand_in(name, **content):
    """Let `import name` give a module with `content` that skips the tests which use any more."""

    def use(attribute):
        if attribute.startswith("__"):
            raise AttributeError(attribute)
        return lambda *_, **__: pytest.skip(f"needs {name}")

    module = sys.modules[name] = module_from_spec(ModuleSpec(name, None))
    vars(module).update(content, __getattr__=use)


class Spline:
    """SciPy's `CubicSpline(x, y)`: its coefficients `c`, and its values and derivatives."""

    def __init__(self, x, y):
        self.x = x
        n = len(x)
        if n > MOST_POINTS:
            pytest.skip("needs scipy")
        h = np.diff(x)
        slopes = np.diff(y) / h

        # The second derivatives: slopes are continuous, and at the points beside the ends also the
        # third derivative.
        matrix = np.zeros((n, n))
        right = np.zeros_like(y)
        for i in range(1, n - 1):
            matrix[i, i - 1 : i + 2] = h[i - 1], 2 * (h[i - 1] + h[i]), h[i]
            right[i] = 6 * (slopes[i] - slopes[i - 1])
        matrix[0, :3] = h[1], -h[0] - h[1], h[0]
        matrix[-1, -3:] = h[-1], -h[-1] - h[-2], h[-2]
        second = np.linalg.solve(matrix, right)

        first = slopes - h * (2 * second[:-1] + second[1:]) / 6
        third = np.diff(second) / h
        self.c = np.array([third / 6, second[:-1] / 2, first, y[:-1]])

    def __call__(self, at, order=0):
        piece = np.clip(np.searchsorted(self.x, at, side="right") - 1, 0, len(self.x) - 2)
        found = self.c[:, piece]
        for _ in range(order):
            found = found[:-1] * np.arange(len(found) - 1, 0, -1)[:, None]
        return np.polyval(found, at - self.x[piece])


def tests():
    """Run the tests: pytest's exit code, and how many ended in which way."""
    stand_in("scipy")
    stand_in("scipy.interpolate", CubicSpline=Spline)
    stand_in("shapely")
    stand_in("playwright")
    stand_in("playwright.sync_api")
    selection = Selection()
    files = [str(TESTS / f"test_{name}.py") for name in FILES]
    # Explanations of failures take longer than many a test.
    options = ["-q", "-rs", "--assert=plain", "-p", "no:cacheprovider", "-m", "not thorough"]
    code = pytest.main([*files, *options], [selection])
    return {"code": int(code), **selection.counts}


def write(name, content):
    (RESULTS / f"{name}.json").write_text(json.dumps(content))


write("contact", pyodide_facts.contact())
run = pyodide_facts.late_run()
run.save(RESULTS / "late.npz")
render(run, RESULTS / "late.gif")
write("pillow", PIL.__version__)
write("scenes", pyodide_facts.scenes())
write("tests", tests())
