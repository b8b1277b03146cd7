// Messages about objects that corrections name: where in the file, and what is known in their
// place.
#pragma once

#include <algorithm>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "deepslam/core/result.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/overrides.h"

namespace deepslam::overrides {

// "overrides.yaml:4".
[[nodiscard]] std::string Place(const Overrides& overrides, int line);

// "a, b, c", or "none".
[[nodiscard]] std::string Listed(std::span<const std::string> names);

template <typename Items, typename Name>
[[nodiscard]] std::string Known(const Items& items, Name name) {
  std::vector<std::string> names;
  for (const auto& item : items) names.push_back(name(item));
  return Listed(names);
}

// Null where there is none.
template <typename Track>
[[nodiscard]] Track* Find(std::span<Track> tracks, ObjectId id) {
  const auto found = std::find_if(
      tracks.begin(), tracks.end(), [&](const ObjectTrack& track) { return track.id == id; });
  return found == tracks.end() ? nullptr : &*found;
}

// That no track is `object`, which the line names (kInvalidConfig).
[[nodiscard]] Error UnknownObject(const Overrides& overrides,
                                  int line,
                                  std::string_view object,
                                  std::span<const ObjectTrack> tracks);

// An object that is there under another name may not be the one that was meant (kInvalidConfig).
[[nodiscard]] Status CheckNames(const Overrides& overrides,
                                std::span<const NamedObject> names,
                                std::span<const ObjectTrack> tracks);

}  // namespace deepslam::overrides
