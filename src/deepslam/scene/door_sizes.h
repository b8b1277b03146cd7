// How wide and how high doors of homes are.
#pragma once

namespace deepslam {

// 0.6 to 1.3 m wide, two-winged ones included, 1.8 to 2.3 m high (DIN 18101 has 0.6 to 1.25
// and 1.98 to 2.11, other countries a little more); a cell of 5 cm is added on either side, as
// measuring adds it. What is wider and reaches the floor is a passage.
inline constexpr double kNarrowDoor_m = 0.55;
inline constexpr double kWidestDoor_m = 1.35;   // 1.3 and a cell
inline constexpr double kWidestLeaf_m = 1.05;   // of one leaf (DIN 18101: 0.985), with a cell
inline constexpr double kLowestDoor_m = 1.75;   // 1.8 less a cell
inline constexpr double kHighestDoor_m = 2.35;  // 2.3 and a cell

}  // namespace deepslam
