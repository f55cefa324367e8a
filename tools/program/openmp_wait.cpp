#include "tools/program/openmp_wait.h"

#include <unistd.h>

#include <cstdlib>

namespace parloc::tools {

void wait_briefly(char** argv) {
  constexpr const char* kSpins = "3000";  // about 0.03 ms
  if (std::getenv("GOMP_SPINCOUNT") != nullptr || std::getenv("OMP_WAIT_POLICY") != nullptr) return;
  if (setenv("GOMP_SPINCOUNT", kSpins, 1) != 0) return;
  execv("/proc/self/exe", argv);
}

}  // namespace parloc::tools
