import pytest


@pytest.fixture(autouse=True)
def _one_torch_thread():
    """What libraries of learners compute takes one thread; the number of before comes back."""
    import torch

    before = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(before)
