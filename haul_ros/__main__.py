"""``python -m haul_ros`` is the command ``haul``."""

import sys

from haul_ros.cli.main import main

sys.exit(main())
