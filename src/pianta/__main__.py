"""The process `pianta`, also `python -m pianta`."""

from __future__ import annotations

import gc

# New objects after which Python looks for garbage, in the place of 700: imports make many that stay, and looking
# through them again and again takes a tenth of a short command.
GARBAGE_THRESHOLD = 300_000


def main() -> None:
    """Run the command line that the process was started with, and exit."""
    gc.set_threshold(GARBAGE_THRESHOLD)
    from pianta.cli import main as run

    try:
        run()
    finally:
        # What is left goes with the process; the collection at its end need not look through all of it.
        gc.freeze()


if __name__ == "__main__":
    main()
