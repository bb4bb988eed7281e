"""``python -m radiosity``."""

import sys

from radiosity.cli import main

if __name__ == "__main__":
    sys.exit(main())
