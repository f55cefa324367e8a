// Ctrl-C as a question that a loop asks.
#pragma once

namespace parloc::tools {

/// From here on SIGINT and SIGTERM are noted instead of ending the program; a second one ends it at once.
/// Signals that were ignored when the program started (a background job of a script) stay ignored.
void catch_interrupts();

/// Has one come?
bool interrupted();

}  // namespace parloc::tools
