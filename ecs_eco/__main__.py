"""`python -m ecs_eco`: the command `ecs-eco` if its script is not on the path."""

from ecs_eco.cli import main

if __name__ == "__main__":
    main()
