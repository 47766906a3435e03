"""Scientific claims about ecs-eco: one script a claim, run from the root of the repository:
`python -m studies.cycles`."""
