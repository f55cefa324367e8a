// The reader of bags of ROS 2 in SQLite on any bytes.
#include "tests/fuzz/bag_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::read_bag(data, size);
  return 0;
}
