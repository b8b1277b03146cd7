// Which of several starts leads to the right place: iterations from each at the coarsest level, and
// a score of where they end.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "deepslam/alignment/alignment_options.h"
#include "deepslam/alignment/gauss_newton.h"
#include "deepslam/alignment/place_score.h"
#include "deepslam/alignment/source_points.h"

namespace deepslam::alignment {

// Finds another start, if there is one, where the first one does not end conclusively.
using StartSearch = std::function<std::optional<Pose3>()>;

// Points of frame j's coarsest level: iterations that compete go by some of its rows and columns;
// which of several ends is right, all of them decide.
class CoarsePoints {
 public:
  // Keeps references to both.
  CoarsePoints(const PyramidLevel& level, const AlignmentOptions& options);

  [[nodiscard]] const PyramidLevel& level() const { return level_; }
  [[nodiscard]] const SourcePoints& some() const { return some_; }
  [[nodiscard]] const SourcePoints& all();

 private:
  const PyramidLevel& level_;
  const AlignmentOptions& options_;
  SourcePoints some_;
  std::optional<SourcePoints> all_;
};

// Every stride-th row and column of a level, for where nothing is near yet.
[[nodiscard]] SourcePoints FarPoints(const PyramidLevel& level,
                                     int stride,
                                     const AlignmentOptions& options);

// By the coarsest level's gates and a scale that all places have in common.
[[nodiscard]] PlaceScore ScoreCoarsely(const PyramidLevel& i,
                                       const SourcePoints& j,
                                       const Pose3& i_from_j,
                                       const AlignmentOptions& options);

// What competing starts are compared by: over the common points, geometric inliers at a common
// scale and correlation of the images. Of a pattern's pixels most fit anywhere to within a robust
// scale; the correlation lives by the few strong ones. Larger overlap counts for more, but less
// than how alike these are: a wrong place may well show more of the other frame. 0 where nothing
// overlaps.
[[nodiscard]] double SupportAt(const Pose3& i_from_j,
                               const PyramidLevel& i,
                               const SourcePoints& j,
                               const AlignmentOptions& options);

// Whether nothing speaks for another place. Such a place was never left for one that was better, on
// 22 captures, two of them real.
[[nodiscard]] bool IsConclusive(const AlignmentSystem& system);

// The best of where iterations from `starts` (at least one) and from what `search` may find end; of
// the first start alone where it ends conclusively.
[[nodiscard]] GaussNewtonState SearchStarts(const PyramidLevel& i,
                                            CoarsePoints& j,
                                            std::span<const Pose3> starts,
                                            const StartSearch& search,
                                            const AlignmentOptions& options);

}  // namespace deepslam::alignment
