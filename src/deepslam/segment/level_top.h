// Tables: a level top at one height above the ground, and what carries it.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "deepslam/geometry/camera.h"
#include "deepslam/geometry/plane.h"
#include "deepslam/segment/image_pieces.h"
#include "deepslam/segment/region.h"

namespace deepslam::segment {

struct LevelTop {
  double height_m = 0;
  std::vector<Eigen::Vector2d>
      hull_ground_m;  // convex, counter-clockwise, in GroundTangentBasis coordinates
};

// How high the pixels of a piece lie, in steps of heights at which tops are.
struct PieceHeights {
  static constexpr int kNumBins = 51;

  int all = 0;                               // pixels
  std::array<int, kNumBins + 1> from_bin{};  // of them in this bin or higher
};

// Of every piece.
[[nodiscard]] std::vector<PieceHeights> HeightsOf(const ImagePieces& pieces);

// Finds the layer with the largest outline inside the region that hides what is under it, and gives
// its pixels that have no owner to `owner`. Nothing when there is none between the heights of seats
// and bars. Depth is needed along the rim only: tops of tables often return none elsewhere.
// `heights`: of the pieces.
[[nodiscard]] std::optional<LevelTop> ClaimLevelTop(const ImagePieces& pieces,
                                                    std::span<const PieceHeights> heights,
                                                    const PinholeCamera& camera,
                                                    const Plane& ground_camera,
                                                    const Region& region,
                                                    int owner,
                                                    const SegmentOptions& options,
                                                    Owners& owners);

struct OwnedTop {
  int owner = 0;
  LevelTop top;
};

// Gives unowned pixels of what carries each top to its owner, also outside its box: pieces under
// the top, inside its outline on the ground, that are seen to reach up to it and not above it, and
// are not level themselves (a seat pushed under the table is), and the slim parts of legs that hang
// together with these. Chairs before a table do not get its legs that way.
void ClaimCarriers(const ImagePieces& pieces,
                   const Plane& ground_camera,
                   std::span<const OwnedTop> tops,
                   const SegmentOptions& options,
                   Owners& owners);

}  // namespace deepslam::segment
