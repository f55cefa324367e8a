// Values of results as bytes: the same list of fields is put and got.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>

#include "common/file/bytes.h"

namespace parloc::tools::shards {

struct PutValue {
  ByteWriter& w;
  void operator()(double value) const { w.put(value); }
  void operator()(std::size_t value) const { w.put_count(value); }
  void operator()(bool value) const { w.put_bool(value); }
  void operator()(const std::string& text) const { w.put_text(text); }
  void operator()(const std::optional<double>& value) const {
    w.put_bool(value.has_value());
    w.put(value.value_or(0.0));
  }
};
struct GetValue {
  ByteReader& r;
  void operator()(double& value) const { value = r.get<double>(); }
  void operator()(std::size_t& value) const { value = r.get<std::uint64_t>(); }
  void operator()(bool& value) const { value = r.get_bool(); }
  void operator()(std::string& text) const { text = r.get_text(); }
  void operator()(std::optional<double>& value) const {
    const bool known = r.get_bool();
    const auto number = r.get<double>();
    value = known ? std::optional(number) : std::nullopt;
  }
};

}  // namespace parloc::tools::shards
