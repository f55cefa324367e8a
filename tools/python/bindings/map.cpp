// Occupancy grids, their cells as numpy arrays.
#include <fmt/format.h>
#include <nanobind/stl/filesystem.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cmath>
#include <cstring>
#include <filesystem>

#include "common/error.h"
#include "common/inputs/open_map.h"
#include "common/map/grid_map.h"
#include "common/map/map_limits.h"
#include "common/map/map_reader.h"
#include "tools/python/bindings/bindings.h"
#include "tools/python/values/arguments.h"

namespace parloc::python {
namespace {

namespace nb = nanobind;
using namespace nb::literals;

void make_map(GridMap* self, nb::handle source, double resolution_m, const PoseLike& origin,
              const std::string& name) {
  const auto cells = bytes_from(source, "cells");
  const std::size_t height = cells.shape(0), width = cells.shape(1);
  const auto longest = static_cast<std::size_t>(kMaxMapSide);
  if (height < 1 || height > longest || width < 1 || width > longest)
    throw Error(ErrorKind::input, fmt::format("cells: expected 1 to {} rows and columns, got {} x {}",
                                              kMaxMapSide, height, width));
  if (!(resolution_m > 0.0) || !std::isfinite(resolution_m))
    throw Error(ErrorKind::input, fmt::format("resolution_m: expected above 0, got {}", resolution_m));
  if (!is_finite(origin.pose)) throw Error(ErrorKind::input, "origin: expected finite numbers");
  for (std::size_t k = 0; k < height * width; ++k)
    if (cells.data()[k] > static_cast<std::uint8_t>(Cell::unknown))
      throw Error(ErrorKind::input,
                  fmt::format("cells: expected 0 (free), 1 (occupied) or 2 (unknown), got {} at [{}, {}]",
                              cells.data()[k], k / width, k % width));
  auto* map = new (self) GridMap;
  map->width = static_cast<std::int32_t>(width);
  map->height = static_cast<std::int32_t>(height);
  map->resolution_m = resolution_m;
  map->T_map_grid = origin.pose;
  map->cells.resize(height * width);
  std::memcpy(map->cells.data(), cells.data(), height * width);
  map->name = name;
}

nb::ndarray<nb::numpy, std::uint8_t> cells_of(nb::handle_t<GridMap> self) {
  auto& map = nb::cast<GridMap&>(self);
  const std::size_t shape[] = {static_cast<std::size_t>(map.height), static_cast<std::size_t>(map.width)};
  return {map.cells.data(), 2, shape, self};
}

}  // namespace

void bind_map(nb::module_& m) {
  nb::class_<GridMap>(
      m, "GridMap",
      "An occupancy grid. cells[j, i] is 0 (free), 1 (occupied) or 2 (unknown); i grows along "
      "+x and j along +y of the grid's frame, whose origin is the corner of cells[0, 0]. "
      "Outside the grid is unknown.")
      .def("__init__", &make_map, "cells"_a, "resolution_m"_a, "origin"_a = PoseLike{}, "name"_a = "array",
           nb::sig("def __init__(self, cells: NDArray[numpy.uint8], resolution_m: float, origin: Pose | "
                   "Sequence[float] = "
                   "(0.0, 0.0, 0.0), name: str = 'array') -> None"),
           "From a uint8 array of shape (height, width), which is copied; `origin` is the pose of the corner "
           "of "
           "cells[0, 0] in the map frame. Raises TypeError for another type, InputError for other values.")
      .def_prop_ro(
          "cells", &cells_of,
          "uint8 array of shape (height, width): a view of the map itself, no copy. What filters made "
          "of the map they were given does not change with it.")
      .def_ro("width", &GridMap::width, "Cells along x.")
      .def_ro("height", &GridMap::height, "Cells along y.")
      .def_ro("resolution_m", &GridMap::resolution_m, "Size of a cell [m].")
      .def_ro("origin", &GridMap::T_map_grid, "Pose of the corner of cells[0, 0] in the map frame.")
      .def_ro("name", &GridMap::name, "Where it came from.")
      .def_ro("notes", &GridMap::notes, "What its file says that is not used, one line each.")
      .def(
          "save",
          [](const GridMap& map, const std::filesystem::path& path) { write_map(path.string(), map); },
          "path"_a, nb::call_guard<nb::gil_scoped_release>(),
          "Writes `path` (YAML) and the PGM of the same stem beside it, as ROS has them. Raises OutputError.")
      .def("__repr__", [](const GridMap& map) {
        return fmt::format("<parloc.GridMap {}: {} x {} cells of {} m>", map.name, map.width, map.height,
                           map.resolution_m);
      });
  m.def(
      "read_map", [](const std::filesystem::path& path) { return open_map(path.string(), {}); }, "path"_a,
      nb::call_guard<nb::gil_scoped_release>(),
      "Reads a map: the YAML file of ROS's map_server, a segment map (YAML or GeoJSON), or a bag with a map "
      "in "
      "it, told by content. Raises InputError, which names file and line and what was expected.");
}

}  // namespace parloc::python
