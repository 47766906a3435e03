"""Scientific claims about ecs-eco, each tested by its own script. Run a script from the root of the
repository: `python -m studies.cycles`."""
