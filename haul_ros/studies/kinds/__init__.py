"""What kinds of studies there are: how their cases are computed, judged and drawn, each in a module of its own."""
