"""One page to look at a run: from a recording as a file of its own, or live."""
