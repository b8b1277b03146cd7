// How far from its origin a position that somebody wrote may lie.
#pragma once

namespace deepslam {

// Farther off than any room: such a number is damaged or in another unit, and squares of it need
// not be finite.
inline constexpr double kMaxPositionM = 1e6;

}  // namespace deepslam
