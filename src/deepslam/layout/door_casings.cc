#include "deepslam/layout/door_casings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "deepslam/scene/layout.h"

namespace deepslam::layout {
namespace {

// Architraves are 12 to 25 mm thick; half of the thinnest tells one.
constexpr double kLeastRelief_m = 0.006;
// Of the deviation of a cell: strips have some sixty cells, of which four hang together in the
// fused surface, so that the difference between two has a deviation of a third of a cell's; three
// of these.
constexpr double kOfCellSigma = 1.0;
constexpr double kJambFrom_m = 0.3;    // skirting and what stands on the floor end below
constexpr double kSeen = 0.6;          // of a strip, at least
constexpr double kUniform = 0.7;       // of a jamb's rows that stand out by themselves
constexpr int kStrip = 2;              // cells across a casing: 7 to 10 cm
constexpr double kConfidence = 0.6;    // where it was seen all around
constexpr double kOneSideLess = 0.15;  // below 0.5, doubtful, where a side was not seen

// Slots and rows [first, end).
struct Strip {
  int first_slot = 0;
  int end_slot = 0;
  int first_row = 0;
  int end_row = 0;
};

// Sums of the face's relief over rectangles.
class ReliefSums {
 public:
  explicit ReliefSums(const WallProfile& profile)
      : slots_(profile.num_slots), rows_(profile.num_rows) {
    const auto size = static_cast<std::size_t>(slots_ + 1) * static_cast<std::size_t>(rows_ + 1);
    sums_m_.assign(size, 0);
    counts_.assign(size, 0);
    for (int slot = 0; slot < slots_; ++slot) {
      for (int row = 0; row < rows_; ++row) {
        const bool solid = (profile.at(slot, row) & kSolid) != 0;
        sums_m_[At(slot + 1, row + 1)] = (solid ? profile.OffsetAt(slot, row) : 0) +
                                         sums_m_[At(slot, row + 1)] + sums_m_[At(slot + 1, row)] -
                                         sums_m_[At(slot, row)];
        counts_[At(slot + 1, row + 1)] = (solid ? 1 : 0) + counts_[At(slot, row + 1)] +
                                         counts_[At(slot + 1, row)] - counts_[At(slot, row)];
      }
    }
  }

  // The mean; nothing where too little of the strip is surface.
  [[nodiscard]] std::optional<double> Mean(const Strip& strip) const {
    const int s0 = std::max(0, strip.first_slot);
    const int s1 = std::min(slots_, strip.end_slot);
    const int r0 = std::max(0, strip.first_row);
    const int r1 = std::min(rows_, strip.end_row);
    const int whole = (strip.end_slot - strip.first_slot) * (strip.end_row - strip.first_row);
    if (s0 >= s1 || r0 >= r1 || whole <= 0) return std::nullopt;
    const auto over = [&](const auto& sums) {
      return sums[At(s1, r1)] - sums[At(s0, r1)] - sums[At(s1, r0)] + sums[At(s0, r0)];
    };
    const int count = over(counts_);
    if (count < kSeen * whole) return std::nullopt;
    return over(sums_m_) / count;
  }

 private:
  [[nodiscard]] std::size_t At(int slot, int row) const {
    return static_cast<std::size_t>(slot) * static_cast<std::size_t>(rows_ + 1) +
           static_cast<std::size_t>(row);
  }

  int slots_;
  int rows_;
  std::vector<double> sums_m_;
  std::vector<int> counts_;
};

// Deviation of a cell, from the differences between cells above each other: the median of their
// sizes, which edges and pictures do not reach.
double CellSigma(const WallProfile& profile) {
  std::vector<double> differences_m;
  for (int slot = 0; slot < profile.num_slots; ++slot) {
    for (int row = 0; row + 1 < profile.num_rows; ++row) {
      if ((profile.at(slot, row) & profile.at(slot, row + 1) & kSolid) == 0) continue;
      differences_m.push_back(
          std::abs(profile.OffsetAt(slot, row) - profile.OffsetAt(slot, row + 1)));
    }
  }
  if (differences_m.empty()) return 0;
  const auto middle = differences_m.begin() + static_cast<std::ptrdiff_t>(differences_m.size() / 2);
  std::nth_element(differences_m.begin(), middle, differences_m.end());
  constexpr double kSigmaOfMedian = 1.4826;  // of a normal distribution's absolute deviation
  return kSigmaOfMedian * *middle / std::sqrt(2.0);
}

// A leaf between its jambs, below its head.
struct Leaf {
  int first_slot = 0;
  int end_slot = 0;
  int head_row = 0;     // first above it
  double relief_m = 0;  // by which the casing stands out, where it does least
  int num_unknown = 0;  // sides outside of which nothing was seen
};

class CasingSearch {
 public:
  CasingSearch(const WallProfile& profile, const WallFace& face)
      : profile_(profile),
        sums_(profile),
        least_m_(std::max(kLeastRelief_m, kOfCellSigma * CellSigma(profile))),
        first_slot_(std::max(0, SlotAt(face.from_m))),
        end_slot_(std::min(profile.num_slots, SlotAt(face.to_m))),
        floor_row_(RowAt(face.floor_m)),
        low_row_(RowAt(face.floor_m + kJambFrom_m)) {}

