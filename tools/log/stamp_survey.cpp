#include "tools/log/stamp_survey.h"

#include <algorithm>

namespace parloc::tools {

namespace {
constexpr std::size_t kMostKept = std::size_t{1} << 16;
}

void StampSurvey::add(double stamp_s) {
  if (++count_ == 1) {
    first_s_ = last_s_ = before_s_ = stamp_s;
    return;
  }
  first_s_ = std::min(first_s_, stamp_s);
  last_s_ = std::max(last_s_, stamp_s);
  const double step_s = stamp_s - before_s_;
  if (step_s < 0.0) ++backward_;
  if (step_s == 0.0) ++repeated_;
  if (step_s > longest_.length_s) longest_ = {step_s, before_s_};
  before_s_ = stamp_s;
  if (step_s <= 0.0 || ++since_kept_ < every_) return;
  since_kept_ = 0;
  steps_s_.push_back(static_cast<float>(step_s));
  if (steps_s_.size() < kMostKept) return;
  for (std::size_t k = 0; k < kMostKept / 2; ++k) steps_s_[k] = steps_s_[2 * k + 1];
  steps_s_.resize(kMostKept / 2);
  every_ *= 2;
}

std::optional<double> StampSurvey::period_s() const {
  if (steps_s_.empty()) return std::nullopt;
  std::vector<float> sorted = steps_s_;
  const auto middle = sorted.begin() + static_cast<std::ptrdiff_t>(sorted.size() / 2);
  std::nth_element(sorted.begin(), middle, sorted.end());
  return *middle;
}

std::optional<double> StampSurvey::mean_rate_hz() const {
  const double time_s = last_s_ - first_s_;
  if (count_ < 3 || time_s < 1.0) return std::nullopt;
  return static_cast<double>(count_ - 1) / time_s;
}

}  // namespace parloc::tools
