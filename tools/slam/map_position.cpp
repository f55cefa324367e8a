#include "tools/slam/map_position.h"

#include <sstream>

#include "common/file/bytes.h"
#include "tools/slam/saved_growth.h"

namespace parloc::tools::slam {

std::string to_bytes(const MapPosition& position) {
  std::string bytes;
  ByteWriter w(
      [&](const void* data, std::size_t size) { bytes.append(static_cast<const char*>(data), size); });
  w.put_text(position.log_name);
  w.put_count(position.scans);
  w.put_text(position.digest);
  w.put(position.step_s);
  w.put(position.wall_s);
  w.put_bool(position.odometry_chosen);
  w.put_each(position.growth, put_growth);
  w.flush();
  return bytes;
}

MapPosition map_position_from(const std::string& bytes, const std::string& name) {
  std::istringstream in(bytes, std::ios::binary);
  ByteReader r(in, bytes.size(), name);
  MapPosition position;
  position.log_name = r.get_text();
  position.scans = r.get<std::uint64_t>();
  position.digest = r.get_text();
  position.step_s = r.get_vector<double>();
  position.wall_s = r.get<double>();
  position.odometry_chosen = r.get_bool();
  position.growth = r.get_each(100, get_growth);
  return position;
}

}  // namespace parloc::tools::slam
