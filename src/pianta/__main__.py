"""The process `pianta`, also `python -m pianta`."""

from __future__ import annotations

import gc
import sys

# New objects after which Python collects garbage, instead of 700: imports create many permanent objects, and scanning
# them repeatedly takes a tenth of the time of a short command (measured).
GARBAGE_THRESHOLD = 300_000
INTERRUPTED = 130  # exit code, as of shells


def main() -> None:
    """Run the command line that the process was started with, and exit."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    try:
        from pianta.cli import main as run

        run()
    except KeyboardInterrupt:
        # Outside the command itself, such as while modules are imported
        sys.exit(INTERRUPTED)
    finally:
        # The process ends here, so its last collection need not scan the remaining objects.
        gc.freeze()


if __name__ == "__main__":
    main()
