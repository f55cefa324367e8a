// What is measured: an algorithm, on some threads or on a device.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "common/filter/filter_backend.h"

namespace parloc::tools::bench {

enum class Algorithm {
  paz2012,  ///< As Paz et al. 2012 describe it: fixed-step rays, multinomial resampling by linear search. Run
            ///< here: the figures that they published are in published.h.
  parloc,   ///< Exact rays by skipping, systematic resampling.
};
inline constexpr std::array<const char*, 2> kAlgorithmNames{"paz2012", "parloc"};

struct Variant {
  Algorithm algorithm = Algorithm::parloc;
  BackendChoice backend = BackendChoice::cpu;
  int threads = 1;                            ///< CPU.
  int device = 0;                             ///< CUDA.
  SensorModel model = SensorModel::gaussian;  ///< Others only beside other programs, with their own defaults.

  bool operator==(const Variant&) const = default;
};

/// "1 thread", "2 threads", "cuda 0".
std::string place_of(const Variant& variant);
/// "parloc, 2 threads".
std::string name_of(const Variant& variant);

/// Settings of the filter: the Gaussian sensor of configs/paz2012.yaml. Both algorithms resample in every
/// step, as the paper does, so that both do the same work.
FilterBackendConfig backend_config(const Variant& variant, std::int64_t particles);

struct VariantChoice {
  std::vector<Variant> variants;
  std::vector<std::string> notes;  ///< What is not measured, and why.
};

/// On the CPU with one thread and with all (`threads`; 0: all cores), and for `parloc` on every CUDA device
/// that answers and can run a step.
VariantChoice choose_variants(const std::vector<Algorithm>& algorithms, int threads);

/// The CUDA devices that can run a step, as variants of `parloc`; the others are in the notes.
VariantChoice cuda_variants();

}  // namespace parloc::tools::bench
