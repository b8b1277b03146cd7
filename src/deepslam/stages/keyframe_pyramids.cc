#include "deepslam/stages/keyframe_pyramids.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/core/parallel.h"
#include "deepslam/odometry/read_pyramid.h"

namespace deepslam::stages {

using odometry::FramePyramid;

KeyframePyramids::KeyframePyramids(const FrameSource& frames,
                                   const odometry::PyramidOptions& options,
                                   std::size_t most)
    : frames_(frames), options_(options), most_(most) {}

std::vector<std::string> KeyframePyramids::Hold(std::span<const FrameIdx> wanted) {
  ++round_;
  std::vector<FrameIdx> missing;
  for (const FrameIdx keyframe : wanted) {
    const auto [entry, is_new] = entries_.try_emplace(keyframe);
    entry->second.last_round = round_;
    if (is_new) missing.push_back(keyframe);
  }
  GiveUpOldest();
  std::vector<Result<FramePyramid>> made(missing.size(), FramePyramid{});
  ParallelFor(missing.size(), [&](std::size_t n) {
    made[n] = odometry::ReadPyramid(frames_, missing[n], options_);
  });
  std::vector<std::string> faults;
  for (std::size_t n = 0; n < missing.size(); ++n) {
    if (made[n].ok()) {
      entries_.at(missing[n]).pyramid = std::move(made[n]).value();
    } else {
      faults.push_back(fmt::format("frame {} {}", missing[n].value, made[n].error().message));
    }
  }
  return faults;
}

const FramePyramid& KeyframePyramids::operator[](FrameIdx keyframe) const {
  return entries_.at(keyframe).pyramid;
}

void KeyframePyramids::GiveUpOldest() {
  while (entries_.size() > most_) {
    const auto oldest = std::min_element(entries_.begin(), entries_.end(), [](auto& a, auto& b) {
      return a.second.last_round < b.second.last_round;
    });
    if (oldest->second.last_round == round_) return;
    entries_.erase(oldest);
  }
}

}  // namespace deepslam::stages
