ecs-eco check reef.toml
ecs-eco run reef.toml --out run
ecs-eco compare reef.toml --treatment species.grouper.count=0 --seeds 2 --ticks 200 --out compared
