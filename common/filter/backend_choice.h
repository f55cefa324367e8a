// Which backend does the work.
#pragma once

namespace parloc {

enum class BackendChoice { automatic, cpu, cuda };

}  // namespace parloc
