"""``python -m phblocks``: see :mod:`phblocks.cli`."""

import sys

from phblocks.cli import main

if __name__ == "__main__":
    sys.exit(main())
