#include "scene/parse/description.h"

namespace insitu::scene {

SceneDescription default_scene(const std::string& scalar_field, const std::string& mesh) {
  SceneDescription scene;
  scene.file = "default scene";
  scene.trigger.every = 10;
  Frame frame;
  frame.name = "frame";
  frame.layers[0].mesh.text = mesh;
  frame.layers[0].volume.emplace().field.text = scalar_field;
  frame.scalar_bar.emplace();
  frame.time_label.emplace();
  frame.trigger = scene.trigger;
  scene.frames.push_back(frame);
  return scene;
}

} // namespace insitu::scene
