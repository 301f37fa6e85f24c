"""The command line ``haul``: arguments, exit status and printing; no computation."""
