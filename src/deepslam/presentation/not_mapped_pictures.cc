#include "deepslam/presentation/not_mapped_pictures.h"

#include <array>
#include <cstddef>
#include <utility>

#include "deepslam/core/parallel.h"
#include "deepslam/geometry/upright.h"
#include "deepslam/report/draw.h"
#include "deepslam/scene/upright_turns.h"

namespace deepslam::presentation {
namespace {

// Of 20 KB or so each: the page stays small to load and to read.
constexpr std::size_t kMaxPictures = 24;
constexpr int kWidthPx = 340;  // three side by side
constexpr Rgb8 kBoxColour{230, 57, 70};

std::string Draw(const SeenIn& seen, const OptimizedMap& map, const FrameSource& frames) {
  const Result<Frame> frame = frames.ReadColour(seen.frame);
  if (!frame.ok()) return {};
  const PinholeCamera& camera = frames.camera();
  const QuarterTurn upright = UprightTurnIn(map, seen.frame);
  const std::array<report::Overlay, 1> box = {
      {{Turned(seen.box_px, camera.width, camera.height, upright), Mask(), "", kBoxColour}}};
  Result<std::string> jpeg = report::DrawOverlays(Turned(frame->colour, upright), box, kWidthPx);
  return jpeg.ok() ? std::move(jpeg).value() : std::string();
}

}  // namespace

std::vector<report::Picture> NotMappedPictures(std::span<const NotMapped> not_mapped,
                                               const OptimizedMap& map,
                                               const FrameSource& frames,
                                               const std::set<FrameIdx>& shown) {
  std::vector<report::Picture> pictures(not_mapped.size());
  ParallelFor(pictures.size(), [&](std::size_t n) {
    const NotMapped& thing = not_mapped[n];
    pictures[n].caption = thing.what;
    if (n < kMaxPictures && shown.contains(thing.best.frame))
      pictures[n].bytes = Draw(thing.best, map, frames);
  });
  return pictures;
}

}  // namespace deepslam::presentation
