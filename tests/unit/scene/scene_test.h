#pragma once

#include <string>

#include "core/status.h"
#include "scene/parse/parse.h"

namespace insitu::scene::test {

/// A scene of version 1 with `rest` below its first line; lines of `rest` count from 2.
inline SceneDescription parse(const std::string& rest) {
  return parse_scene_text("insitu: 1\n" + rest, "s.yaml", "/base");
}

/// The message of the error that `call` throws with status SCENE; "no error" where there is none.
template <class Call>
std::string error_of_call(const Call& call) {
  try {
    call();
  } catch (const core::Error& error) {
    return error.status() == INSITU_ERROR_SCENE ? error.what()
                                                : "wrong status: " + std::string(error.what());
  }
  return "no error";
}

inline std::string error_of_text(const std::string& text) {
  return error_of_call([&] { parse_scene_text(text, "s.yaml"); });
}

inline std::string error_of(const std::string& rest) {
  return error_of_text("insitu: 1\n" + rest);
}

/// One item of each section, in one line, with more keys.
inline std::string probe(const std::string& keys) {
  return "probes: [{name: p, points: [[0, 0, 0]], " + keys + "}]";
}
inline std::string tracer(const std::string& keys) {
  return "tracers: [{name: t, seeds: [[0, 0, 0]], velocity: u, " + keys + "}]";
}
inline std::string frame(const std::string& keys) {
  return "frames: [{name: f, volume: {field: rho}, " + keys + "}]";
}

} // namespace insitu::scene::test
