"""Conversion of columns to Arrow and Parquet: floats are split by byte, ids and ticks are stored as
differences, and all columns are compressed with zstd."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from types import MappingProxyType
from typing import Any

import numpy as np
import pyarrow as pa
import pyarrow.compute as pc
import pyarrow.parquet as pq

from ecs_eco.engine import files
from ecs_eco.engine.errors import RecordingError
from ecs_eco.record import belonging, seal


def to_arrow(
    columns: Mapping[str, np.ndarray],
    words: Mapping[str, Sequence[str]],
    missing: Mapping[str, np.ndarray] = MappingProxyType({}),
) -> pa.Table:
    """Return columns as a table; a column named in `words` contains indices into that list and becomes a
    dictionary column.

    Text (ASCII bytes or str) becomes a string column, in which empty texts are null. Numbers are null where
    `missing`, bool[rows] by column, is true.
    """
    arrays = {}
    for name, array in columns.items():
        if name in words:
            known = _texts(list(words[name]) or [""])
            arrays[name] = pa.DictionaryArray.from_arrays(_numbers(array.astype(np.int32)), known)
        elif array.dtype.kind in "SU":
            arrays[name] = _texts(array.tolist(), null=True)
        else:
            arrays[name] = _numbers(array, missing.get(name))
    return pa.table(arrays)


# `pa.array` and `to_numpy` would import pandas to check for pandas objects


def _texts(texts: Sequence[str | bytes], null: bool = False) -> pa.Array:
    """Return texts as an Arrow array of strings; with `null`, empty texts are null."""
    letters = [text.encode() if isinstance(text, str) else text for text in texts]
    ends = np.cumsum([0, *map(len, letters)])
    if ends[-1] >= 1 << 31:
        return pa.array(texts, pa.string())
    there = np.packbits(np.array([len(text) > 0 for text in letters], bool), bitorder="little")
    return pa.StringArray.from_buffers(
        len(letters),
        pa.py_buffer(ends.astype(np.int32)),
        pa.py_buffer(b"".join(letters)),
        pa.py_buffer(there) if null else None,
    )


def _numbers(array: np.ndarray, missing: np.ndarray | None = None) -> pa.Array:
    """Return numbers as an Arrow array, with nulls where `missing` is true."""
    if array.ndim != 1 or array.dtype.kind not in "biuf" or not array.dtype.isnative:
        return pa.array(np.ascontiguousarray(array))
    bits = np.packbits(array, bitorder="little") if array.dtype.kind == "b" else np.ascontiguousarray(array)
    there = None
    if missing is not None and missing.any():
        there = pa.py_buffer(np.packbits(~missing, bitorder="little"))
    return pa.Array.from_buffers(pa.from_numpy_dtype(array.dtype), array.size, [there, pa.py_buffer(bits)])


def to_numpy(column: pa.ChunkedArray) -> np.ndarray:
    """Return the numbers of a column, with 0 for nulls."""
    if column.null_count or not (pa.types.is_integer(column.type) or pa.types.is_floating(column.type)):
        return np.asarray(column.fill_null(0).to_numpy())
    parts = [np.from_dlpack(chunk) for chunk in column.chunks if len(chunk)]
    return np.concatenate(parts) if parts else np.zeros(0, column.type.to_pandas_dtype())


def to_codes(column: pa.ChunkedArray) -> tuple[list[str], np.ndarray]:
    """Return the distinct strings of a text column without nulls, and the index of each row's string."""
    column = column.cast(pa.string()).combine_chunks().dictionary_encode()
    if isinstance(column, pa.ChunkedArray):
        column = column.combine_chunks()
    if not len(column):
        return [], np.zeros(0, np.int64)
    return column.dictionary.to_pylist(), to_numpy(pa.chunked_array([column.indices]))


def write_part(table: pa.Table, path: Path, mark: belonging.Mark | None = None) -> str:
    """Atomically write one Parquet part with its mark and seal; return the seal."""
    floats = [f.name for f in table.schema if pa.types.is_floating(f.type)]
    words = [
        f.name
        for f in table.schema
        if pa.types.is_dictionary(f.type) or (pa.types.is_string(f.type) and _repeats(table[f.name]))
    ]
    deltas = {
        f.name: "DELTA_BINARY_PACKED"
        for f in table.schema
        if pa.types.is_integer(f.type) and f.type.bit_width >= 32
    }
    deltas |= dict.fromkeys(floats, "BYTE_STREAM_SPLIT")
    memory = pa.BufferOutputStream()
    with pq.ParquetWriter(
        memory,
        table.schema,
        compression="zstd",
        compression_level=3,
        use_dictionary=words,
        column_encoding=deltas or None,
        write_page_checksum=True,
    ) as writer:
        writer.write_table(table)
        metadata = {} if mark is None else {belonging.KEY: mark.text()}
        # the seal is last, because it is searched for from the end
        writer.add_key_value_metadata(metadata | {seal.KEY: seal.BLANK})
    part, own = seal.sealed(memory.getvalue().to_pybytes())
    files.write(path, part)
    return own


