// Writing a result so that it is there as a whole or not at all.
#pragma once

#include <string>
#include <string_view>

namespace parloc {

/// Writes `bytes` to a temporary file beside `path`, then renames it to `path`. Throws Error{output} naming
/// the path and the reason; what was at `path` stays, the temporary file does not.
void replace_file(const std::string& path, std::string_view bytes);

/// Throws what replace_file() would throw where no file can be made: to be asked before something else is
/// written that should not be there alone.
void expect_writable(const std::string& path);

}  // namespace parloc
