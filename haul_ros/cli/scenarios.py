"""``haul scenarios``: what is shipped."""

from __future__ import annotations

import argparse
import json

from haul_ros.resources import shipped_scenarios
from haul_ros.scenario import load_scenario


def scenarios(arguments: argparse.Namespace) -> int:
    """List the shipped scenarios with their descriptions."""
    descriptions = {name: load_scenario(name).description for name in shipped_scenarios()}
    if arguments.json:
        print(json.dumps(descriptions, indent=2))
    else:
        width = max(map(len, descriptions))
        for name, description in descriptions.items():
            print(f"{name:{width}}  {description}")
    return 0
