"""Real land: the keys for rasters and vector layers."""

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.inputs.section import Name, NonNegative, Positive, Real, Section, Share, about, quantity, table

FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Band = Annotated[int, Field(ge=1, le=100_000)] | Annotated[str, Field(min_length=1, max_length=200)]


class LandClass(Section):
    """A class of land cover, or of elevation and slope; if several apply, the last class is used."""

    codes: list[Annotated[int, Field(ge=-(2**31), lt=2**31)]] = about(
        "its numbers in the raster `cover`; absent: any", []
    )
    above: Real | None = quantity("minimum elevation; absent: any", "m", None)
    below: Real | None = quantity("elevation below which it lies; absent: any", "m", None)
    steeper: NonNegative | None = quantity("minimum slope, rise per distance; absent: any", "1", None)
    growth: NonNegative = quantity(
        "factor for the growth of plants there, and for the rates at which they take free sites", "1", 1.0
    )
    pace: Positive = quantity(
        "factor for the speed of animals that walk there; a road on it has its own factor", "1", 1.0
    )
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)
    shelter: Share = quantity("proportion of attacks that fail on animals there", "1", 0.0)
    ground: Literal["open", "water", "rock"] = about(
        "open: walkable; water: stops walkers, and is a lake for fields; rock: stops walkers and sight",
        "open",
    )
    color: Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")] | None = about(
        "color on maps, #rrggbb; absent: color of the ground", None
    )


class Layer(Section):
    """A vector layer, read by pyogrio: lakes, roads, fences, or areas of a land class."""

    file: FileName = about(
        "a file in the folder of the world file or below: GeoJSON, or with pyogrio GeoPackage, "
        "Shapefile or FlatGeobuf"
    )
    layer: Annotated[str, Field(min_length=1, max_length=200)] | None = about(
        "the layer in the file; absent: the first layer", None
    )
    make: Literal["lakes", "roads", "fences", "class"] = about(
        "what its shapes become: lakes and class need areas, roads and fences need lines"
    )
    land: Name | None = about('with make = "class": the class, one of `classes`', None)
    width: Positive = quantity("width of roads", "m", 1.0)
    pace: Positive = quantity("factor for the speed of animals on the roads", "1", 1.0)
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)


class Drainage(Section):
    """Water that collects on a raster of elevations."""

    sea: Real | None = quantity("ground at this elevation or below is sea; absent: no sea", "m", None)
    depth: Positive | None = quantity(
        "minimum depth of water that a hollow must hold before it overflows to count as a lake; absent: no "
        "hollow is a lake",
        "m",
        None,
    )
    stream: Positive | None = quantity(
        "minimum catchment area of a stream; animals can drink from a stream as from a lake, and walk "
        "through it; absent: no streams",
        "m^2",
        None,
    )


class RealLand(Section):
    """The keys of `terrain` for real land."""

    raster: FileName | None = about(
        "elevations [m], a file in the folder of the world file or below: .npz, .asc (ESRI ASCII grid), or "
        "with rasterio GeoTIFF, .hgt, .dem, DTED; or package:path of a file in an installed package; "
        "absent: the ground consists of `hills` and `mountains`",
        omit=True,
    )
    band: Band | None = about(
        "number of its band, from 1, or the name of an array in an .npz; absent: the first", omit=True
    )
    crs: Annotated[str, Field(min_length=1, max_length=5000)] | None = about(
        'coordinate system of a raster that does not state its own, such as "EPSG:4326" for degrees',
        omit=True,
    )
    corner: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = quantity(
        "position of the south-west corner of the world, relative to the same corner of the raster; absent: [0, 0]",
        "m",
        omit=True,
    )
    scale: Positive | None = quantity(
        "horizontal meters of the world per meter of the land; absent: 1", "1", omit=True
    )
    vertical: Positive | None = quantity("factor for the elevations; absent: 1", "1", omit=True)
    missing: Real | None = quantity(
        "elevation of cells without data; absent: such cells are an error", "m", omit=True
    )
    cover: FileName | None = about("a raster of land-cover class numbers", omit=True)
    cover_band: Band | None = about("number or name of its band; absent: the first", omit=True)
    classes: dict[Name, LandClass] = table("name = properties of land of this class", dict, omit=True)
    layers: list[Layer] = about("vector layers on the land", [], omit=True)
    drainage: Drainage | None = about("lakes, streams and sea where water collects; absent: none", omit=True)
