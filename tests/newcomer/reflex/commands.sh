ecs-eco check flee_or_freeze.toml
ecs-eco run flee_or_freeze.toml --seed 1 --out run
python genes.py
ecs-eco compare flee_or_freeze.toml --treatment neutral-drift --seeds 3 --out compared
