"""The command line's first lines: they stand before all that takes time to load, so that Ctrl-C has an answer then too."""

from __future__ import annotations

import sys

from mavspiral.errors import STOPPED

__all__ = ["main"]


def main() -> None:
    """Loads the verbs and runs the one that is asked for."""
    try:
        from mavspiral.cli import main as run
    except KeyboardInterrupt:
        print("mavspiral: stopped", file=sys.stderr)
        sys.exit(STOPPED)
    run()


if __name__ == "__main__":
    main()