def _repeats(texts: pa.ChunkedArray) -> bool:
    """Return whether dictionary encoding takes fewer bytes for these texts."""
    distinct = pc.count_distinct(texts).as_py()
    letters = (pc.sum(pc.binary_length(texts)).as_py() or 0) / max(len(texts), 1)  # mean bytes per text
    return distinct * letters + len(texts) * distinct.bit_length() / 8 < len(texts) * letters


def open_part(path: Path, needed: bool = False) -> pq.ParquetFile:
    """Open a part after checking its seal, which it must have if `needed`. Raises RecordingError if it is
    damaged.

    Arrow owns the bytes, and they are read in the calling thread (`read_part`, `read_group`, `each_batch`):
    if an Arrow thread frees a Python object while the interpreter exits, the process aborts.
    """
    try:
        files.require_regular(path)
        with pa.OSFile(str(path)) as file:
            part = file.read_buffer()
        seal.check(path, memoryview(part), needed)
        opened = pq.ParquetFile(pa.BufferReader(part), page_checksum_verification=True, pre_buffer=False)
    except (pa.ArrowException, OSError) as error:
        raise RecordingError(f"{path}: cannot be read: {error}") from None
    if 8 * opened.metadata.num_rows * opened.metadata.num_columns > (most := 2 * files.MOST_BYTES):
        raise RecordingError(f"{path}: unpacks to more than {most:,} bytes")
    return opened


def read_part(path: Path, columns: Sequence[str] | None = None, needed: bool = False) -> pa.Table:
    """Return a part as a table; raise RecordingError if it cannot be read or is damaged."""
    file = open_part(path, needed)
    with _named(path):
        return file.read(columns=columns, use_threads=False)


def read_group(path: Path, file: pq.ParquetFile, number: int, columns: Sequence[str]) -> pa.Table:
    """Return columns of one row group of an open part; raise RecordingError if it cannot be read."""
    with _named(path):
        return file.read_row_group(number, columns=columns, use_threads=False)


def each_batch(
    path: Path, columns: Sequence[str] | None = None, needed: bool = False, rows: int = 1 << 17
) -> Iterator[pa.Table]:
    """Yield a part, with these columns or all, as tables of `rows` rows; raise RecordingError if it is damaged."""
    file = open_part(path, needed)
    with _named(path):
        for batch in file.iter_batches(rows, columns=columns, use_threads=False):
            yield pa.Table.from_batches([batch])


def read_metadata(path: Path) -> pq.FileMetaData:
    """Return a part's footer; raise RecordingError if it cannot be read."""
    with _named(path):
        files.require_regular(path)
        return pq.read_metadata(path)


@contextmanager
def _named(path: Path) -> Iterator[None]:
    """Turn read errors within the context into a RecordingError that names the file."""
    try:
        yield
    except (pa.ArrowException, OSError, ValueError) as error:
        raise RecordingError(f"{path}: cannot be read: {error}") from None


def read_parts(folder: Path, columns: Sequence[str] | None = None) -> Any:
    """Return all parts in one folder of a run as a single table.

    Parameters
    ----------
    folder : Path
        For example `my-run/births`.
    columns : sequence of str, optional
        Columns to read; default: all.

    Returns
    -------
    pyarrow.Table
        Has no columns if there are no parts. Columns that a part lacks are null in its rows.

    Raises
    ------
    RecordingError
        If a part is damaged or missing.

    Examples
    --------
    >>> from pathlib import Path
    >>> from ecs_eco.record.parquet import read_parts
    >>> from ecs_eco.runs.run import run_to_folder
    >>> manifest = run_to_folder("predator-prey", seed=1, ticks=5, out="my-run", report=False)
    >>> read_parts(Path("my-run/births"), ["tick", "species", "uid"]).num_columns
    3
    """
    run, needed = folder.parent, seal.has_seals(folder.parent)
    parts = belonging.parts(run, folder.name, seal.read_manifest(run)) if needed else belonging.listed(folder)
    tables = [read_part(p, columns, needed) for p in parts] or [pa.table({})]
    return pa.concat_tables(tables, promote_options="permissive")
