"""What runs and recordings tell: summaries, tables and figures."""
