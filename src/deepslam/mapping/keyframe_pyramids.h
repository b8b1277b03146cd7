// Keyframes prepared for alignment, and as what others are aligned to, made once while pairs of
// them ask for them in turn.
#pragma once

#include <cstddef>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/core/ids.h"
#include "deepslam/core/result.h"
#include "deepslam/frames/frame_source.h"

namespace deepslam::mapping {

class KeyframePyramids {
 public:
  // Of what was asked for before, at most `most` (about 4 MB each) are kept, the latest.
  KeyframePyramids(const FrameSource& frames,
                   const alignment::PyramidOptions& options,
                   std::size_t most);

  // One that was made elsewhere of the same options, kept until it was asked for as far as there is
  // room.
  void Take(FrameIdx keyframe, std::shared_ptr<const alignment::FramePyramid> pyramid);

  // Makes those of `wanted` (again and again the same, if need be) that are not there, side by
  // side, and gives up others. What cannot be read stays empty; its fault is in the answer, "frame
  // N ...", once for each time it is tried.
  [[nodiscard]] std::vector<std::string> Hold(std::span<const FrameIdx> wanted);

  // One of those wanted last.
  [[nodiscard]] const alignment::FramePyramid& operator[](FrameIdx keyframe) const;

 private:
  struct Entry {
    std::shared_ptr<const alignment::FramePyramid> pyramid;
    int last_round = 0;  // in which it was asked for; 0: not yet
  };

  // What was asked for is given up before what will be.
  [[nodiscard]] int Age(const Entry& entry) const;
  void GiveUpOldest();
  void PrepareWanted();

  const FrameSource& frames_;
  alignment::PyramidOptions options_;
  std::size_t most_;
  int round_ = 0;
  std::map<FrameIdx, Entry> entries_;
};

}  // namespace deepslam::mapping
