"""Longitudinal train dynamics: the model built for the kernel, the kernel, energy. Knows no files and no clocks."""
