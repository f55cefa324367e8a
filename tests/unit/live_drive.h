// A filter that is fed as on a live robot, for the tests of that.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>

#include "common/filter/particle_filter.h"
#include "tests/unit/small_drive.h"

namespace parloc {

class LiveDrive : public testing::Test {
 protected:
  const GridMap room = test::small_room();
  const test::SmallDrive drive = test::small_drive(room, 20);
  const Pose start = drive.truth.front().pose;

  ParticleFilter started(const FilterConfig& config) const {
    ParticleFilter filter(config, room);
    filter.start_at(start, 0.1, 0.1, 0.05);
    return filter;
  }
  Estimate step(ParticleFilter& filter, std::size_t k) const {
    return filter.step(drive.scans[k].odometry, drive.scans[k].scan);
  }
};

}  // namespace parloc
