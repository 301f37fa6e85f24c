"""Entry point ``train_node``: the process of the live train, with its exit status."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from haul_ros.ending import no_interrupt_lost
from haul_ros.errors import HaulError
from haul_ros.ros.errors import require_ros
from haul_ros.ros.signals import ending_signals


def main(args: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT, SIGTERM or SIGHUP; ``args`` without the program's name, None: those of the process.

    Returns the exit status: 0 ended as asked, by any of these signals, which launch and process managers take for a
    clean end; 1 failed while running, 2 the user's mistake. ``-h`` or ``--help`` prints what there is to ask for, 0.
    """
    argv = sys.argv if args is None else ["train_node", *args]
    with ending_signals() as signals, no_interrupt_lost():
        try:
            # What takes time to be imported is so here, where a signal ends it cleanly
            from haul_ros.ros.usage import asks_for_help, usage

            if asks_for_help(argv[1:]):
                print(usage())
                return 0
            require_ros()
            from haul_ros.ros.train_node import run_node  # needs rclpy

            return 0 if signals.taken else run_node(argv, signals)
        except HaulError as error:
            print(f"train_node: {error}", file=sys.stderr)
            return 2
        except (KeyboardInterrupt, Exception) as error:
            # While it starts a signal interrupts anything, and what is interrupted may fail in its own way
            if signals.interrupted_start or isinstance(error, KeyboardInterrupt):
                return 0
            raise


if __name__ == "__main__":
    sys.exit(main())
