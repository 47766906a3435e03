"""Scientific claims about ecs-eco; each script tests one claim. Run a script from the root of the repository:
`python -m studies.cycles`."""
