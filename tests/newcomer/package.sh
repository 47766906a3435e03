ecs-eco new wool-lab --package
pip install -e "wool-lab[test]"
python -m pytest wool-lab
ecs-eco check wool-lab/src/wool_lab/meadow.toml --trust
ecs-eco run wool-lab/src/wool_lab/meadow.toml --trust --ticks 60 --out my-run
