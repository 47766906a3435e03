import numpy as np
import pytest

from ecs_eco import Table, boolean, component, f32, f64, i64, u8, u64


@component
class Fur:
    """A coat."""

    length: f32 = 0.5
    hairs: u64 = 2**63 + 1
    wet: boolean = False
    rgb: f32[3] = 0.25
    rings: u8["legs"] = 7  # noqa: F821

    def shorn(self):
        return self.length / 2


def _table(n=3, legs=2):
    table = Table("cat", (Fur,), dims={"legs": legs})
    table.occupy(n, 1, 0, {})
    return table


def test_annotated_fields_become_columns_of_their_type_and_shape():
    table = _table()
    columns = table[Fur]
    assert (columns.length.dtype, columns.hairs.dtype, columns.wet.dtype, columns.rings.dtype) == (
        np.float32,
        np.uint64,
        np.bool_,
        np.uint8,
    )
    assert columns.rgb.shape == (64, 3)
    assert columns.rings.shape == (64, 2)
    assert columns.length[:3].tolist() == [0.5] * 3
    assert columns.hairs[0] == 2**63 + 1
    assert columns.rings[2].tolist() == [7, 7]


def test_a_handle_reads_and_writes_its_row_and_no_other():
    table = _table()
    handle = Fur.attach(table[Fur], 1)
    handle.length, handle.wet, handle.rgb = 2.0, True, [1, 2, 3]
    assert table[Fur].length[:3].tolist() == [0.5, 2.0, 0.5]
    assert table[Fur].rgb[:3].tolist() == [[0.25] * 3, [1, 2, 3], [0.25] * 3]
    table[Fur].hairs[1] = 9
    assert (handle.hairs, handle.wet, handle.rings.tolist()) == (9, True, [7, 7])
    assert isinstance(handle.length, float)
    assert isinstance(handle.hairs, int)
    handle.rgb[2] = 8  # a view
    assert table[Fur].rgb[1, 2] == 8


def test_a_component_made_alone_holds_its_values_and_keeps_methods_and_docstring():
    fur = Fur(length=3)
    assert (fur.length, fur.wet, fur.shorn()) == (3.0, False, 1.5)
    assert Fur.__doc__ == "A coat."
    assert Fur.__module__ == __name__
    assert "length=3.0" in repr(fur)
    assert not hasattr(fur, "__dict__")


def test_types_say_what_they_are():
    assert repr(f32) == "float32"
    assert repr(f32[3, "n"]) == "float32[3, n]"
    assert f64(1).dtype == np.float64


@pytest.mark.parametrize(
    ("fields", "error", "message"),
    [
        ({"x": (float, 1.0)}, TypeError, r"Bad.x: <class 'float'> is not a column type; use f32"),
        ({"x": (f32, ...)}, TypeError, r"Bad.x: a field needs a default, as in `x: float32 = 0`"),
        ({}, TypeError, r"Bad: a component needs at least one field"),
        ({"fields": (f32, 0)}, TypeError, r"Bad.fields: this name is reserved for handles"),
        ({"_x": (f32, 0)}, TypeError, r"Bad._x: this name is reserved for handles"),
        ({"x": (u8, 300)}, ValueError, r"Bad.x: 300 is not uint8 \(.*out of bounds"),
        ({"x": (f32, "warm")}, ValueError, r"Bad.x: 'warm' is not float32"),
        ({"x": (f32[3], [1, 2])}, ValueError, r"Bad.x: \[1, 2\] is not float32\[3\]"),
    ],
)
def test_a_wrong_declaration_is_refused_at_once(fields, error, message):
    body = {"__annotations__": {name: kind for name, (kind, _) in fields.items()}}
    body |= {name: default for name, (_, default) in fields.items() if default is not ...}
    with pytest.raises(error, match=message):
        component(type("Bad", (), body))


def test_a_component_inherits_nothing():
    with pytest.raises(TypeError, match="Wet: a component cannot inherit; list its fields instead of Fur"):

        @component
        class Wet(Fur):
            water: f32 = 0


def test_an_unknown_field_names_the_nearest():
    with pytest.raises(TypeError, match=r"unknown field .lenght.*did you mean .length"):
        Fur(lenght=1)
    with pytest.raises(ValueError, match=r"Fur.rgb: \[1, 2\] is not float32\[3\]"):
        Fur(rgb=[1, 2])
    with pytest.raises(AttributeError):
        Fur().lenght = 2


def test_a_size_that_nobody_gave_is_named():
    with pytest.raises(
        ValueError,
        match=r"Fur.rings in table 'cat': "
        r"the shape uint8\[legs\] needs the size 'legs'; declared: none",
    ):
        Table("cat", (Fur,))


def test_annotations_written_as_text_are_understood():
    scope = {"__name__": __name__, "component": component}
    # as `from __future__ import annotations` leaves them
    exec("@component\nclass Late:\n    n: 'i64' = 4\n    v: 'f32[2]' = 1\n", scope)
    assert scope["Late"](n=5).n == 5
    assert i64 is not None
    assert scope["Late"].fields["v"][0].shape == (2,)
