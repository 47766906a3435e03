"""What became of the reflexes in one run."""

from ecs_eco.analysis.lineage import Lineage

lineage = Lineage.read("run")
living = lineage.alive(lineage.end) & (lineage.species == "vole")
print(f"a generation is {lineage.generation_time('vole'):.0f} ticks")
for gene in ("freeze", "flee", "neutral"):
    found = lineage.selection("vole", gene, "1")
    print(f"{gene}: {found.first:.2f} to {found.last:.2f}, s = {found.s:+.2f} per generation")
print(f"pace: {lineage.values('locomotion.pace')[living].mean():.2f}")
