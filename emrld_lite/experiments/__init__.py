"""Experiments: made, stored, summed up and drawn; the algorithm itself stands one folder up.

Reads in the order machine, budget, runs, checkpoints, evaluation, grid, elsewhere, lottery,
cluster, sweep, results, studies, intervals, textbook, robot_driving, robot_study, plotting, panels,
robot_figures, drift_figures, study_figures, paper_figures, reports, bench, physics_bench, commands.
"""
