"""Size of a player's page, and time of its pictures in Chromium: `python tests/bench/bench_player.py [RUN]`.

Without a run, the page plays the exact model's, 223 benches in frames a tenth of a second apart up to the first
contact. It plays from 300 s on for five seconds, of which the first does not count, in a window of 1280 x 800. The cost
is what the page's own script takes for a picture; the rate is what came of it with everything that the browser does.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from measure import arguments, sized

sys.path.insert(0, str(Path(__file__).parents[1]))
from browser import chromium, opened

from pymunk_dragon.model.march import March
from pymunk_dragon.model.run import Run
from pymunk_dragon.player import write_player

VIEWS = {
    "whole field": "#t=300",
    "following the head": "#t=300&follow=head",
    "whole field, everything shown": "#t=300&show=curve,contacts,handles,velocities,grid,labels",
    "following the head, everything shown": "#t=300&follow=head&show=curve,contacts,handles,velocities,grid,labels",
}
# How long a view plays, and how much of it does not count, ms.
PLAYED, WARM_UP = sized((5000, 1000), (600, 200))
MEASURE = """async ([played, warmUp]) => {
  const player = await dragon;
  const request = requestAnimationFrame.bind(window);
  const costs = [], frames = [];
  window.requestAnimationFrame = (action) => request((now) => {
    const begin = performance.now();
    action(now);
    costs.push([now, performance.now() - begin]);
  });
  player.play();
  const begin = performance.now();
  await new Promise((done) => request(function record(now) {
    frames.push(now);
    if (now < begin + played) request(record);
    else done();
  }));
  player.pause();
  return {
    costs: costs.filter(([now]) => now > begin + warmUp).map(([, cost]) => cost),
    frames: frames.filter((now) => now > begin + warmUp),
  };
}"""


def main() -> None:
    """Print the table."""
    given = arguments()
    times = np.arange(*sized((0, 4125), (2990, 3050))) / 10
    run = Run.load(given[0]) if given else Run.exact(March(), times)
    with tempfile.TemporaryDirectory() as name, chromium() as browser:
        file = Path(name) / "run.html"
        begin = time.perf_counter()
        write_player(run, file)
        seconds = time.perf_counter() - begin
        print(f"{len(run.times)} frames: {file.stat().st_size / 1e6:.2f} MB, written in {seconds:.2f} s")
        with opened(browser, file.as_uri()) as found:
            shown = found.page.evaluate("dragon.then(() => performance.now())")
        print(f"shown {shown:.0f} ms after it is opened")
        print(f"{'':<38}{'ms a picture':>13}{'95 of 100':>11}{'longest':>9}{'a second':>10}")
        for view, link in VIEWS.items():
            with opened(browser, file.as_uri() + link) as found:
                measured = found.page.evaluate(MEASURE, [PLAYED, WARM_UP])
            middle, most, longest = np.percentile(measured["costs"], [50, 95, 100])
            rate = 1000 / np.mean(np.diff(measured["frames"]))
            print(f"{view:<38}{middle:>13.1f}{most:>11.1f}{longest:>9.1f}{rate:>10.1f}")


if __name__ == "__main__":
    main()
