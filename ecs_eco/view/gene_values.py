"""Values of genes in a recorded run."""

from __future__ import annotations

import math

import numpy as np

from ecs_eco.view.recording import Recording
from ecs_eco.view.scene import coloured_genes


class GeneValues:
    """The genes that code for one number each, `codes` by species and name, and their values in organisms."""

    def __init__(self, recording: Recording) -> None:
        self._recording, scene = recording, recording.scene
        codes = (
            {} if scene is None else {name: coloured_genes(scene.tables[name]) for name in recording.species}
        )
        self.codes = {name: genes for name, genes in codes.items() if genes}
        # values by species, of the uids asked for lately
        self._kept: dict[str, tuple[np.ndarray, dict[str, np.ndarray]]] = {}

    def expressed(self, name: str, uid: np.ndarray, gene: str) -> np.ndarray:
        """Return a gene's values of organisms (uids ascending): f32[n]."""
        kept, decoded = self._kept.get(name, (np.zeros(0, np.uint64), {}))
        if not np.isin(uid, kept).all():
            fresh = uid[~np.isin(uid, kept)]
            values = self._decoded(name, fresh)
            old = np.isin(kept, uid)
            order = np.argsort(np.concatenate([kept[old], fresh]), kind="stable")
            decoded = {
                g: np.concatenate([decoded[g][old] if g in decoded else np.zeros(0, np.float32), values[g]])[
                    order
                ]
                for g in values
            }
            kept = np.concatenate([kept[old], fresh])[order]
            self._kept[name] = kept, decoded
        return decoded[gene][np.searchsorted(kept, uid)]

    def _decoded(self, name: str, uid: np.ndarray) -> dict[str, np.ndarray]:
        layout = self._recording.scene.tables[name].species.heredity.layout
        texts = self._recording.genomes(uid)
        known = np.array([bool(text) for text in texts], np.bool_)
        out = {gene: np.full(uid.size, np.nan, np.float32) for gene in self.codes[name]}
        if known.any():
            loci = layout.rows([text for text in texts if text])
            for gene, values in layout.decode(loci, list(self.codes[name])).items():
                out[gene][known] = values
        return out

    def means(self, tick: np.ndarray) -> dict[str, list[float | None]]:
        """Return the mean of each gene over the living at these ticks, by "species.gene"."""
        from ecs_eco.analysis.lineage import Lineage

        lineage = Lineage.read(self._recording.path)
        out: dict[str, list[float | None]] = {}
        for name, genes in self.codes.items():
            mask = (lineage.species == name) & (lineage.genome != "")
            values = self._decoded(name, lineage.uid[mask])
            n = lineage.living_sums(tick, mask=mask)
            for gene in genes:
                weights = np.zeros(len(lineage))
                weights[mask] = values[gene]
                mean = lineage.living_sums(tick, weights, mask) / np.where(n, n, np.nan)
                out[f"{name}.{gene}"] = [float(f"{v:.5g}") if math.isfinite(v) else None for v in mean]
        return out
