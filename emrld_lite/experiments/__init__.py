"""Experiments: made, stored, summed up and drawn; the algorithm itself stands one folder up.

Reads in the order machine, runs, evaluation, grid, sweep, results, studies, intervals, plotting,
paper_figures, reports, bench.
"""
