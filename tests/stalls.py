"""Run a command whose processes are stopped and continued at random, as on a busy machine.

`python tests/stalls.py make test-all`
"""

import random
import subprocess
import sys
import time
from contextlib import suppress

import psutil

with subprocess.Popen(sys.argv[1:]) as command:
    while command.poll() is None:
        time.sleep(random.uniform(0.2, 2.0))
        with suppress(psutil.NoSuchProcess):
            if descendants := psutil.Process(command.pid).children(recursive=True):
                process = random.choice(descendants)
                process.suspend()
                time.sleep(random.uniform(0.2, 1.0))
                process.resume()
sys.exit(command.returncode)
