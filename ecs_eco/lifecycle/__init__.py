"""What systems share about coming and going: species, founders, births, causes of death, defence.

No system belongs here: `ecs_eco.systems` decides when these things happen.
"""
