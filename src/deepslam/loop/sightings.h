// When each object of the map was seen, and how far the camera travelled in between.
#pragma once

#include <span>
#include <vector>

#include "deepslam/scene/object_map.h"
#include "deepslam/scene/object_track.h"
#include "deepslam/scene/trajectory.h"

namespace deepslam::loop {

class Sightings {
 public:
  // Frames of an object: its track's and those of the tracks merged into it, and its views'. Parts
  // of the path by frame (scene/measured_parts.h); frames beyond them are in part 0.
  Sightings(const ObjectMap& map,
            const Association& association,
            const Trajectory& trajectory,
            std::span<const int> part_of_frame);

  // Ascending, without repetition; `object` is an index into ObjectMap::objects.
  [[nodiscard]] const std::vector<int>& frames(std::size_t object) const { return frames_[object]; }
  [[nodiscard]] bool SeenTogether(std::size_t a, std::size_t b) const;
  // Whether it was measured how they lie to each other: first seen in one part of the path.
  [[nodiscard]] bool Tied(std::size_t a, std::size_t b) const;
  // Path along the keyframes between two frames; 0 without a trajectory.
  [[nodiscard]] double PathBetween_m(int frame_a, int frame_b) const;

 private:
  [[nodiscard]] double PathUntil_m(int frame) const;
  [[nodiscard]] int PartOf(std::size_t object) const;

  std::vector<std::vector<int>> frames_;
  std::vector<int> part_of_frame_;
  std::vector<int> path_frames_;
  std::vector<double> path_m_;  // travelled until path_frames_[k]
};

}  // namespace deepslam::loop
