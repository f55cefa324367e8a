// A log that knows what has been read of it.
#pragma once

#include <string>

#include "common/io/log.h"
#include "common/math/sha256.h"

namespace parloc::tools::slam {

/// Passes another log's records on, and digests them: what a run depends on, not how the file spells it.
class DigestedLog final : public LogReader {
 public:
  explicit DigestedLog(LogReader& log) : log_(log) {}
  bool next(LogRecord& record) override;
  const LogWarnings& warnings() const override { return log_.warnings(); }
  double progress() const override { return log_.progress(); }
  /// Of all records so far, in hexadecimal.
  std::string digest() const { return sha_.hex(); }

 private:
  LogReader& log_;
  Sha256 sha_;
};

}  // namespace parloc::tools::slam
