"""A standing attack on the whole: what it finds is an error of this package."""
