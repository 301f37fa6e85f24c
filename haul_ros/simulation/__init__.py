"""Runs of a train in simulation time: commands, radio, sessions, pacing."""
