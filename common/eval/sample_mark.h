// What statistics over many trials keep of a sample: four bytes.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace parloc {

/// Whether a probability that was given was right, and how long the step took. A probability is kept to
/// 1/65535: those that differ by less are ties (AUC). A time is kept to 0.1 %.
class SampleMark {
 public:
  static constexpr std::uint32_t kProbabilities = 65536, kTimes = 16384;

  SampleMark(double probability, bool right, double step_ms, bool searched)
      : bits_(probability_place(probability) | (right ? kRight : 0) | (searched ? kSearched : 0) |
              time_place(step_ms) << 18) {}
  explicit SampleMark(std::uint32_t bits) : bits_(bits) {}

  std::uint32_t bits() const { return bits_; }
  bool right() const { return (bits_ & kRight) != 0; }
  bool searched() const { return (bits_ & kSearched) != 0; }
  /// From 0 to kProbabilities - 1.
  std::uint32_t probability_place() const { return bits_ & 0xffff; }
  /// From 0 to kTimes - 1: logarithmic.
  std::uint32_t time_place() const { return bits_ >> 18; }

  static double probability_at(std::uint32_t place) { return place / (kProbabilities - 1.0); }
  static std::uint32_t probability_place(double probability) {
    return static_cast<std::uint32_t>(
        std::lround(std::clamp(probability, 0.0, 1.0) * (kProbabilities - 1.0)));
  }
  static double time_ms_at(std::uint32_t place) { return kLeast_ms * std::exp(place / kPerE); }

 private:
  static constexpr std::uint32_t kRight = 1u << 16, kSearched = 1u << 17;
  static constexpr double kLeast_ms = 1e-4, kPerE = 700.0;  // up to 1e6 ms

  static std::uint32_t time_place(double step_ms) {
    const double place = std::round(kPerE * std::log(std::max(step_ms, kLeast_ms) / kLeast_ms));
    return static_cast<std::uint32_t>(std::min(place, kTimes - 1.0));
  }

  std::uint32_t bits_;
};

}  // namespace parloc
