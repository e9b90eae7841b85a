"""The program `radgrad`, as the wheel installs it."""

import signal
import sys

from . import _radgrad


def main() -> int:
    """Run the program with the arguments of this process, and return its exit status."""
    # Python would hear Ctrl-C only once the program is done.
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if hasattr(signal, "SIGPIPE"):
        signal.signal(signal.SIGPIPE, signal.SIG_IGN)
    return _radgrad.program(["radgrad", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
