"""Organisms as entities of esper: the only package that knows where esper stores its worlds.

`world` has the World that esper can inspect; `doors` the dicts, sets and lists that esper's functions use;
`registry` the effect of these functions on tables; `turns` how worlds of several threads share esper's single
state. Systems are esper.Processors. Tables, the clock, births and deaths belong to `ecs_eco.engine`, which
knows nothing of esper's entities.
"""
