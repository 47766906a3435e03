"""Small layouts for tests, and what a text means in one."""

from ecs_eco.genomes import Gene, Layout

RED = Gene(name="red", letters=1, values=[0, 0, 0, -1])


def one(gene: Gene, letters: str = "ACGT", **arguments) -> Layout:
    return Layout([gene], letters, **arguments)


def meaning(layout: Layout, text: str) -> dict[str, float]:
    return {
        name: value[0].tolist() for name, value in layout.decode(layout.alphabet.encode(text)[None]).items()
    }
