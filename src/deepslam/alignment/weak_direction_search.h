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

}  // namespace deepslam::alignment
