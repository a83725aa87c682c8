"""`python -m billiard_shot ...`, the same as `billiard-shot ...`."""

import sys

from billiard_shot.cli import main

sys.exit(main())
