// The place along directions that depth constrains weakly.
//
// There only the images show the place, and iterations by them end at the nearest stripe, tile or
// board that looks alike. So places on both sides are tried.
#pragma once

#include "deepslam/alignment/start_search.h"

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

}  // namespace deepslam::alignment
