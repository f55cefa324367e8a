#include "common/eval/families/family.h"

#include <algorithm>
#include <cstddef>
#include <iterator>
#include <string>

#include "common/error.h"
#include "common/file/nearest_name.h"

namespace parloc {
namespace {

struct Entry {
  Family family;
  const char* name;
  const char* meaning;
};

constexpr Entry kFamilies[] = {
    {Family::plain, "plain", "no trouble but what the ranges bring"},
    {Family::slow_scans, "slow_scans", "1 to 2 scans a second"},
    {Family::short_range, "short_range", "a LiDAR of 3.5 to 5 m"},
    {Family::narrow_view, "narrow_view", "70 to 120 degrees of view"},
    {Family::missing_returns, "missing_returns", "30 to 70 % of the beams lost"},
    {Family::clutter, "clutter", "10 to 30 % of the hits on things that are not on the map"},
    {Family::furniture_moved, "furniture_moved", "5 to 20 % of the occupied cells changed"},
    {Family::doors, "doors", "20 to 60 % of the openings closed, as many new ones"},
    {Family::scale, "scale", "the map 1 % too large or too small"},
    {Family::slips, "slips", "slips and pushes of 5 to 40 degrees, 0.1 to 0.8 m, 1 to 6 a minute"},
    {Family::late_odometry, "late_odometry", "odometry up to 200 ms late or early"},
    {Family::long_steps, "long_steps", "1 to 2.5 m from scan to scan"},
    {Family::fast, "fast", "2.5 to 7 m/s"},
    {Family::corridor, "corridor", "70 m without features"},
    {Family::standing, "standing", "minutes of standing with a gyro that drifts"},
    {Family::kidnapped, "kidnapped", "somewhere else half-way"},
    {Family::wrong_map, "wrong_map", "localized on the map of another place"},
    {Family::unknown_start, "unknown_start", "nobody says where the robot is"},
};

const Entry& entry_of(Family family) {
  return kFamilies[static_cast<std::size_t>(family)];
}

}  // namespace

const std::vector<Family>& all_families() {
  static const std::vector<Family> families = [] {
    std::vector<Family> all;
    for (const Entry& e : kFamilies) all.push_back(e.family);
    return all;
  }();
  return families;
}

const char* name_of(Family family) {
  return entry_of(family).name;
}
const char* meaning_of(Family family) {
  return entry_of(family).meaning;
}

Family family_named(std::string_view name) {
  std::vector<std::string_view> names;
  for (const Entry& e : kFamilies) {
    if (name == e.name) return e.family;
    names.emplace_back(e.name);
  }
  throw Error(ErrorKind::usage, "unknown family '" + printable(name) + "'; the nearest one is '" +
                                    std::string(nearest_name(name, names)) + "'");
}

}  // namespace parloc
