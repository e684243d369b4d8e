"""What scripts that measure programs share: a run with its wall time and peak memory."""
import os
import subprocess
import sys
import time


def run(name, command, allowed=(0,), stdout=subprocess.DEVNULL):
    """Runs the command and prints its wall time and peak memory. Ends the script where the exit code is another."""
    start = time.monotonic()
    process = subprocess.Popen([str(part) for part in command], stdout=stdout)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in allowed:
        sys.exit(f"{name}: exit code {process.returncode}")
    peak = usage.ru_maxrss * 1024 / 2**30
    print(f"{name:<14}{peak:8.2f} GiB {time.monotonic() - start:9.0f} s", end="", flush=True)
