// Results of many trials, which need not all be in memory.
#pragma once

#include <cstddef>
#include <functional>
#include <memory>
#include <utility>
#include <vector>

namespace parloc {

/// Results in the order of their trials, to be gone through as often as one likes.
template <class Result>
class ResultStream {
 public:
  using Visit = std::function<void(const Result&)>;

  ResultStream() : ResultStream(std::vector<Result>{}) {}
  /// Those of a vector.
  ResultStream(std::vector<Result> all)  // NOLINT(google-explicit-constructor): it is the same thing
      : size_(all.size()),
        each_([kept = std::make_shared<std::vector<Result>>(std::move(all))](const Visit& visit) {
          for (const Result& result : *kept) visit(result);
        }) {}
  /// `each` calls with `size` results, the same ones in the same order every time. May throw Error.
  ResultStream(std::size_t size, std::function<void(const Visit&)> each)
      : size_(size), each_(std::move(each)) {}

  std::size_t size() const { return size_; }
  bool empty() const { return size_ == 0; }
  void each(const Visit& visit) const { each_(visit); }

 private:
  std::size_t size_;
  std::function<void(const Visit&)> each_;
};

}  // namespace parloc
