"""Maps of cells, and their files: map_server YAML with a PGM or PNG image."""

import pathlib
import re
import struct
import zlib
from dataclasses import dataclass

from measuring import Failure

FREE, OCCUPIED, UNKNOWN = 0, 1, 2
GREY = bytes([254, 0, 205]).ljust(256, b"\0")  # of those three, by ROS map_saver


@dataclass
class Grid:
    width: int
    height: int
    resolution_m: float
    origin_m: tuple  # lower-left corner
    cells: bytes  # FREE, OCCUPIED or UNKNOWN, row by row, the lowest first

    def rows(self):
        return [self.cells[row * self.width:(row + 1) * self.width] for row in range(self.height)]


def grid_of(rows, resolution_m, origin_m):
    return Grid(len(rows[0]), len(rows), resolution_m, origin_m, b"".join(rows))


# ---- Reading -----------------------------------------------------------------------------------------------------------


def map_settings(path):
    """`key: value` lines of a map_server file."""
    try:
        text = pathlib.Path(path).read_text()
    except (OSError, UnicodeDecodeError) as error:
        raise Failure(2, f"{path}: expected a map_server YAML file: {error}") from None
    settings = dict(re.findall(r"^(\w+):[ \t]*([^#\n]*?)[ \t]*(?:#.*)?$", text, re.MULTILINE))
    if missing := {"image", "resolution", "origin"} - settings.keys():
        raise Failure(2, f"{path}: expected a map_server YAML file with {', '.join(sorted(missing))}")
    if settings.get("mode", "trinary") != "trinary":
        raise Failure(2, f"{path}: expected mode trinary, found {settings['mode']}")
    return settings


def read_pgm(path):
    """Width, height, and the grey values of a binary PGM with 8 bits, the highest row first."""
    try:
        data = pathlib.Path(path).read_bytes()
    except OSError as error:
        raise Failure(2, f"{path}: expected the map's image: {error}") from None
    head = re.match(rb"P5(?:\s+#[^\n]*)*\s+(\d+)\s+(\d+)\s+255\s", data)
    if not head:
        raise Failure(2, f"{path}: expected a binary PGM (P5) with grey values to 255")
    width, height = int(head[1]), int(head[2])
    if len(data) - head.end() != width * height:
        raise Failure(2, f"{path}: expected {width} x {height} grey values, found {len(data) - head.end()}")
    return width, height, data[head.end():]


def read_map(path):
    settings = map_settings(path)
    try:
        resolution_m = float(settings["resolution"])
        x_m, y_m, yaw = (float(part) for part in settings["origin"].strip("[]").split(","))
        occupied, free = float(settings.get("occupied_thresh", 0.65)), float(settings.get("free_thresh", 0.196))
        negate = int(settings.get("negate", 0))
    except ValueError as error:
        raise Failure(2, f"{path}: expected numbers: {error}") from None
    if not resolution_m > 0:
        raise Failure(2, f"{path}: expected a positive resolution, found {resolution_m:g}")
    # MRPT rounds a map's corner to whole cells and knows no turned maps.
    if yaw != 0 or any(abs(v / resolution_m - round(v / resolution_m)) > 1e-4 for v in (x_m, y_m)):
        raise Failure(2, f"{path}: expected an origin of whole cells and no yaw, found {settings['origin']}")
    width, height, grey = read_pgm(pathlib.Path(path).parent / settings["image"].strip("\"'"))

    def cell(value):
        p = (value if negate else 255 - value) / 255
        return OCCUPIED if p > occupied else FREE if p < free else UNKNOWN

    cells = grey.translate(bytes(map(cell, range(256))))
    return grid_of([cells[row * width:(row + 1) * width] for row in reversed(range(height))], resolution_m, (x_m, y_m))


# ---- Writing -----------------------------------------------------------------------------------------------------------


def write_map(path, grid, image=".pgm", decimals=2, before="", mode="mode: trinary\n"):
    """PATH and its image beside it, of the kind that `image` ends in. `decimals` are the origin's."""
    picture = path.with_suffix(image)
    rows = [bytes(row).translate(GREY) for row in reversed(grid.rows())]
    picture.parent.mkdir(parents=True, exist_ok=True)
    picture.write_bytes(png(rows) if image == ".png" else f"P5\n{grid.width} {grid.height}\n255\n".encode() + b"".join(rows))
    origin = ", ".join(f"{v:.{decimals}f}" for v in grid.origin_m)
    path.write_text(f"{before}image: {picture.name}\n{mode}resolution: {grid.resolution_m}\norigin: [{origin}, 0.0]\n"
                    "negate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n")


def png(rows, channels=1):
    """8-bit grey (or RGB) PNG; the `up` filter turns unchanged rows into zeros, so a floor plan is small."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    raw, above = bytearray(), bytes(len(rows[0]))
    for row in rows:
        raw += b"\x02" + (bytes(a - b & 255 for a, b in zip(row, above, strict=True)) if row != above else bytes(len(row)))
        above = row
    header = struct.pack(">IIBBBBB", len(rows[0]) // channels, len(rows), 8, 2 if channels == 3 else 0, 0, 0, 0)
    return b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", header) + chunk(b"IDAT", zlib.compress(bytes(raw), 9)) + chunk(b"IEND", b"")
