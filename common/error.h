// The one exception type that reaches a user, with the exit code that the program gives for it.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace parloc {

/// What went wrong. The value is the exit code of the `parloc` program (docs/exit_codes.md).
enum class ErrorKind {
  internal = 1,  ///< A defect in parloc, or a device that failed.
  usage = 2,     ///< The command line is wrong, or calls of the library are in a wrong order.
  input = 3,     ///< A map, log or trajectory cannot be read or makes no sense.
  config = 4,    ///< A configuration has an unknown key, a wrong type or an impossible value.
  output = 5,    ///< A result cannot be written.
  backend = 6,   ///< The backend asked for is not built, or has no device.
};

/// An error with one clear line: what was expected, and where.
class Error : public std::runtime_error {
 public:
  /// `message` is one line that says what was expected.
  Error(ErrorKind kind, const std::string& message) : std::runtime_error(message), kind_(kind) {}
  /// What went wrong, as a program tells it apart.
  ErrorKind kind() const { return kind_; }

 private:
  ErrorKind kind_;
};

/// "file:line: message" (line 0: the whole file).
inline Error file_error(ErrorKind kind, const std::string& file, std::size_t line,
                        const std::string& message) {
  const std::string where = line > 0 ? file + ":" + std::to_string(line) : file;
  return Error(kind, where + ": " + message);
}
/// The same of the kind `input`.
inline Error input_error(const std::string& file, std::size_t line, const std::string& message) {
  return file_error(ErrorKind::input, file, line, message);
}

/// Text from a file, fit for one line of a message whatever the file held: at most 60 characters, all of
/// them printable ASCII.
inline std::string printable(std::string_view text) {
  constexpr std::size_t longest = 60;
  std::string out(text.substr(0, longest));
  for (char& c : out) {
    if (c < ' ' || c > '~') c = '?';
  }
  return text.size() > longest ? out + "..." : out;
}

}  // namespace parloc
