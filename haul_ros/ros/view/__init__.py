"""The live page: what a node's topics say, and a driver's desk over its topics, parameters and services."""
