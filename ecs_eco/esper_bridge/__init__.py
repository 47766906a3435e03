"""Organisms as esper entities: the only package that knows where esper stores its worlds.

`world` defines the World that esper can inspect; `doors`, the dicts, sets and lists that esper's functions
use; `registry`, the effects of these functions on tables; and `turns`, how worlds in several threads share
esper's single state. Systems are esper.Processors. Tables, the clock, births and deaths are in
`ecs_eco.engine`, which does not depend on esper's entities.
"""
