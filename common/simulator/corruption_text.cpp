// Corruptions of odometry as a command line has them.
#include <fmt/format.h>

#include <charconv>
#include <set>
#include <string_view>
#include <system_error>
#include <vector>

#include "common/error.h"
#include "common/file/nearest_name.h"
#include "common/math/angle_units.h"
#include "common/math/portable64.h"
#include "common/simulator/corrupt_odometry.h"

namespace parloc {
namespace {

/// A key, the value that it sets, and in which unit and limits it is written.
struct Key {
  std::string_view name;
  double OdometryCorruption::*value;
  double unit;  // of what is written, in that of the value
  double low, high;
  double OdometryCorruption::*upper = nullptr;  // of a range, written from:to
};

using C = OdometryCorruption;
constexpr Key kKeys[] = {
    {"noise_trans", &C::noise_translation, 1.0, 0.0, 10.0},
    {"noise_rot", &C::noise_rotation, 1.0, 0.0, 10.0},
    {"noise_rot_per_m", &C::noise_rotation_per_m, 1.0, 0.0, 10.0},
    {"scale_trans", &C::scale_translation, 1.0, 0.1, 10.0},
    {"scale_rot", &C::scale_rotation, 1.0, 0.1, 10.0},
    {"drift", &C::drift_rad_per_m, kRadPerDeg, -360.0, 360.0},
    {"gyro_drift", &C::gyro_drift_rad_per_s, kRadPerDeg / 60.0, -3600.0, 3600.0},
    {"slips", &C::slips_per_min, 1.0, 0.0, 1000.0},
    {"hide", &C::hidden_per_min, 1.0, 0.0, 1000.0},
    {"slip_deg", &C::least_slip_rad, kRadPerDeg, 0.001, 180.0, &C::most_slip_rad},
    {"slip_m", &C::least_slip_m, 1.0, 0.001, 100.0, &C::most_slip_m},
    {"resets", &C::resets_per_min, 1.0, 0.0, 1000.0},
    {"offset_ms", &C::offset_s, 1e-3, -1000.0, 1000.0},
};
constexpr std::string_view kThin = "thin", kSlipKind = "slip_kind";

Error usage(std::string_view key, std::string_view expected, std::string_view got) {
  return Error(ErrorKind::usage,
               fmt::format("--corrupt: {}: expected {}, got '{}'", key, expected, printable(got)));
}

double number(std::string_view key, std::string_view text, double low, double high) {
  double value = 0.0;
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (status != std::errc() || end != text.data() + text.size() || !(value >= low && value <= high))
    throw usage(key, fmt::format("a number from {:g} to {:g}", low, high), text);
  return value;
}

/// "8:20", or one number for both.
void read_value(const Key& key, std::string_view text, OdometryCorruption& c) {
  const std::size_t colon = key.upper == nullptr ? std::string_view::npos : text.find(':');
  c.*key.value = key.unit * number(key.name, text.substr(0, colon), key.low, key.high);
  if (key.upper == nullptr) return;
  c.*key.upper = colon == std::string_view::npos
                     ? c.*key.value
                     : key.unit * number(key.name, text.substr(colon + 1), key.low, key.high);
  if (c.*key.value > c.*key.upper) throw usage(key.name, "from:to, the smaller first", text);
}

void read_slip_kind(std::string_view text, OdometryCorruption& c) {
  if (text == "both") {
    c.slip_kind = C::Slip::both;
  } else if (text == "rotation") {
    c.slip_kind = C::Slip::rotation;
  } else if (text == "translation") {
    c.slip_kind = C::Slip::translation;
  } else {
    throw usage(kSlipKind, "both, rotation or translation", text);
  }
}

void read_thin(std::string_view text, OdometryCorruption& c) {
  const auto [end, status] = std::from_chars(text.data(), text.data() + text.size(), c.keep_every);
  if (status != std::errc() || end != text.data() + text.size() || c.keep_every < 1 || c.keep_every > 100000)
    throw usage(kThin, "a whole number from 1 to 100000", text);
}

void read_key(std::string_view name, std::string_view text, OdometryCorruption& c) {
  if (name == kThin) return read_thin(text, c);
  if (name == kSlipKind) return read_slip_kind(text, c);
  std::vector<std::string_view> names{kThin, kSlipKind};
  for (const Key& key : kKeys) {
    if (name == key.name) return read_value(key, text, c);
    names.push_back(key.name);
  }
  throw Error(ErrorKind::usage, "--corrupt: " + unknown_key_message(name, nearest_name(name, names)));
}

}  // namespace

OdometryCorruption corruption_from_text(const std::string& text) {
  OdometryCorruption c;
  std::set<std::string_view> seen;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t comma = rest.find(',');
    const std::string_view part = rest.substr(0, comma);
    rest = comma == std::string_view::npos ? std::string_view() : rest.substr(comma + 1);
    const std::size_t equals = part.find('=');
    if (equals == std::string_view::npos) throw usage(printable(part), "key=value", part);
    const std::string_view name = part.substr(0, equals);
    read_key(name, part.substr(equals + 1), c);
    if (!seen.insert(name).second)
      throw Error(ErrorKind::usage, fmt::format("--corrupt: {} comes twice", name));
  }
  return c;
}

}  // namespace parloc
