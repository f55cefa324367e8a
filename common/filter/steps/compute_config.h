// Where the work is done. Results do not depend on it, to the bit.
#pragma once

namespace parloc {

enum class BackendChoice { automatic, cpu, cuda };

struct ComputeConfig {
  BackendChoice backend = BackendChoice::automatic;
  int threads = 0;  ///< CPU: 0 is all cores.
  int device = 0;   ///< Which CUDA device, as `parloc devices` numbers them.
};

}  // namespace parloc
