// The times of a stream of messages: how often they come, where they stop.
#pragma once

#include <cstddef>
#include <optional>
#include <vector>

namespace parloc::tools {

class StampSurvey {
 public:
  void add(double stamp_s);

  std::size_t count() const { return count_; }
  double first_s() const { return first_s_; }         ///< The least stamp.
  double last_s() const { return last_s_; }           ///< The greatest.
  std::size_t backward() const { return backward_; }  ///< Before that of the message before.
  std::size_t repeated() const { return repeated_; }  ///< The same as that of the message before.
  /// The median time from one to the next that is later; nothing for fewer than two.
  std::optional<double> period_s() const;

  /// Over the whole time; nothing for fewer than three, or within less than a second.
  std::optional<double> mean_rate_hz() const;

  struct Gap {
    double length_s = 0.0, at_s = 0.0;  ///< From the stamp `at_s` on.
  };
  /// The longest; it is worth a word where it is several periods.
  Gap longest_gap() const { return longest_; }

 private:
  std::size_t count_ = 0, backward_ = 0, repeated_ = 0;
  double first_s_ = 0.0, last_s_ = 0.0, before_s_ = 0.0;
  std::vector<float> steps_s_;  ///< Every so many of them: the median of an even sample.
  std::size_t every_ = 1, since_kept_ = 0;
  Gap longest_;
};

}  // namespace parloc::tools
