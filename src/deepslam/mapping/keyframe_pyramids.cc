#include "deepslam/mapping/keyframe_pyramids.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "deepslam/alignment/reference_pixels.h"
#include "deepslam/core/parallel.h"

namespace deepslam::mapping {

using alignment::FramePyramid;

KeyframePyramids::KeyframePyramids(const FrameSource& frames,
                                   const alignment::PyramidOptions& options,
                                   std::size_t most)
    : frames_(frames), options_(options), most_(most) {}

void KeyframePyramids::Take(FrameIdx keyframe, std::shared_ptr<const FramePyramid> pyramid) {
  if (entries_.size() < most_) entries_.try_emplace(keyframe, Entry{std::move(pyramid), 0});
}

std::vector<std::string> KeyframePyramids::Hold(std::span<const FrameIdx> wanted) {
  ++round_;
  std::vector<FrameIdx> missing;
  for (const FrameIdx keyframe : wanted) {
    const auto [entry, is_new] = entries_.try_emplace(keyframe);
    entry->second.last_round = round_;
    if (is_new) missing.push_back(keyframe);
  }
  GiveUpOldest();
  std::vector<Result<alignment::ReadFrame>> made(missing.size(), alignment::ReadFrame{});
  ParallelFor(missing.size(), [&](std::size_t n) {
    made[n] = alignment::ReadPyramid(frames_, missing[n], options_);
  });
  std::vector<std::string> faults;
  for (std::size_t n = 0; n < missing.size(); ++n) {
    FramePyramid pyramid;
    if (made[n].ok()) {
      pyramid = std::move(made[n]->pyramid);
    } else {
      faults.push_back(fmt::format("frame {} {}", missing[n].value, made[n].error().message));
    }
    entries_.at(missing[n]).pyramid = std::make_shared<const FramePyramid>(std::move(pyramid));
  }
  PrepareWanted();
  return faults;
}

// Either of a pair may be the one that the other is aligned to.
void KeyframePyramids::PrepareWanted() {
  std::vector<Entry*> unprepared;
  for (auto& [keyframe, entry] : entries_) {
    if (entry.last_round == round_ && !entry.pyramid->empty() &&
        !alignment::IsReference(*entry.pyramid))
      unprepared.push_back(&entry);
  }
  ParallelFor(unprepared.size(), [&](std::size_t n) {
    auto& pyramid = unprepared[n]->pyramid;
    pyramid = std::make_shared<const FramePyramid>(alignment::AsReference(*pyramid));
  });
}

const FramePyramid& KeyframePyramids::operator[](FrameIdx keyframe) const {
  return *entries_.at(keyframe).pyramid;
}

int KeyframePyramids::Age(const Entry& entry) const {
  constexpr int kNow = 0;     // given up last
  constexpr int kNotYet = 1;  // given up after what was asked for before, and before what is in use
  if (entry.last_round == 0) return kNotYet;
  return entry.last_round == round_ ? kNow : kNotYet + round_ - entry.last_round;
}

void KeyframePyramids::GiveUpOldest() {
  while (entries_.size() > most_) {
    const auto oldest = std::max_element(entries_.begin(), entries_.end(), [&](auto& a, auto& b) {
      return Age(a.second) < Age(b.second);
    });
    if (oldest->second.last_round == round_) return;
    entries_.erase(oldest);
  }
}

}  // namespace deepslam::mapping
