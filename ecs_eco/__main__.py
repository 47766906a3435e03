"""Run the `ecs-eco` command as `python -m ecs_eco`, in case its script is not on the path."""

from ecs_eco.cli import main

if __name__ == "__main__":
    main()
