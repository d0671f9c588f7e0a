"""Schematic drawings, one module per idea: how the parts of an argument hang together."""
