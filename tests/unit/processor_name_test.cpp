#include "common/file/processor_name.h"

#include <gtest/gtest.h>

#include <sstream>

namespace parloc {
namespace {

std::string name_of(const std::string& cpuinfo, const std::string& board = "") {
  std::istringstream text(cpuinfo);
  return processor_name(text, board);
}

TEST(ProcessorName, OnX86ItIsTheModelsName) {
  EXPECT_EQ(
      name_of("processor\t: 0\nmodel\t\t: 85\nmodel name\t: Intel(R) Xeon(R) CPU\nmodel name\t: other\n"),
      "Intel(R) Xeon(R) CPU");
}

TEST(ProcessorName, OnArmItIsTheCoresAndTheBoard) {
  const std::string pi =
      "processor\t: 0\nBogoMIPS\t: 108.00\nCPU implementer\t: 0x41\nCPU architecture: 8\nCPU part\t: 0xd08\n"
      "processor\t: 1\nCPU implementer\t: 0x41\nCPU part\t: 0xd08\n";
  EXPECT_EQ(name_of(pi), "Cortex-A72");
  EXPECT_EQ(name_of(pi, "Raspberry Pi 4 Model B Rev 1.4"), "Cortex-A72, Raspberry Pi 4 Model B Rev 1.4");
}

TEST(ProcessorName, UnlikeCoresAreAllNamedAndUnknownOnesByNumber) {
  EXPECT_EQ(
      name_of("model name\t: ARMv8 Processor rev 0 (v8l)\nCPU implementer\t: 0x41\nCPU part\t: 0xd05\n"
              "CPU implementer\t: 0x41\nCPU part\t: 0xd0b\nCPU implementer\t: 0x99\nCPU part\t: 0x123\n"),
      "Cortex-A55 and Cortex-A76 and ARM implementer 0x99 part 0x123");
}

TEST(ProcessorName, ABoardSaysMoreThanNothing) {
  EXPECT_EQ(name_of("", "A board"), "A board");
  EXPECT_EQ(name_of(""), "unknown processor");
}

}  // namespace
}  // namespace parloc