  [[nodiscard]] std::vector<Leaf> Find() const {
    std::vector<Leaf> found;
    const int narrow = static_cast<int>(std::lround(kNarrowDoor_m / kCell_m));
    const int widest = static_cast<int>(std::lround(kWidestDoor_m / kCell_m));
    const int lowest = floor_row_ + static_cast<int>(std::lround(kLowestDoor_m / kCell_m));
    const int highest = floor_row_ + static_cast<int>(std::lround(kHighestDoor_m / kCell_m));
    for (int left = first_slot_ + kStrip; left + narrow + kStrip <= end_slot_; ++left) {
      for (int right = left + narrow; right <= std::min(left + widest, end_slot_ - kStrip);
           ++right) {
        for (int head = lowest; head <= std::min(highest, profile_.num_rows - kStrip); ++head) {
          if (const auto leaf = Measured({left, right, head})) found.push_back(*leaf);
        }
      }
    }
    std::stable_sort(found.begin(), found.end(), [](const Leaf& a, const Leaf& b) {
      return a.relief_m > b.relief_m;
    });
    return found;
  }

 private:
  [[nodiscard]] int SlotAt(double position_m) const {
    return static_cast<int>(std::lround((position_m - profile_.begin_m) / kCell_m));
  }
  [[nodiscard]] int RowAt(double height_m) const {
    return std::max(0, static_cast<int>(std::lround((height_m - profile_.bottom_m) / kCell_m)));
  }

  // By how much a strip stands out against the ones inside and outside of it, a cell between them.
  // Nothing where it does not. What is outside may be unknown.
  [[nodiscard]] std::optional<double> Relief(const Strip& casing,
                                             const Strip& inside,
                                             const Strip& outside,
                                             int& num_unknown) const {
    const std::optional<double> of_casing = sums_.Mean(casing);
    const std::optional<double> of_inside = sums_.Mean(inside);
    const std::optional<double> of_outside = sums_.Mean(outside);
    if (!of_casing || !of_inside) return std::nullopt;
    double relief_m = *of_casing - *of_inside;
    if (of_outside) {
      relief_m = std::min(relief_m, *of_casing - *of_outside);
    } else {
      ++num_unknown;
    }
    if (relief_m < least_m_) return std::nullopt;
    return relief_m;
  }

  // Whether a jamb stands out along its height, and not at a few places by much.
  [[nodiscard]] bool IsUniform(const Strip& jamb, const Strip& inside) const {
    int num_seen = 0;
    int num_out = 0;
    for (int row = jamb.first_row; row < jamb.end_row; ++row) {
      const auto of = [&](const Strip& strip) {
        return sums_.Mean({strip.first_slot, strip.end_slot, row, row + 1});
      };
      const std::optional<double> out = of(jamb);
      const std::optional<double> in = of(inside);
      if (!out || !in) continue;
      ++num_seen;
      num_out += *out - *in > 0.5 * least_m_ ? 1 : 0;
    }
    return num_out >= kUniform * num_seen;
  }

  [[nodiscard]] std::optional<Leaf> Measured(Leaf leaf) const {
    const auto column = [&](int first) {
      return Strip{first, first + kStrip, low_row_, leaf.head_row};
    };
    const auto beam = [&](int first) {
      return Strip{leaf.first_slot, leaf.end_slot, first, first + kStrip};
    };
    // Cells from a casing to the plain wall beside it: one is left out.
    constexpr int kApart = kStrip + 1;
    const Strip left = column(leaf.first_slot - kStrip);
    const Strip left_inside = column(leaf.first_slot + 1);
    const Strip right = column(leaf.end_slot);
    const Strip right_inside = column(leaf.end_slot - 1 - kStrip);
    const std::optional<double> of_left =
        Relief(left, left_inside, column(leaf.first_slot - kStrip - kApart), leaf.num_unknown);
    if (!of_left) return std::nullopt;
    const std::optional<double> of_right =
        Relief(right, right_inside, column(leaf.end_slot + kApart), leaf.num_unknown);
    if (!of_right) return std::nullopt;
    const std::optional<double> of_head = Relief(beam(leaf.head_row),
                                                 beam(leaf.head_row - 1 - kStrip),
                                                 beam(leaf.head_row + kApart),
                                                 leaf.num_unknown);
    if (!of_head || leaf.num_unknown > 1) return std::nullopt;
    if (!IsUniform(left, left_inside) || !IsUniform(right, right_inside)) return std::nullopt;
    leaf.relief_m = std::min({*of_left, *of_right, *of_head});
    return leaf;
  }

  const WallProfile& profile_;
  ReliefSums sums_;
  double least_m_;
  int first_slot_;
  int end_slot_;
  int floor_row_;
  int low_row_;
};

}  // namespace

std::vector<FaceOpening> FindCasings(const WallProfile& profile, const WallFace& face) {
  std::vector<FaceOpening> doors;
  for (const Leaf& leaf : CasingSearch(profile, face).Find()) {
    FaceOpening door;
    door.from_m = profile.PositionOf(leaf.first_slot);
    door.to_m = profile.PositionOf(leaf.end_slot);
    const bool known = std::any_of(doors.begin(), doors.end(), [&](const FaceOpening& other) {
      return door.from_m < other.to_m && other.from_m < door.to_m;
    });
    if (known) continue;
    door.bottom_m = face.floor_m;
    door.top_m = profile.HeightOf(leaf.head_row);
    door.confidence = kConfidence - kOneSideLess * leaf.num_unknown;
    door.note = "closed: a casing around a leaf";
    doors.push_back(std::move(door));
  }
  std::stable_sort(doors.begin(), doors.end(), [](const FaceOpening& a, const FaceOpening& b) {
    return a.from_m < b.from_m;
  });
  return doors;
}

}  // namespace deepslam::layout
