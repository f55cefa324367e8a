// Several files that are one bag.
#pragma once

#include <memory>
#include <string>

#include "common/bag/bag.h"

namespace parloc {

/// The files that metadata.yaml lists, in its order, or else all bags in the folder in the order of their
/// names (the numbers in them by value). Throws Error{input} if there is none.
std::unique_ptr<BagReader> open_bag_folder(const std::string& path);

/// The bag with one fault more.
std::unique_ptr<BagReader> with_fault(std::unique_ptr<BagReader> bag, const std::string& what);

}  // namespace parloc
