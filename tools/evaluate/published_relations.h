// The relation errors that Kuemmerle et al. 2009 published: what `parloc evaluate --relations` prints beside
// its own.
#pragma once

#include <array>
#include <string>

namespace parloc::tools::evaluate {

/// Of the translation, over all relations of a log [m].
struct PublishedError {
  double mean_m, std_m;
};

inline constexpr std::array<const char*, 3> kPublishedMethods{"scan matching", "RBPF, 50 particles",
                                                              "graph mapping"};

struct PublishedLog {
  const char* name;  ///< For the command line.
  std::array<PublishedError, kPublishedMethods.size()> errors;
};

/// "On measuring the accuracy of SLAM algorithms", Autonomous Robots 27 (2009). The figures are taken from
/// two tabulations by others, which agree; they have not been checked against the paper itself.
inline constexpr const char* kPublishedSource = "Kuemmerle et al. 2009, as tabulated by others";

inline constexpr std::array<PublishedLog, 6> kPublishedLogs{{
    {"aces", {{{.173, .614}, {.060, .049}, {.044, .044}}}},
    {"intel", {{{.220, .296}, {.070, .083}, {.031, .026}}}},
    {"mit_killian", {{{1.651, 4.138}, {.122, .386}, {.050, .056}}}},
    {"mit_csail", {{{.106, .325}, {.049, .049}, {.004, .009}}}},
    {"freiburg_079", {{{.258, .427}, {.061, .044}, {.056, .042}}}},
    {"freiburg_hospital", {{{.434, 1.615}, {.637, 2.638}, {.143, .180}}}},
}};

/// Throws Error{usage} that names all of them.
const PublishedLog& published_log(const std::string& name);

}  // namespace parloc::tools::evaluate
