"""Version of the package; setup.py reads it from here, package.xml repeats it."""

__version__ = "0.1.0"
