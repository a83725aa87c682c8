"""`python -m billiard_shot.cli ...`, the same as `billiard-shot ...`."""

import sys

from billiard_shot.cli import main

sys.exit(main())
