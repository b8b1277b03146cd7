#include "deepslam/overrides/known_objects.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace deepslam::overrides {

std::string Place(const Overrides& overrides, int line) {
  return fmt::format("{}:{}", overrides.file, line);
}

std::string Listed(std::span<const std::string> names) {
  return names.empty() ? "none" : fmt::format("{}", fmt::join(names, ", "));
}

Error UnknownObject(const Overrides& overrides,
                    int line,
                    std::string_view object,
                    std::span<const ObjectTrack> tracks) {
  return InvalidConfig(fmt::format("{}: there is no object {}; known are {}",
                                   Place(overrides, line),
                                   object,
                                   Known(tracks, [](const ObjectTrack& track) {
                                     return fmt::format(
                                         "{} ({})", track.id.value, track.class_name);
                                   })));
}

Status CheckNames(const Overrides& overrides,
                  std::span<const NamedObject> names,
                  std::span<const ObjectTrack> tracks) {
  for (const NamedObject& name : names) {
    const ObjectTrack* track = Find(tracks, name.object);
    if (track == nullptr || track->class_name == name.class_name) continue;
    return UnknownObject(overrides,
                         name.line,
                         fmt::format("{}_{:02d}, object {} is called {}_{:02d} (write {} if it is "
                                     "meant)",
                                     name.class_name,
                                     name.object.value,
                                     name.object.value,
                                     track->class_name,
                                     name.object.value,
                                     name.object.value),
                         tracks);
  }
  return Ok();
}

}  // namespace deepslam::overrides
