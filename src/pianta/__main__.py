"""The process `pianta`, also `python -m pianta`."""

from __future__ import annotations

import gc
import os
import sys

# New objects after which Python collects garbage, instead of 700: imports create many permanent objects, and scanning
# them repeatedly takes a tenth of the time of a short command (measured).
GARBAGE_THRESHOLD = 300_000
INTERRUPTED = 130  # exit code, as of shells


def main() -> None:
    """Run the command line that the process was started with, and exit."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    _open_streams()
    try:
        from pianta.cli import main as run

        run()
    except KeyboardInterrupt:
        # Outside the command itself, such as while modules are imported
        sys.exit(INTERRUPTED)
    finally:
        # The process ends here, so its last collection need not scan the remaining objects.
        gc.freeze()


def _open_streams() -> None:
    """Let output go nowhere that a shell has closed by `>&-`: the next file that is opened would be in its place."""
    for name, descriptor in (("stdin", 0), ("stdout", 1), ("stderr", 2)):
        if getattr(sys, name) is None:
            opened = os.open(os.devnull, os.O_RDWR)
            if opened != descriptor:
                os.dup2(opened, descriptor)
            setattr(sys, name, os.fdopen(descriptor, "r" if descriptor == 0 else "w"))


if __name__ == "__main__":
    main()
