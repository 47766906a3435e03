"""Real land: the keys for rasters and vector layers."""

from typing import Annotated, Literal

from pydantic import Field

from ecs_eco.inputs.section import Name, NonNegative, Positive, Real, Section, Share, about, quantity, table

FileName = Annotated[str, Field(min_length=1, max_length=1000)]
Band = Annotated[int, Field(ge=1, le=100_000)] | Annotated[str, Field(min_length=1, max_length=200)]


class LandClass(Section):
    """A class of land, defined by cover, elevation or slope; if several apply, the last one is used."""

    codes: list[Annotated[int, Field(ge=-(2**31), lt=2**31)]] = about(
        "numbers of this class in the raster `cover`; default: any number", []
    )
    above: Real | None = quantity("minimum elevation; default: no limit", "m", None)
    below: Real | None = quantity("maximum elevation (exclusive); default: no limit", "m", None)
    steeper: NonNegative | None = quantity("minimum slope, as rise over run; default: no limit", "1", None)
    growth: NonNegative = quantity(
        "factor for the growth of plants there and for the rates at which they colonize free sites", "1", 1.0
    )
    pace: Positive = quantity(
        "factor for the speed of animals that walk there; a road on it has its own factor", "1", 1.0
    )
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)
    shelter: Share = quantity("proportion of attacks on animals there that fail", "1", 0.0)
    ground: Literal["open", "water", "rock"] = about(
        "open: walkable; water: stops walkers and counts as a lake for fields; rock: stops walkers and sight",
        "open",
    )
    color: Annotated[str, Field(pattern=r"^#[0-9a-fA-F]{6}$")] | None = about(
        "color on maps, #rrggbb; default: the color of the ground", None
    )


class Layer(Section):
    """A vector layer: lakes, roads, fences, or areas of a land class."""

    file: FileName = about(
        "a file in the folder of the world file or a subfolder: GeoJSON or, with pyogrio, GeoPackage, "
        "Shapefile or FlatGeobuf"
    )
    layer: Annotated[str, Field(min_length=1, max_length=200)] | None = about(
        "the layer in the file; default: the first layer", None
    )
    make: Literal["lakes", "roads", "fences", "class"] = about(
        "what its shapes become; lakes and class need areas, roads and fences need lines"
    )
    land: Name | None = about('with make = "class": the class, one of `classes`', None)
    width: Positive = quantity("width of roads", "m", 1.0)
    pace: Positive = quantity("factor for the speed of animals on the roads", "1", 1.0)
    cost: NonNegative = quantity("factor for the cost of moving per second", "1", 1.0)


class Drainage(Section):
    """Water that collects on a raster of elevations."""

    sea: Real | None = quantity("ground at this elevation or below is sea; default: no sea", "m", None)
    depth: Positive | None = quantity(
        "minimum depth of a lake: a hollow is a lake if it can hold water this deep before it overflows; "
        "default: no lakes",
        "m",
        None,
    )
    stream: Positive | None = quantity(
        "minimum catchment area of a stream; animals can drink from a stream, as from a lake, and walk "
        "through it; default: no streams",
        "m^2",
        None,
    )


class RealLand(Section):
    """The keys of `terrain` for real land."""

    raster: FileName | None = about(
        "file of elevations [m] in the folder of the world file or a subfolder: .npz, .asc (ESRI ASCII grid) "
        "or, with rasterio, GeoTIFF, .hgt, .dem or DTED; or package:path for a file in an installed package; "
        "default: the ground consists of `hills` and `mountains`",
        omit=True,
    )
    band: Band | None = about(
        "number of the band, from 1, or name of the array in an .npz file; default: the first", omit=True
    )
    crs: Annotated[str, Field(min_length=1, max_length=5000)] | None = about(
        'coordinate system, if the raster does not state one, such as "EPSG:4326" for degrees', omit=True
    )
    corner: Annotated[list[NonNegative], Field(min_length=2, max_length=2)] | None = quantity(
        "position of the world's southwest corner relative to the raster's; default: [0, 0]", "m", omit=True
    )
    scale: Positive | None = quantity(
        "horizontal meters in the world per meter of land; default: 1", "1", omit=True
    )
    vertical: Positive | None = quantity("factor for the elevations; default: 1", "1", omit=True)
    missing: Real | None = quantity(
        "elevation of cells without data; default: such cells are an error", "m", omit=True
    )
    cover: FileName | None = about("a raster of land-cover class numbers", omit=True)
    cover_band: Band | None = about("number or name of its band; default: the first", omit=True)
    classes: dict[Name, LandClass] = table("name = properties of this class of land", dict, omit=True)
    layers: list[Layer] = about("vector layers on the land", [], omit=True)
    drainage: Drainage | None = about("lakes, streams and sea where water collects; absent: none", omit=True)
