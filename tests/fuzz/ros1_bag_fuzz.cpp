// The reader of bags of ROS 1 on any bytes.
#include "tests/fuzz/bag_fuzz.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  parloc::fuzz::read_bag(data, size);
  return 0;
}
