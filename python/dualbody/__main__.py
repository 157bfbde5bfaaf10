"""The program `dualbody`: `python -m dualbody check robot.urdf`."""

from __future__ import annotations

import signal
import sys

from ._dualbody import _command


def main() -> int:
    """Runs the program with the arguments of this process and returns its exit status."""
    # A simulation ends at Ctrl-C at once: Python's own handler would wait for it to end by itself.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    return _command(["dualbody", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
