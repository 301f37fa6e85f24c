"""Scenario files: YAML in the units of the field, checked, to the SI model."""

from haul_ros.scenario.loader import load_scenario, load_scenario_text
from haul_ros.scenario.overrides import parse_override

__all__ = ["load_scenario", "load_scenario_text", "parse_override"]
