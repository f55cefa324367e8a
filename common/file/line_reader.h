// Lines of a text file, plain or gzip, with bounded memory: what every text reader of parloc stands on.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>

namespace parloc {

/// Streams a file line by line. Memory: one line (at most max_line_bytes) and one block.
class LineReader {
 public:
  /// A line longer than this is skipped, and given out as an empty one: a robot log has lines of a few
  /// kilobytes.
  static constexpr std::size_t max_line_bytes = std::size_t{1} << 20;

  /// Plain or gzip, told apart by content. Throws Error{input} if the file cannot be opened or read.
  static LineReader from_file(const std::string& path);
  /// A file already in memory (plain text); `name` stands for it in messages.
  static LineReader from_text(std::string text, const std::string& name);

  LineReader(LineReader&&) noexcept;
  ~LineReader();

  /// The next line without its "\n" or "\r\n", the first without a byte-order mark; false at the end. The
  /// view is valid until the next call.
  bool next(std::string_view& line);

  const std::string& name() const { return name_; }
  std::size_t line() const { return line_; }  ///< 1 for the first; 0 before it.
  bool cut() const { return cut_; }           ///< The line was longer than max_line_bytes.
  bool terminated() const { return ended_; }  ///< False for a last line without a line end.
  /// Why reading ended before the end of the file (truncated or damaged gzip, read error); empty if it did
  /// not.
  const std::string& failure() const { return failure_; }
  /// Fraction read, 0 to 1; compressed bytes for gzip. Of a text: all of it.
  double progress() const;

 private:
  class File;
  explicit LineReader(std::string name);
  bool refill();
  void skip_rest_of_line();

  std::unique_ptr<File> file_;  ///< Null for a text, which is in the buffer as a whole.
  std::string name_;
  std::string buffer_;
  std::size_t begin_ = 0;  ///< Of the bytes in buffer_ not yet given out.
  std::size_t line_ = 0;
  bool cut_ = false;
  bool ended_ = false;
  bool at_end_ = false;
  std::string failure_;
};

}  // namespace parloc
