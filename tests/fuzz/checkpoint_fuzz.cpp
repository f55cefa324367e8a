// Any bytes are a state of grid SLAM that can be gone on from, or an Error{input} of one line. Tried as they
// are, and as the content of a checkpoint whose checksum fits.
#include "common/file/bytes.h"
#include "common/slam/checkpoint_values.h"
#include "common/slam/grid_slam.h"
#include "tests/fuzz/one_line.h"

namespace {

/// A step of a large map takes long, and is another test's matter.
bool is_small(const parloc::GridSlamConfig& c) {
  return c.slam.particles <= 8 && c.slam.resolution >= 0.05 && c.slam.usable_range <= 10.0 &&
         c.scan.max_beams <= 200;
}

parloc::Scan some_scan() {
  parloc::Scan scan{.stamp_s = 200.0, .angle_step_rad = 0.1, .range_max_m = 8.0, .scan_time_s = 0.05};
  for (int k = 0; k < 60; ++k) scan.ranges_m.push_back(0.5f + 0.03f * static_cast<float>(k));
  return scan;
}

void go_on(std::string bytes) {
  parloc::fuzz::reads_or_says_why(parloc::ErrorKind::input, [&] {
    parloc::SlamCheckpoint checkpoint(std::move(bytes), "fuzz");
    checkpoint.config.backend = parloc::BackendChoice::cpu;
    checkpoint.config.threads = 1;
    const bool small = is_small(checkpoint.config);
    parloc::GridSlam slam(std::move(checkpoint));
    if (small) slam.step({1.0, 0.5, 0.1}, some_scan());
    (void)slam.trajectory();
    (void)slam.distinct_ancestors();
    if (small && !slam.records().empty()) (void)slam.map();
  });
}

std::string sealed(const std::string& content) {
  std::string out;
  parloc::ByteWriter w(
      [&](const void* from, std::size_t n) { out.append(static_cast<const char*>(from), n); });
  parloc::put_checkpoint_begin(w);
  w.put_bytes(content.data(), content.size());
  parloc::put_checkpoint_end(w);
  return out;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = parloc::fuzz::text_of(data, size);
  go_on(bytes);
  go_on(sealed(bytes));
  return 0;
}
