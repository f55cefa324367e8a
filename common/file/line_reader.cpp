#include "common/file/line_reader.h"

#include <zlib.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <utility>

#include "common/error.h"

namespace parloc {

namespace {
constexpr std::size_t kBlockBytes = std::size_t{1} << 16;
}

// zlib reads a file without gzip's magic number as it is, so one path serves both.
class LineReader::File {
 public:
  explicit File(const std::string& path) {
    std::error_code none;
    const auto status = std::filesystem::status(path, none);
    if (std::filesystem::is_directory(status)) {
      throw input_error(path, 0, "expected a file, found a folder");
    }
    if (std::filesystem::is_regular_file(status)) {
      size_bytes_ = static_cast<double>(std::filesystem::file_size(path, none));
    }
    errno = 0;
    file_ = gzopen(path.c_str(), "rb");
    if (file_ == nullptr) {
      throw input_error(path, 0,
                        std::string("cannot be opened: ") + std::strerror(errno != 0 ? errno : ENOMEM));
    }
    gzbuffer(file_, kBlockBytes);
  }
  File(const File&) = delete;
  File& operator=(const File&) = delete;
  ~File() { gzclose(file_); }

  /// Up to `size` bytes; 0 at the end or at a failure, which it describes.
  std::size_t read(char* to, std::size_t size, std::string& failure) {
    const int got = gzread(file_, to, static_cast<unsigned>(size));
    if (got > 0) return static_cast<std::size_t>(got);
    int code = Z_OK;
    const char* text = gzerror(file_, &code);
    if (code == Z_BUF_ERROR) {
      failure = "gzip data ends too early";
    } else if (code == Z_ERRNO) {
      failure = std::string("cannot be read: ") + std::strerror(errno);
    } else if (code != Z_OK && code != Z_STREAM_END) {
      failure = std::string("damaged gzip data: ") + text;
    }
    at_end_ = true;
    return 0;
  }

  double progress() const {
    if (at_end_) return 1.0;
    if (!(size_bytes_ > 0.0)) return 0.0;  // a pipe has no size
    return std::clamp(static_cast<double>(gzoffset(file_)) / size_bytes_, 0.0, 1.0);
  }

 private:
  gzFile file_ = nullptr;
  double size_bytes_ = 0.0;
  bool at_end_ = false;
};

LineReader::LineReader(std::string name) : name_(std::move(name)) {}
LineReader::LineReader(LineReader&&) noexcept = default;
LineReader::~LineReader() = default;

LineReader LineReader::from_file(const std::string& path) {
  LineReader reader(path);
  reader.file_ = std::make_unique<File>(path);
  // The first block is read here, so that a file that gives nothing at all is told at once.
  if (!reader.refill() && !reader.failure_.empty()) throw input_error(path, 0, reader.failure_);
  return reader;
}

LineReader LineReader::from_text(std::string text, const std::string& name) {
  LineReader reader(name);
  reader.buffer_ = std::move(text);
  reader.at_end_ = true;
  return reader;
}

double LineReader::progress() const {
  return file_ != nullptr ? file_->progress() : 1.0;
}

// Appends a block to what is left of the last one; false when there is no more.
bool LineReader::refill() {
  if (at_end_) return false;
  buffer_.erase(0, begin_);
  begin_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + kBlockBytes);
  const std::size_t got = file_->read(buffer_.data() + kept, kBlockBytes, failure_);
  buffer_.resize(kept + got);
  at_end_ = got == 0;
  return !at_end_;
}

void LineReader::skip_rest_of_line() {
  for (;;) {
    const std::size_t end = buffer_.find('\n', begin_);
    if (end != std::string::npos) {
      begin_ = end + 1;
      ended_ = true;
      return;
    }
    begin_ = buffer_.size();
    if (!refill()) return;
  }
}

bool LineReader::next(std::string_view& line) {
  line = {};
  cut_ = ended_ = false;
  std::size_t end = buffer_.find('\n', begin_);
  while (end == std::string::npos && buffer_.size() - begin_ <= max_line_bytes) {
    const std::size_t pending = buffer_.size() - begin_;
    if (!refill()) break;
    end = buffer_.find('\n', begin_ + pending);
  }
  if (end == std::string::npos && begin_ == buffer_.size()) return false;
  ++line_;
  if (std::min(end, buffer_.size()) - begin_ > max_line_bytes) {
    cut_ = true;
    skip_rest_of_line();
    return true;  // nothing of such a line is of use
  }
  ended_ = end != std::string::npos;
  const std::size_t stop = ended_ ? end : buffer_.size();
  line = std::string_view(buffer_).substr(begin_, stop - begin_);
  begin_ = ended_ ? stop + 1 : stop;
  // Editors of one system begin a text with a byte-order mark, which UTF-8 has no use for.
  constexpr std::string_view mark = "\xEF\xBB\xBF";
  if (line_ == 1 && line.substr(0, mark.size()) == mark) line.remove_prefix(mark.size());
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

}  // namespace parloc
