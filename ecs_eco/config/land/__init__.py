"""Real land, as it is read and as a world covers it; what it does to a world: `ecs_eco.life.land`."""
