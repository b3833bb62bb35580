#pragma once

#include <string>
#include <string_view>

#include "scene/parse/description.h"
#include "scene/parse/retired_keys.h"

namespace insitu::scene {

/// Reads the scene file at `path`; names of files in it are relative to its folder. Throws
/// core::Error(INSITU_ERROR_FILE) where the file cannot be read, and else as parse_scene_text().
SceneDescription parse_scene_file(const std::string& path);

/// The two halves of that: the file's text, and what is parsed of it on any process.
std::string read_scene_file(const std::string& path);
SceneDescription parse_scene_of_file(std::string_view text, const std::string& path);

/// Reads a scene from `text`. `name` stands for the file in messages, and names of files in the
/// scene are relative to `base_folder` (empty: the working directory). No file is opened. Throws
/// core::Error(INSITU_ERROR_SCENE) with all problems of the scene (Problems::most at most), one a
/// line: "name:line: ...". Keys that are retired work, and the description's warnings name the new
/// ones.
SceneDescription parse_scene_text(std::string_view text, const std::string& name,
                                  const std::string& base_folder = {},
                                  std::span<const RetiredKey> retired = retired_keys());

} // namespace insitu::scene
