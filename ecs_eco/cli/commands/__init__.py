"""The interface of the commands: arguments, options and help texts, a file for each kind of work.

The work of a command belongs to the files of `ecs_eco.cli`;
`app` sets the order in which `--help` lists them.
"""
