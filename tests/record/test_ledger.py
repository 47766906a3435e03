import numpy as np

from ecs_eco.components import Metabolism
from ecs_eco.record.ledger import FLOWS, LEDGER, LEDGER_ROW, imbalance


def test_what_comes_in_and_goes_out_makes_the_difference_of_the_stocks():
    page = np.array((10.0, 2.0, 5.0, 3.0, 1.0, 4.0, 9.0), LEDGER_ROW)
    assert imbalance(page) == 0
    page["burnt"] += 1.5
    page["endowed"] += 0.25
    assert imbalance(page) == -1.25


def test_the_ledger_of_whole_columns_is_checked_row_by_row():
    columns = {name: np.zeros(3) for name in LEDGER} | {
        "taken_in": np.array([0.0, 1.0, 2.0]),
        "lost": np.array([0.0, 1.0, 4.0]),
    }
    assert imbalance(columns).tolist() == [0, 0, -2]


def test_every_flow_is_a_column_of_the_ledger_and_a_field_of_metabolism():
    assert set(FLOWS) < set(LEDGER)
    assert set(FLOWS.values()) < set(Metabolism.fields)
