ecs-eco check disease.toml
ecs-eco run disease.toml --trust --out run
python most.py
ecs-eco compare disease.toml --treatment systems.Disease.beta=0.05 --seeds 2 --out compared
