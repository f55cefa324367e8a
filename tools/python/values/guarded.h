// Filters as Python holds them: steps run without Python's lock, and one at a time.
#pragma once

#include <nanobind/nanobind.h>

#include <mutex>
#include <utility>

#include "common/config/config.h"

namespace parloc::python {

/// A filter is not thread-safe, Python's threads know nothing of that: what one does with it, another waits
/// for.
template <class Filter>
class Guarded {
 public:
  /// make(config) gives the filter.
  template <class Make>
  Guarded(Config config, const Make& make) : config_(std::move(config)), filter_(make(config_)) {}

  /// use(Filter&), which touches nothing of Python's, while other threads of Python run.
  template <class Use>
  auto use(Use use) {
    const nanobind::gil_scoped_release others_run;
    const std::lock_guard mine(mutex_);
    return use(filter_);
  }
  const Config& config() const { return config_; }

 private:
  const Config config_;
  std::mutex mutex_;
  Filter filter_;
};

}  // namespace parloc::python
