// Names of kernels and variables, as the tables of the written modules have them.
#pragma once

#include <string>

namespace ptx {

/// A mangled name without the numbers that nvcc makes of the file's path (generator/write.py).
std::string plain_name(const std::string& name);
/// For people: demangled, without the wrapper around parloc's functors and without arguments.
std::string readable_name(const std::string& name);

}  // namespace ptx
