"""Files of trained policies and their seals."""

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from ecs_eco.config.shipped import shipped
from ecs_eco.learning import weights

WEIGHTS = {"b": np.arange(6, dtype=np.float32).reshape(2, 3), "a": np.ones(2, np.float32)}


def test_weights_come_back_as_they_were_saved(tmp_path):
    loaded = weights.load(
        weights.save(tmp_path / "deer.safetensors", {"b": WEIGHTS["b"], "t": WEIGHTS["b"].T})
    )
    assert {name: array.tolist() for name, array in loaded.items()} == {
        "b": WEIGHTS["b"].tolist(),
        "t": WEIGHTS["b"].T.tolist(),
    }


def test_one_flipped_bit_is_noticed_or_changes_no_weight(tmp_path):
    whole = weights.save(tmp_path / "deer.safetensors", WEIGHTS).read_bytes()
    refused = 0
    for bit in range(8 * len(whole)):
        data = bytearray(whole)
        data[bit // 8] ^= 1 << bit % 8
        (tmp_path / "flip.safetensors").write_bytes(data)
        try:
            loaded = weights.load(tmp_path / "flip.safetensors")
        except ValueError:
            refused += 1
            continue
        assert all(loaded[name].tobytes() == array.tobytes() for name, array in WEIGHTS.items()), bit
    assert refused > 8 * sum(array.nbytes for array in WEIGHTS.values())


def test_weights_of_other_origin_are_taken_and_can_be_sealed(tmp_path):
    path = tmp_path / "deer.safetensors"
    save_file(WEIGHTS, path)
    assert set(weights.load(path)) == {"a", "b"}
    weights.add_seal(path)
    assert b"ecs-eco.seal" in path.read_bytes()
    assert load_file(path)["b"].tolist() == WEIGHTS["b"].tolist()


@pytest.mark.parametrize(
    "path", sorted(p for world in shipped().values() for p in world.parent.glob("*.safetensors")), ids=str
)
def test_every_shipped_policy_has_a_seal(path):
    weights.load(path)
    assert b'"ecs-eco.seal"' in path.read_bytes()[:400]
