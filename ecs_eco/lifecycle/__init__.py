"""What systems share about coming and going: species, founders, births, defence.

No system belongs here: when these things happen is the business of `ecs_eco.systems`.
"""
