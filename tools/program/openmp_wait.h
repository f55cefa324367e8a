// How long OpenMP's threads wait for each other before they sleep.
#pragma once

namespace parloc::tools {

/// Starts the program anew with a short wait, once, unless the environment says how to wait. GNU OpenMP spins
/// for about 3 ms otherwise. On a machine that is busy with something else, a thread that spins keeps the
/// core from the very thread it waits for: steps of 1 ms then take 4 to 8. The setting is read when the
/// library is loaded, so only the environment can give it. Returns if there is nothing to do or it cannot be
/// done.
void wait_briefly(char** argv);

}  // namespace parloc::tools
