#include "common/filter/filter_settings.h"

#include <fmt/format.h>

#include <limits>

#include "common/model/model_settings.h"

namespace parloc {
namespace {

const std::vector<Choice<EstimateMode>> kEstimateModes{{"mean", EstimateMode::mean},
                                                       {"cluster", EstimateMode::cluster}};

void add_settings(Settings& s, KldConfig& kld) {
  s.group("kld", "How many particles are enough, where min_particles is below max_particles (KLD-sampling).");
  s.add("pf_err", "Distance between the particles and what they stand for [nat]", kld.pf_err, {0.0001, 1});
  s.add("delta", "Probability of a larger distance", kld.delta, {1e-6, 0.5});
  s.add("pf_z", "The normal quantile 1 - delta itself, as nav2 has it; 0: from delta", kld.pf_z, {0, 5});
  s.add("bin_size_xy", "Side of a bin of poses [m]", kld.bin_size_xy, {0.01, 100});
  s.add("bin_size_theta", "... and its heading; a full turn has a whole number of them [rad]",
        kld.bin_size_theta, {0.01, 6.2832});
}

void add_settings(Settings& s, RecoveryConfig& recovery) {
  s.group("recovery", "What helps a filter that has lost its robot. Off by default.");
  s.add("recovery_alpha_slow", "Rate of the slow mean of a scan's likelihood; 0: off",
        recovery.recovery_alpha_slow, {0, 0.99});
  s.add("recovery_alpha_fast", "... of the fast one: below the slow, free space is tried",
        recovery.recovery_alpha_fast, {0, 0.99});
  s.add("recovery_margin", "... by so many times; 1: as soon as it is below (nav2)", recovery.recovery_margin,
        {1, 1000});
  s.add("expansion_likelihood", "Likelihood per beam that widens the cloud; 0: off",
        recovery.expansion_likelihood, {0, 1000});
  s.add("expansion_scans", "... after so many scans below it in a row", recovery.expansion_scans,
        {1, 100000});
  s.add("expansion_sigma_xy", "Noise of the first widening; grows by as much each [m]",
        recovery.expansion_sigma_xy, {0, 100});
  s.add("expansion_sigma_theta", "... of the heading [rad]", recovery.expansion_sigma_theta, {0, 10});
}

void add_settings(Settings& s, EstimateConfig& estimate) {
  s.group("estimate", "Which pose is reported.");
  s.add("mode", "The mean of all particles, or of their heaviest cluster", estimate.mode, kEstimateModes);
}

std::optional<Violation> particles_violation(const FilterConfig& c) {
  if (c.min_particles > c.most_particles()) {
    return Violation{"min_particles",
                     fmt::format("min_particles ({}) must not exceed {} ({})", c.min_particles,
                                 c.max_particles > 0 ? "max_particles" : "particles", c.most_particles())};
  }
  const double slow = c.recovery.recovery_alpha_slow, fast = c.recovery.recovery_alpha_fast;
  const bool off = slow == 0.0 && fast == 0.0;
  if (!off && !(slow > 0.0 && slow <= fast)) {
    return Violation{"recovery.recovery_alpha_slow",
                     fmt::format("recovery.recovery_alpha_slow ({}) must be above 0 and not above "
                                 "recovery.recovery_alpha_fast ({}), or both 0",
                                 slow, fast)};
  }
  return std::nullopt;
}

}  // namespace

void add_settings(Settings& s, ComputeConfig& compute) {
  s.add("backend", "auto takes a CUDA device if there is one", compute.backend, kBackends);
  s.add("threads", "CPU threads; 0: all cores", compute.threads, {0, 1024});
  s.add("device", "Which CUDA device, as parloc devices numbers them", compute.device, {0, 1023});
}

void add_seed(Settings& s, std::uint64_t& seed) {
  s.add("seed", "Seed of all random numbers: same seed, same answer", seed,
        {0, std::numeric_limits<std::uint64_t>::max()});
}

void add_settings(Settings& s, ResampleConfig& resample) {
  s.group("resample", "When and how particles are drawn anew.");
  s.add("scheme", "How particles are drawn", resample.scheme, kResampleSchemes);
  s.add("threshold", "Draw when N_eff < threshold * N; 1 or more: every step", resample.threshold, {0, 1000});
}

void add_settings(Settings& s, FilterConfig& c) {
  s.add("particles", "Number of particles", c.particles, {1, 16'777'216});
  s.add("min_particles", "Fewest, if the number is to adapt; 0: max_particles", c.min_particles,
        {0, 16'777'216});
  s.add("max_particles", "Most, and the number at the start; 0: as particles", c.max_particles,
        {0, 16'777'216});
  add_seed(s, c.seed);
  add_settings(s, static_cast<ComputeConfig&>(c));
  s.add("initial_sigma_xy", "Spread of a start pose given without one [m]", c.initial_sigma_xy, {0, 1000});
  s.add("initial_sigma_theta", "The same for its heading [rad]", c.initial_sigma_theta, {0, 10});
  s.add("update_min_d", "Weigh a scan after this much translation [m]; 0: no criterion", c.update_min_d,
        {0, 100});
  s.add("update_min_a", "... or after this much rotation [rad]; both 0: every scan", c.update_min_a,
        {0, 100});
  add_settings(s, c.motion);
  add_settings(s, c.scan);
  add_settings(s, c.sensor);
  add_settings(s, c.resample);
  add_settings(s, c.kld);
  add_settings(s, c.recovery);
  add_settings(s, c.estimate);
  s.named = named_settings(c.lidars);
}

std::optional<Violation> broken_rule(const StepConfig& config) {
  if (auto violation = broken_rule(config.scan)) return violation;
  return broken_rule(config.lidars, config.scan);
}

std::optional<Violation> broken_rule(const FilterConfig& config) {
  if (auto violation = broken_rule(static_cast<const StepConfig&>(config))) return violation;
  if (auto violation = particles_violation(config)) return violation;
  return broken_rule(config.sensor);
}

void validate(const FilterConfig& config) {
  FilterConfig copy = config;
  Settings settings;
  add_settings(settings, copy);
  require_none(first_beyond_limits(settings));
  require_none(broken_rule(config));
}

}  // namespace parloc
