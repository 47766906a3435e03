"""The commands as the command line sees them: arguments, options and their words, a file for each kind of work.

What a command does belongs to the files of `ecs_eco.cli`; `app` says in which order `--help` names the commands.
"""
