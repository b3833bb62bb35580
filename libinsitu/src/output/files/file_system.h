#pragma once

#include <cstddef>
#include <string>

namespace insitu::output {

/// What an errno value means, in the system's words.
std::string system_reason(int error);

/// Throws core::Error (INSITU_ERROR_FILE): "cannot <doing> '<path>': <reason>".
[[noreturn]] void throw_file_error(const char* doing, const std::string& path, int error);

/// The folder part of a path, "." if there is none.
std::string folder_of(const std::string& path);

/// Writes all bytes, however many calls that takes. Returns 0, or the errno of the call that
/// failed; `done` receives the bytes that got through.
int write_all(int descriptor, const char* data, std::size_t bytes, std::size_t* done);

/// Once per process and folder: makes it if absent and removes what killed runs left there.
void prepare_folder(const std::string& folder);

} // namespace insitu::output
