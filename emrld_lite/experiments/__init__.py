"""Experiments: made, stored, summed up and drawn; the algorithm itself stands one folder up.

Reads in the order machine, budget, runs, checkpoints, evaluation, grid, elsewhere, lottery,
cluster, sweep, results, studies, intervals, textbook, robot_study, plotting, robot_figures,
paper_figures, reports, bench, commands.
"""
