"""How organisms are entities of esper: all that knows where esper keeps its worlds.

`world` has the World that esper can look into, `doors` the dicts, sets and lists that esper's functions meet,
`registry` what they do to tables, `turns` how worlds of several threads share esper's one state. Systems are
esper.Processors; tables, the clock, births and deaths belong to `ecs_eco.engine`, which knows nothing of this.
"""
