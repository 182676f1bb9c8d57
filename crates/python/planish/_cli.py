"""The command line, in this process."""

import sys

from . import _planish


def main() -> int:
    """Runs the command line with the arguments of the process; returns the exit code."""
    return _planish.main(["planish", *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
