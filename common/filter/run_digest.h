// What a run's digest holds: every step's estimate, and the particles at its end.
#pragma once

#include <string>

#include "common/filter/filter_backend.h"
#include "common/filter/particle_filter.h"
#include "common/math/sha256.h"

namespace parloc {

class RunDigest {
 public:
  void add(const Estimate& e) {
    for (const double v : {e.pose.x_m, e.pose.y_m, e.pose.theta_rad, e.n_eff}) estimates_.add(v);
    for (const double v : e.covariance.v) estimates_.add(v);
  }
  /// SHA-256, hex; the particles by slot.
  std::string hex_with(const ParticleSet& set) const {
    Sha256 sha = estimates_;
    for (const auto* values : {&set.x, &set.y, &set.theta, &set.log_weight})
      for (const float v : *values) sha.add(v);
    return sha.hex();
  }

 private:
  Sha256 estimates_;
};

}  // namespace parloc
