// Where the work is done. Results do not depend on it, to the bit.
#pragma once

namespace parloc {

/// What runs the steps.
enum class BackendChoice {
  automatic,  ///< A CUDA device if this build can use one, else the CPU.
  cpu,        ///< OpenMP.
  cuda,       ///< Throws Error{backend} where there is none.
};

/// Which processor works, and with how many threads.
struct ComputeConfig {
  BackendChoice backend = BackendChoice::automatic;  ///< CPU or CUDA.
  int threads = 0;                                   ///< CPU: 0 is all cores.
  int device = 0;                                    ///< Which CUDA device, as `parloc devices` numbers them.
};

}  // namespace parloc
