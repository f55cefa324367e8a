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

/// Where bytes come from.
class LineReader::Source {
 public:
  virtual ~Source() = default;
  /// Up to `size` bytes; 0 at the end or at a failure, which it describes.
  virtual std::size_t read(char* to, std::size_t size, std::string& failure) = 0;
  virtual double progress() const = 0;
};

namespace {

// zlib reads a file without gzip's magic number as it is, so one path serves both.
class FileSource final : public LineReader::Source {
 public:
  explicit FileSource(const std::string& path) {
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
  FileSource(const FileSource&) = delete;
  FileSource& operator=(const FileSource&) = delete;
  ~FileSource() override { gzclose(file_); }

  std::size_t read(char* to, std::size_t size, std::string& failure) override {
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

  double progress() const override {
    if (at_end_) return 1.0;
    if (!(size_bytes_ > 0.0)) return 0.0;  // a pipe has no size
    return std::clamp(static_cast<double>(gzoffset(file_)) / size_bytes_, 0.0, 1.0);
  }

 private:
  gzFile file_ = nullptr;
  double size_bytes_ = 0.0;
  bool at_end_ = false;
};

class TextSource final : public LineReader::Source {
 public:
  explicit TextSource(std::string text) : text_(std::move(text)) {}

  std::size_t read(char* to, std::size_t size, std::string&) override {
    const std::size_t count = std::min(size, text_.size() - position_);
    std::copy_n(text_.data() + position_, count, to);
    position_ += count;
    return count;
  }

  double progress() const override {
    return text_.empty() ? 1.0 : static_cast<double>(position_) / static_cast<double>(text_.size());
  }

 private:
  std::string text_;
  std::size_t position_ = 0;
};

}  // namespace

LineReader::LineReader(std::unique_ptr<Source> source, std::string name)
    : source_(std::move(source)), name_(std::move(name)) {}
LineReader::LineReader(LineReader&&) noexcept = default;
LineReader::~LineReader() = default;

LineReader LineReader::from_file(const std::string& path) {
  LineReader reader(std::make_unique<FileSource>(path), path);
  // The first block is read here, so that a file that gives nothing at all is told at once.
  if (!reader.refill() && !reader.failure_.empty()) throw input_error(path, 0, reader.failure_);
  return reader;
}

LineReader LineReader::from_text(std::string text, const std::string& name) {
  return LineReader(std::make_unique<TextSource>(std::move(text)), name);
}

double LineReader::progress() const {
  return source_->progress();
}

// Appends a block to what is left of the last one; false when there is no more.
bool LineReader::refill() {
  if (at_end_) return false;
  buffer_.erase(0, begin_);
  begin_ = 0;
  const std::size_t kept = buffer_.size();
  buffer_.resize(kept + kBlockBytes);
  const std::size_t got = source_->read(buffer_.data() + kept, kBlockBytes, failure_);
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
  if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
  return true;
}

}  // namespace parloc
