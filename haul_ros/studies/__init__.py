"""Many runs at once: the paper's studies and free parameter sweeps, their tables, figures and findings."""
