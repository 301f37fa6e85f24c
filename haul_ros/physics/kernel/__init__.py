"""Compiled kernel: functions on arrays and floats in SI units, compression positive; no files, no clocks.

One function, :func:`haul_ros.physics.kernel.advance.advance`, is called from Python; the others
are compiled into it. A step allocates nothing.
"""
