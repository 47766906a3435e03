"""Real land: what a world takes from rasters and vector layers."""

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.inputs.section import (
    Name,
    NonNegative,
    Positive,
    Real,
    Section,
    Share,
    about,
    is_absent,
    is_empty,
    quantity,
)

FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Band = Annotated[int, Field(ge=1, le=100_000)] | Annotated[str, Field(min_length=1, max_length=200)]


class LandClass(Section):
    """A class of land cover, or of elevation and slope; where several apply, the last one counts."""

    codes: list[Annotated[int, Field(ge=-(2**31), lt=2**31)]] = about(
        "the numbers that it has in the raster `cover`; absent: any", []
    )
    above: Real | None = quantity("least elevation; absent: any", "m", None)
    below: Real | None = quantity("elevation that it does not reach; absent: any", "m", None)
    steeper: NonNegative | None = quantity("least slope, rise per way; absent: any", "1", None)
    growth: NonNegative = quantity(
        "factor of the growth of plants there, and of the rates at which they take free sites", "1", 1.0
    )
    pace: Positive = quantity(
        "factor of the speed of animals that walk there; a road on it has its own", "1", 1.0
    )
    cost: NonNegative = quantity("factor of the cost of moving per second", "1", 1.0)
    shelter: Share = quantity("share of the attacks that fail on animals that are there", "1", 0.0)
    ground: Literal["open", "water", "rock"] = about(
        "open: can be walked on; water: stops walkers, and is a lake for fields; rock: stops walkers and "
        "sight",
        "open",
    )
    color: Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")] | None = about(
        "color on maps, #rrggbb; absent: that of the ground", None
    )


class Layer(Section):
    """A vector layer, read by pyogrio: lakes, roads, fences, or land of a class."""

    file: FileName = about(
        "a file in the folder of the world file or below: GeoJSON, or with pyogrio GeoPackage, "
        "Shapefile or FlatGeobuf"
    )
    layer: Annotated[str, Field(min_length=1, max_length=200)] | None = about(
        "the layer in it; absent: the first one", None
    )
    make: Literal["lakes", "roads", "fences", "class"] = about(
        "what its shapes are: lakes and class of areas, roads and fences of lines"
    )
    land: Name | None = about('with make = "class": the class, one of `classes`', None)
    width: Positive = quantity("breadth of roads", "m", 1.0)
    pace: Positive = quantity("factor of the speed of animals on the roads", "1", 1.0)
    cost: NonNegative = quantity("factor of the cost of moving per second", "1", 1.0)


class Drainage(Section):
    """Where water collects on a raster of elevations."""

    sea: Real | None = quantity("ground at this elevation or below is sea; absent: there is none", "m", None)
    depth: Positive | None = quantity(
        "hollows are lakes that would hold at least so deep a water before it runs over; absent: none is",
        "m",
        None,
    )
    stream: Positive | None = quantity(
        "where the water of at least so large an area runs together is a stream: who comes there can drink "
        "as from a lake, and walk through it; absent: there are none",
        "m^2",
        None,
    )


class RealLand(Section):
    """The keys of `terrain` for real land."""

    raster: FileName | None = about(
        "elevations [m], a file in the folder of the world file or below: .npz, .asc (ESRI ASCII grid), or with "
        "rasterio GeoTIFF, .hgt, .dem, DTED; or package:path of a file that comes with an installed package; "
        "absent: the ground is made of `hills` and `mountains`",
        None,
        exclude_if=is_absent,
    )
    band: Band | None = about(
        "which band of it, from 1, or the name of an array of an .npz; absent: the first one",
        None,
        exclude_if=is_absent,
    )
    crs: Annotated[str, Field(min_length=1, max_length=5000)] | None = about(
        'coordinate system of a raster that does not state its own, as "EPSG:4326" for degrees',
        None,
        exclude_if=is_absent,
    )
    corner: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = quantity(
        "where the south-west corner of the world is, from that of the raster; absent: there",
        "m",
        None,
        exclude_if=is_absent,
    )
    scale: Positive | None = quantity(
        "meters of the world per meter of the land, along the ground; absent: 1",
        "1",
        None,
        exclude_if=is_absent,
    )
    vertical: Positive | None = quantity(
        "factor of the elevations; absent: 1", "1", None, exclude_if=is_absent
    )
    missing: Real | None = quantity(
        "elevation of cells that have none; absent: they are refused", "m", None, exclude_if=is_absent
    )
    cover: FileName | None = about(
        "a raster of the numbers of land-cover classes", None, exclude_if=is_absent
    )
    cover_band: Band | None = about("which band of it; absent: the first one", None, exclude_if=is_absent)
    classes: dict[Name, LandClass] = Field(
        default_factory=dict,
        exclude_if=is_empty,
        description="name = what is different on land of this class",
    )
    layers: list[Layer] = about("vector layers on it", [], exclude_if=is_empty)
    drainage: Drainage | None = about("where water collects; absent: nowhere", None, exclude_if=is_absent)
