// The place along directions that depth constrains weakly.
//
// There only the images show the place, and iterations by them end at the nearest stripe, tile or
// board that looks alike. So places on both sides are tried.
#pragma once

#include <optional>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/degenerate_directions.h"
#include "deepslam/alignment/image_pyramid.h"
#include "deepslam/alignment/start_search.h"
#include "deepslam/geometry/pose.h"

namespace deepslam::alignment {

// `state`, at the coarsest level, or one whose likelihood is surely greater.
[[nodiscard]] GaussNewtonState SearchWeakDirections(const PyramidLevel& i,
                                                    CoarsePoints& j,
                                                    const AlignmentOptions& options,
                                                    const GaussNewtonState& state);

// Differences of likelihood below this, among some twenty places, are chance: a ratio of exp(6),
// 400 : 1.
inline constexpr double kSureNats = 6;

// What images of independent measurements share at a place, nats; of points chosen as for a place
// far off.
[[nodiscard]] double SharedInformation(const PyramidLevel& i,
                                       const SourcePoints& j,
                                       const Pose3& i_from_j,
                                       const AlignmentOptions& options);

// Where images show no contours either, the fine texture of a bare wall shows the place. Shading is
// the light's and the lens's and hardly changes along a wall; behind local contrast normalisation
// the grain of paint or paper is left, a grey level or less, and only the right place has it alike.
// Its peak is a pixel or two wide, so that iterations do not find it.

// Where iterations began, and how well that is known.
struct FirstStart {
  Pose3 i_from_j;
  StartSigma sigma;
  bool is_near = false;  // the place is within a few centimetres
};

struct TexturePlace {
  Pose3 i_from_j;
  bool is_end = false;  // where the iterations ended, to less than a pixel
  StartSigma sigma;     // how well the place is known
};

// The place that differs from `end` along `unseen` alone and at which both images have the same
// texture, surely (kSureNats) and as no other place that the camera may have reached. Nothing where
// there is none: without colour, without texture, where it repeats itself, and in captures so small
// that the blocks of JPEG files would be looked at.
[[nodiscard]] std::optional<TexturePlace> SearchTexture(const FramePyramid& i,
                                                        const FramePyramid& j,
                                                        const DegenerateDirections& unseen,
                                                        const FirstStart& start,
                                                        const Pose3& end,
                                                        const AlignmentOptions& options);

}  // namespace deepslam::alignment
