"""Exercise checks, widgets and the running clock: the only modules that know they are in a classroom."""
