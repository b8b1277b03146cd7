// Scene files of `deepslam synth`.
#include <string>

#include "deepslam/synth/scene_description.h"
#include "fuzz/entry.h"

DEEPSLAM_FUZZ(scene_yaml) {
  const std::string text(bytes);
  // Where there are none this would read the same YAML twice.
  if (text.find("rungs") != std::string::npos) {
    const auto rung = synth::ParseScene(text, kFile, "noise");
    if (!rung.ok()) Refused(rung.error());
  }
  const auto scene = synth::ParseScene(text, kFile);
  if (!scene.ok()) return Refused(scene.error());
  DEEPSLAM_CHECK(scene->num_frames > 0 && scene->camera.width > 0, "a scene can be rendered");
  DEEPSLAM_CHECK(scene->room_size_m.allFinite(), "a room has a size");
  return true;
}
