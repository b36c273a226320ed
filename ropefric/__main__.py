"""`python -m ropefric`."""

import sys

from ropefric.cli.app import main

__all__: list[str] = []

if __name__ == "__main__":
    sys.exit(main())
