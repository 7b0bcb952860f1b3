"""Run a command while its processes are stopped and continued at random, as on a machine that is busy otherwise.

`python tests/stalls.py make test-all`
"""

import random
import subprocess
import sys
import time
from contextlib import suppress

import psutil

# s for which a process is stopped, and between two stops.
STOPPED = 0.2, 1.0
BETWEEN = 0.2, 2.0


def main() -> int:
    """Run the command, print the number of stops, and return the command's exit code."""
    stops = 0
    with subprocess.Popen(sys.argv[1:]) as command:
        while command.poll() is None:
            time.sleep(random.uniform(*BETWEEN))
            with suppress(psutil.NoSuchProcess):
                descendants = psutil.Process(command.pid).children(recursive=True)
                if descendants:
                    process = random.choice(descendants)
                    process.suspend()
                    time.sleep(random.uniform(*STOPPED))
                    process.resume()
                    stops += 1
    print(f"{stops} stops")
    return command.returncode


if __name__ == "__main__":
    sys.exit(main())
