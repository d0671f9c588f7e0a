"""Where demonstrations come from: experts trained for it, what spoils their data, and copies of it.

Reads in the order expert, recipes, cloning.
"""
