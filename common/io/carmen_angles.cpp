#include "common/io/carmen_angles.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "common/math/angle_units.h"
#include "common/math/portable64.h"

namespace parloc {
namespace {

constexpr double kUrgStepDeg = 360.0 / 1024.0;
// A step written to fewer than three places of a radian says too little to tell two steps apart.
constexpr double kCoarsestStepRad = 0.0005;
// Beyond a quarter of it, a number is not another's rounding.
constexpr double kMostRounding = 0.25;

struct KnownCount {
  std::size_t beams;
  double step_deg;
  double view_deg;  // from the first beam to the last
};

// What GMapping and CARMEN take counts for that no half circle has. 540, 768 and 1080 leave the last end out.
constexpr std::array kKnownCounts = {
    KnownCount{540, 0.5, 269.5},
    KnownCount{541, 0.5, 270.0},
    KnownCount{682, kUrgStepDeg, 681.0 * kUrgStepDeg},
    KnownCount{683, kUrgStepDeg, 682.0 * kUrgStepDeg},
    KnownCount{768, kUrgStepDeg, 767.0 * kUrgStepDeg},
    KnownCount{769, kUrgStepDeg, 768.0 * kUrgStepDeg},
    KnownCount{1080, 0.25, 269.75},
    KnownCount{1081, 0.25, 270.0},
};

// The first beam where an even count leaves the last end of a whole view out: 360 of 0.5 degrees begin at
// -90.
double whole_view_deg(const KnownCount& known) {
  const double whole = known.view_deg + known.step_deg;
  return known.beams % 2 == 0 && std::fmod(whole, 10.0) == 0.0 ? whole : known.view_deg;
}

BeamAngles half_circle(std::size_t beams) {
  if (beams == 1) return {};
  return {-kPi / 2.0, kPi / static_cast<double>(beams % 2 == 0 ? beams : beams - 1)};
}

// Half circles that some device has: steps of whole degrees, and the finer ones that are sold.
bool is_common_half_circle(std::size_t beams) {
  if (beams == 1) return true;
  const std::size_t steps = beams % 2 == 0 ? beams : beams - 1;
  constexpr std::array<std::size_t, 6> finer = {360, 512, 720, 900, 1440, 1800};
  return 180 % steps == 0 || std::find(finer.begin(), finer.end(), steps) != finer.end();
}

struct CountAngles {
  BeamAngles angles;
  bool known = false;
};

CountAngles angles_without_statement(std::size_t beams) {
  for (const KnownCount& known : kKnownCounts)
    if (known.beams == beams)
      return {{-0.5 * whole_view_deg(known) * kRadPerDeg, known.step_deg * kRadPerDeg, {}}, true};
  return {half_circle(beams), is_common_half_circle(beams)};
}

bool rounds_to(double exact_rad, const StatedAngle& stated) {
  const double tolerance = std::min(stated.rounding_rad, kMostRounding * std::fabs(stated.rad)) + 1e-9;
  return std::fabs(std::fabs(exact_rad) - std::fabs(stated.rad)) <= tolerance;
}

bool step_rounds_to(double exact_rad, const StatedAngle& step) {
  return rounds_to(exact_rad, {step.rad, step.rounding_rad > kCoarsestStepRad ? 1e-6 : step.rounding_rad});
}

// Whether a field of view, counted either way, is that of these angles.
bool is_view(const BeamAngles& angles, std::size_t beams, const StatedAngle& fov) {
  const double n = static_cast<double>(beams);
  return rounds_to(angles.step_rad * (n - 1.0), fov) || rounds_to(angles.step_rad * n, fov);
}

// The step alone: about the middle, but for an even count that fills a whole view and leaves its end out.
BeamAngles from_step(std::size_t beams, const StatedAngle& step) {
  const double n = static_cast<double>(beams);
  const double whole_deg = n * step.rad / kRadPerDeg;
  const double tens_deg = 10.0 * std::round(whole_deg / 10.0);
  const bool end_left_out = beams % 2 == 0 && std::fabs(whole_deg - tens_deg) <= 1e-6;
  return {-0.5 * step.rad * (end_left_out ? n : n - 1.0), beams == 1 ? 0.0 : step.rad, {}};
}

BeamAngles from_view(std::size_t beams, const StatedAngle& fov) {
  if (beams == 1) return {};
  return {-0.5 * fov.rad, fov.rad / static_cast<double>(beams % 2 == 0 ? beams : beams - 1), {}};
}

BeamAngles from_both(std::size_t beams, const StatedAngle& fov, const StatedAngle& step,
                     const BeamAngles& by_count) {
  if (beams == 1) return {};
  const double n = static_cast<double>(beams);
  const double step_rad = beam_step_rad(fov, step, beams);
  if (rounds_to(step_rad * (n - 1.0), fov) || rounds_to(step_rad * n, fov))
    return {-0.5 * fov.rad, step_rad, {}};
  const bool view = is_view(by_count, beams, fov), same_step = step_rounds_to(by_count.step_rad, step);
  BeamAngles angles = view || same_step ? by_count : from_step(beams, step);
  angles.doubt = fmt::format("PARAM lines state {:g} degrees in steps of {:g}, which {} beams do not have",
                             fov.rad / kRadPerDeg, step.rad / kRadPerDeg, beams);
  return angles;
}

}  // namespace

double half_last_place(std::string_view number) {
  const std::size_t exponent_at = number.find_first_of("eE");
  const std::string_view mantissa = number.substr(0, exponent_at);
  const std::size_t point = mantissa.find('.');
  int places = point == std::string_view::npos ? 0 : static_cast<int>(mantissa.size() - point - 1);
  if (exponent_at != std::string_view::npos) {
    int exponent = 0;
    std::size_t i = exponent_at + 1;
    const bool negative = i < number.size() && number[i] == '-';
    if (i < number.size() && (number[i] == '-' || number[i] == '+')) ++i;
    for (; i < number.size() && number[i] >= '0' && number[i] <= '9' && exponent < 1000; ++i)
      exponent = 10 * exponent + (number[i] - '0');
    places -= negative ? -exponent : exponent;
  }
  return 0.5 * std::pow(10.0, -std::clamp(places, -300, 300));
}

double beam_step_rad(const StatedAngle& fov, const StatedAngle& step, std::size_t beams) {
  if (beams < 2) return step.rad;
  const double n = static_cast<double>(beams);
  const double both_ends = fov.rad / (n - 1.0);
  const double one_end = fov.rad / n;
  if (step.rad == 0.0) return both_ends;
  const bool first = std::fabs(both_ends - step.rad) <= std::fabs(one_end - step.rad);
  const double closer = first ? both_ends : one_end;
  if (std::fabs(closer - step.rad) <= 1e-6) return closer;
  if (step.rounding_rad > kCoarsestStepRad) return step.rad;
  // Fewer places: both may round to it. CARMEN and ROS count both ends; but a whole turn's ends are the same
  // beam, which no device measures twice.
  const StatedAngle loose{step.rad, step.rounding_rad + fov.rounding_rad / n};
  const bool both_fit = rounds_to(both_ends, loose), one_fits = rounds_to(one_end, loose);
  const bool whole_turn = rounds_to(2.0 * kPi, {fov.rad, fov.rounding_rad + 1e-6});
  if (one_fits && (whole_turn || !both_fit)) return one_end;
  return both_fit ? both_ends : step.rad;
}

BeamAngles angles_of_count(std::size_t beams, const std::optional<StatedAngle>& fov,
                           const std::optional<StatedAngle>& step) {
  CountAngles by_count = angles_without_statement(beams);
  const BeamAngles& angles = by_count.angles;
  if (!fov && !step) {
    if (!by_count.known)
      by_count.angles.doubt = fmt::format("{} beams are no half circle that a known device has", beams);
    return by_count.angles;
  }
  // Statements that are roundings of what the count says add nothing to it.
  const bool view = !fov || is_view(angles, beams, *fov),
             same_step = !step || step_rounds_to(angles.step_rad, *step);
  if (view && same_step) return angles;
  if (!step) return from_view(beams, *fov);
  return fov ? from_both(beams, *fov, *step, angles) : from_step(beams, *step);
}

}  // namespace parloc
