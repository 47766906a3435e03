"""What systems share about coming and going: founders, births, remains, defence.

No system of its own: when these things happen is the business of `ecs_eco.systems`.
"""
