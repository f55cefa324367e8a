// What is known of this build since it was configured. Written by CMake from build_info.cpp.in.
#pragma once

namespace parloc::tools {

extern const char* const kVersion;
extern const char* const kCommit;  ///< Empty if the sources were no git checkout. "-dirty": with changes.
extern const char* const kCompiler;
extern const char* const kFlags;
extern const char* const kBuildType;
extern const char* const kCuda;             ///< The compiler of the CUDA backend, or "not in this build".
extern const char* const kMapsOfSource;     ///< Folder of the source tree.
extern const char* const kMapsFromProgram;  ///< From the folder of the installed program.

}  // namespace parloc::tools
