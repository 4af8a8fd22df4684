"""``python -m pathsim_jsbsim_blocks.cli``."""

import sys

from . import main

if __name__ == "__main__":
    sys.exit(main())
