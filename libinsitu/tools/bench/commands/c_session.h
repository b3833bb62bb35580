#pragma once

#include <stdexcept>
#include <string>

#include "insitu/insitu.h"

/// What is measured through insitu.h, as solvers call it.
namespace insitu::bench {

inline void check(insitu_status status) {
  if (status != INSITU_OK)
    throw std::runtime_error(std::string(insitu_status_name(status)) + ": " +
                             insitu_last_message());
}

/// scene null: none. output: the folder of what it writes.
struct Session {
  explicit Session(int threads, const char* scene = nullptr, const char* output = nullptr) {
    insitu_session_options options = insitu_session_options_default();
    options.threads = threads;
    options.scene_text = scene;
    options.output = output;
    check(insitu_session_open(&options, &handle));
  }
  ~Session() { insitu_session_close(&handle); }
  Session(const Session&) = delete;
  Session& operator=(const Session&) = delete;
  insitu_session handle = {};
};

} // namespace insitu::bench
