#include "deepslam/layout/wall_openings.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>

#include "deepslam/layout/door_casings.h"
#include "deepslam/layout/face_rectangles.h"
#include "deepslam/scene/layout.h"

namespace deepslam::layout {
namespace {

constexpr double kMinOpeningWidth_m = 0.4;  // narrower ones are vents and gaps between shelves
// Windows under ceilings of bathrooms and cellars are as low.
constexpr double kMinOpeningHeight_m = 0.4;
constexpr double kMinFill = 0.5;      // of the rectangle that is gap
constexpr double kMinFrame = 0.4;     // of a side that is wall
constexpr double kThreshold_m = 0.3;  // what begins lower reaches the floor
// Of an opening's width that has to be seen down to the floor, where furniture hides the rest.
constexpr double kFootShare = 0.25;
constexpr int kSillCells = 2;           // of wall below an opening, in a column: one may be noise
constexpr double kRecess_m = 0.02;      // a leaf lies this much deeper than its wall, or more
constexpr double kFrameWithin_m = 0.2;  // where the frame of an opening is looked for

constexpr double kThingShare = 0.1;    // before a gap without depth: then it is a thing's
constexpr double kBoardShare = 0.5;    // of its height where a side board is seen,
constexpr double kBeyondShare = 0.05;  // and of what is beyond it, things: the board is not theirs
constexpr double kPaneFill = 0.7;      // of a window's rectangle that is set back
constexpr double kPaneConfidence = 0.6;  // above 0.5, doubtful, by little: niches look like it
// Sills of living rooms are 0.8 to 0.9 m high and heads 2.0 m and more; narrow sashes are 0.6 m
// wide.
constexpr std::size_t kMostPanes = 4;   // looked at in what hangs together
constexpr double kUsualWidth_m = 0.6;   // a narrow sash
constexpr double kUsualHeight_m = 0.9;  // less than from sill to head
constexpr double kMullion_m = 0.2;      // wall between the sashes of one window
constexpr double kLevel_m = 0.12;       // their ends differ by less: two cells and a little

// Which sides of an opening are wall.
struct Frame {
  bool left = false;
  bool right = false;
  bool above = false;
  bool below = false;
  bool to_ceiling = false;  // nothing of the wall is above it
  bool at_corner = false;   // the left or the right side is the corner of the room

  [[nodiscard]] int num_sides() const { return left + right + above + below; }
};

class FaceSearch {
 public:
  FaceSearch(const WallProfile& profile, const WallFace& face) : profile_(profile), face_(face) {
    const auto row_at = [&](double height_m) {
      return std::clamp(static_cast<int>(std::lround((height_m - profile.bottom_m) / kCell_m)),
                        0,
                        profile.num_rows);
    };
    const auto slot_at = [&](double position_m) {
      return std::clamp(static_cast<int>(std::lround((position_m - profile.begin_m) / kCell_m)),
                        0,
                        profile.num_slots);
    };
    box_ = {slot_at(face.from_m), slot_at(face.to_m), row_at(face.floor_m), row_at(face.top_m)};
  }

  void AddGaps(std::vector<FaceOpening>& found) const {
    const CellTest gap = [this](int slot, int row) {
      return (At(slot, row) & (kOpen | kBlind)) != 0;
    };
    const CellTest wall = [this](int slot, int row) { return IsSolid(slot, row); };
    for (const CellBox& box : RectanglesOf(box_, gap, wall)) {
      if (box.width_m() < kMinOpeningWidth_m || box.height_m() < kMinOpeningHeight_m) continue;
      if (ShareOf(box, box_, gap) < kMinFill) continue;
      if (const auto opening = Classified(box, ReachesFloor(box, gap))) {
        found.push_back(*opening);
      } else {
        AddWindowsWithin(box, gap, found);
      }
    }
  }

  void AddLeaves(std::vector<FaceOpening>& found) const {
    const CellTest deep = [this](int slot, int row) {
      return (At(slot, row) & kSolid) != 0 && profile_.OffsetAt(slot, row) < -kRecess_m;
    };
    const CellTest flush = [&](int slot, int row) {
      return IsSolid(slot, row) && !deep(slot, row);
    };
    for (const CellBox& box : RectanglesOf(box_, deep, flush)) {
      if (!IsDoorSized(box) || ShareOf(box, box_, deep) < kMinFill) continue;
      if (!ReachesFloor(box, deep)) continue;
      const Frame frame = FrameOf(box, flush);
      if (frame.num_sides() < 2) continue;
      FaceOpening opening = OpeningOf(box, OpeningKind::kDoor);
      opening.confidence = 0.4 + 0.1 * frame.num_sides();
      opening.note = "closed: a leaf deeper than its wall";
      found.push_back(std::move(opening));
    }
  }

  // Windows whose panes, blinds or curtains were measured behind the wall's face, wholly or in
  // part.
  void AddPanes(std::vector<FaceOpening>& found) const {
    const CellTest set_back = [this](int slot, int row) {
      const std::uint8_t cell = At(slot, row);
      if ((cell & kSolid) != 0) return profile_.OffsetAt(slot, row) < -kRecess_m;
      return (cell & (kOpen | kBlind | kFront)) != 0;
    };
    const CellTest flush = [&](int slot, int row) {
      return IsSolid(slot, row) && !set_back(slot, row);
    };
    for (const CellBox& box : RectanglesOf(box_, set_back, flush)) {
      if (box.width_m() < kMinOpeningWidth_m || box.height_m() < kMinOpeningHeight_m) continue;
      if (ShareOf(box, box_, set_back) < kPaneFill) continue;
      if (ReachesFloor(box, set_back)) continue;
      const Frame frame = FrameOf(box, flush);
      if (frame.num_sides() < 4 || IsDarkThing(box)) continue;
      FaceOpening opening = OpeningOf(box, OpeningKind::kWindow);
      opening.confidence = kPaneConfidence;
      opening.note = "what was measured in it lies behind the wall's face: a window, or a niche";
      found.push_back(std::move(opening));
    }
  }

 private:
  [[nodiscard]] std::uint8_t At(int slot, int row) const { return profile_.at(slot, row); }
  [[nodiscard]] bool IsSolid(int slot, int row) const { return (At(slot, row) & kSolid) != 0; }
  [[nodiscard]] double Bottom(const CellBox& box) const { return profile_.HeightOf(box.first_row); }
  [[nodiscard]] double Top(const CellBox& box) const { return profile_.HeightOf(box.end_row); }

  [[nodiscard]] bool IsDoorSized(const CellBox& box) const {
    const double top_m = Top(box) - face_.floor_m;
    return box.width_m() >= kNarrowDoor_m && box.width_m() <= kWidestDoor_m &&
           top_m >= kLowestDoor_m && top_m <= kHighestDoor_m;
  }

  [[nodiscard]] Frame FrameOf(const CellBox& box, const CellTest& wall) const {
    const int beside = static_cast<int>(kFrameWithin_m / kCell_m);
    Frame frame;
    // The corner of the room is a side as well.
    const bool left_corner = box.first_slot - box_.first_slot < beside / 2;
    const bool right_corner = box_.end_slot - box.end_slot < beside / 2;
    frame.at_corner = left_corner || right_corner;
    frame.left =
        left_corner ||
        ShareOf({box.first_slot - beside, box.first_slot, box.first_row, box.end_row}, box_, wall) >
            kMinFrame;
    frame.right =
        right_corner ||
        ShareOf({box.end_slot, box.end_slot + beside, box.first_row, box.end_row}, box_, wall) >
            kMinFrame;
    frame.above =
        ShareOf({box.first_slot, box.end_slot, box.end_row, box.end_row + beside}, box_, wall) >
        kMinFrame;
    frame.below =
        ShareOf({box.first_slot, box.end_slot, box.first_row - beside, box.first_row}, box_, wall) >
        kMinFrame;
    frame.to_ceiling = face_.ceiling_seen && box_.end_row - box.end_row < beside;
    return frame;
  }

  [[nodiscard]] double BlindShare(const CellBox& box) const {
    return ShareOf(box, box_, [this](int slot, int row) { return (At(slot, row) & kBlind) != 0; });
  }

  // Dark and shiny things return no depth either; what stands around them does.
  [[nodiscard]] bool IsDarkThing(const CellBox& box) const {
    constexpr int kAround = 2;  // cells: the sides of a shelf
    if (BlindShare(box) <= 0.5) return false;
    const CellBox around{box.first_slot - kAround,
                         box.end_slot + kAround,
                         box.first_row - kAround,
                         box.end_row + kAround};
    return ThingShare(around) > kThingShare;
  }

  // Dark wardrobes: of them depth shows a side board, which stands out from the wall along an
  // upright side of the gap. Where more of a thing is on the board's other side, it is that one's.
  [[nodiscard]] bool IsDarkWardrobe(const CellBox& box) const {
    return BlindShare(box) > 0.5 &&
           (HasSideBoard(box, box.first_slot, -1) || HasSideBoard(box, box.end_slot, 1));
  }

  // `outward`: -1 to the left of `side`, 1 to the right.
  [[nodiscard]] bool HasSideBoard(const CellBox& box, int side, int outward) const {
    constexpr int kNear = 3;     // cells on both sides: depth is missing at its edges too
    constexpr int kBeyond = 12;  // cells: the width of a narrow shelf
    int num_rows = 0;
    for (int row = box.first_row; row < box.end_row; ++row)
      num_rows += ThingShare({side - kNear, side + kNear, row, row + 1}) > 0 ? 1 : 0;
    const int from = side + outward * (kNear + 1);
    const int to = side + outward * kBeyond;
    const CellBox beyond{std::min(from, to), std::max(from, to), box.first_row, box.end_row};
    return num_rows > kBoardShare * (box.end_row - box.first_row) &&
           ThingShare(beyond) < kBeyondShare;
  }

  [[nodiscard]] double ThingShare(const CellBox& box) const {
    return ShareOf(box, box_, [this](int slot, int row) { return (At(slot, row) & kThing) != 0; });
  }

  [[nodiscard]] FaceOpening OpeningOf(const CellBox& box, OpeningKind kind) const {
    FaceOpening opening;
    opening.kind = kind;
    opening.from_m = profile_.PositionOf(box.first_slot);
    opening.to_m = profile_.PositionOf(box.end_slot);
    opening.bottom_m = Bottom(box);
    opening.top_m = Top(box);
    if (kind != OpeningKind::kWindow) opening.bottom_m = face_.floor_m;
    return opening;
  }

  // Whether what passes the test goes down to the floor, in a part of the box's width at least
  // where things stand before the rest. A wall seen below the box says that it does not.
  [[nodiscard]] bool ReachesFloor(const CellBox& box, const CellTest& test) const {
    if (Bottom(box) <= face_.floor_m + kThreshold_m) return true;
    const int low_row = box_.first_row + static_cast<int>(kThreshold_m / kCell_m);
    int num_reaching = 0;
    int num_wall = 0;
    for (int slot = box.first_slot; slot < box.end_slot; ++slot) {
      int num_cells = 0;
      for (int row = box_.first_row; row < box.first_row; ++row)
        num_cells += IsSolid(slot, row) && !test(slot, row) ? 1 : 0;
      const CellBox foot{slot, slot + 1, box_.first_row, low_row};
      const bool is_wall = num_cells >= kSillCells;
      num_wall += is_wall ? 1 : 0;
      num_reaching += !is_wall && ShareOf(foot, box_, test) > 0 ? 1 : 0;
    }
    const double least = kFootShare * (box.end_slot - box.first_slot);
    return num_reaching >= least && num_wall < least;
  }

  // Windows in what hangs together with places behind dark furniture: rectangles that nothing
  // interrupts, between jambs over a sill.
  void AddWindowsWithin(const CellBox& box,
                        const CellTest& gap,
                        std::vector<FaceOpening>& found) const {
    for (const CellBox& pane : FullRectanglesOf(box, gap, kMostPanes)) {
      const Frame frame = FrameOf(pane, [this](int slot, int row) { return IsSolid(slot, row); });
      const bool framed = frame.left && frame.right && frame.below && !frame.at_corner;
      if (!framed || !IsUsualWindow(pane) || ReachesFloor(pane, gap)) continue;
      if (const auto window = Classified(pane, false)) found.push_back(*window);
    }
  }

  // At the upper border of what was looked at depth is missing in corners of rooms as well: what
  // ends in both has to be as large as a window that people look out of, and a rectangle.
  [[nodiscard]] bool IsUsualWindow(const CellBox& box) const {
    const double fill = ShareOf(
        box, box_, [this](int slot, int row) { return (At(slot, row) & (kOpen | kBlind)) != 0; });
    return box.width_m() >= kUsualWidth_m && box.height_m() >= kUsualHeight_m && fill > kPaneFill;
  }

  [[nodiscard]] std::optional<FaceOpening> Classified(const CellBox& box,
                                                      bool reaches_floor) const {
    const Frame frame = FrameOf(box, [this](int slot, int row) { return IsSolid(slot, row); });
    const double behind =
        ShareOf(box, box_, [this](int slot, int row) { return (At(slot, row) & kBehind) != 0; });
    const double blind = BlindShare(box);
    if (IsDarkThing(box)) return std::nullopt;
    return reaches_floor ? AtFloor(box, frame, behind, blind) : Above(box, frame, behind, blind);
  }

  [[nodiscard]] std::optional<FaceOpening> AtFloor(const CellBox& box,
                                                   const Frame& frame,
                                                   double behind,
                                                   double blind) const {
    if (Top(box) - face_.floor_m < kLowestDoor_m || box.width_m() < kNarrowDoor_m)
      return std::nullopt;
    if (frame.num_sides() < 2 || IsDarkWardrobe(box)) return std::nullopt;
    const bool edge_seen = frame.above || frame.to_ceiling;
    // What is as wide as one leaf, between two jambs, is a door more often than not.
    const bool by_width = !edge_seen && frame.left && frame.right && box.width_m() <= kWidestLeaf_m;
    const bool is_door = (frame.above || by_width) && IsDoorSized(box);
    FaceOpening opening = OpeningOf(box, is_door ? OpeningKind::kDoor : OpeningKind::kPassage);
    opening.confidence = 0.35 + 0.15 * frame.num_sides();
    if (behind < 0.5 && blind > 0.5) {
      opening.confidence -= 0.1;
      opening.note = "nothing was measured behind it";
    } else if (behind < 0.5) {
      opening.confidence -= 0.3;
      opening.note = "not deep: a niche, or a leaf that stands back";
    }
    if (!edge_seen) {
      opening.confidence -= 0.15;
      opening.note = is_door ? "its upper edge was not seen: a door by its width"
                             : "its upper edge was not seen";
    }
    opening.confidence = std::clamp(opening.confidence, 0.05, 0.95);
    return opening;
  }

  [[nodiscard]] std::optional<FaceOpening> Above(const CellBox& box,
                                                 const Frame& frame,
                                                 double behind,
                                                 double blind) const {
    if (frame.num_sides() < 3 || !frame.below) return std::nullopt;
    if (blind > 0.5 && frame.at_corner && !frame.above && !IsUsualWindow(box)) return std::nullopt;
    FaceOpening opening = OpeningOf(box, OpeningKind::kWindow);
    opening.confidence = 0.2 + 0.15 * frame.num_sides();
    if (blind > 0.5) {
      opening.confidence -= 0.1;
      opening.note = "nothing was measured in it: glass, a mirror or a screen";
    } else if (behind < 0.5) {
      opening.confidence -= 0.25;
      opening.note = "not deep: a niche, or a window with something before its pane";
    }
    opening.confidence = std::clamp(opening.confidence, 0.05, 0.95);
    return opening;
  }

  const WallProfile& profile_;
  const WallFace& face_;
  CellBox box_;
};

bool Overlap(const FaceOpening& a, const FaceOpening& b) {
  return a.from_m < b.to_m && b.from_m < a.to_m && a.bottom_m < b.top_m && b.bottom_m < a.top_m;
}

// Adds those that lie over none that is known.
void AddNew(std::vector<FaceOpening> more, std::vector<FaceOpening>& found) {
  for (FaceOpening& opening : more) {
    const bool known = std::any_of(found.begin(), found.end(), [&](const FaceOpening& other) {
      return Overlap(opening, other);
    });
    if (!known) found.push_back(std::move(opening));
  }
}

// Windows of which parts were found as gaps are as large as what is set back around these.
void AddAround(std::vector<FaceOpening> panes, std::vector<FaceOpening>& found) {
  for (FaceOpening& pane : panes) {
    const bool within = std::any_of(found.begin(), found.end(), [&](const FaceOpening& other) {
      return other.kind != OpeningKind::kWindow && Overlap(pane, other);
    });
    if (within) continue;
    for (const FaceOpening& other : found) {
      if (Overlap(pane, other)) pane.confidence = std::max(pane.confidence, other.confidence);
    }
    std::erase_if(found, [&](const FaceOpening& other) { return Overlap(pane, other); });
    found.push_back(std::move(pane));
  }
}

void SortByPosition(std::vector<FaceOpening>& found) {
  std::stable_sort(found.begin(), found.end(), [](const FaceOpening& a, const FaceOpening& b) {
    return a.from_m < b.from_m;
  });
}

// Windows of one height beside each other are the sashes of one.
void JoinSashes(std::vector<FaceOpening>& found) {
  SortByPosition(found);
  for (std::size_t n = 0; n < found.size(); ++n) {
    for (std::size_t k = n + 1; k < found.size();) {
      FaceOpening& a = found[n];
      const FaceOpening& b = found[k];
      const bool is_sash = a.kind == OpeningKind::kWindow && b.kind == OpeningKind::kWindow &&
                           b.from_m - a.to_m < kMullion_m &&
                           std::abs(a.bottom_m - b.bottom_m) < kLevel_m &&
                           std::abs(a.top_m - b.top_m) < kLevel_m;
      if (!is_sash) {
        ++k;
        continue;
      }
      a.to_m = std::max(a.to_m, b.to_m);
      a.bottom_m = std::min(a.bottom_m, b.bottom_m);
      a.top_m = std::max(a.top_m, b.top_m);
      a.confidence = std::max(a.confidence, b.confidence);
      found.erase(found.begin() + static_cast<std::ptrdiff_t>(k));
    }
  }
}

}  // namespace

std::vector<FaceOpening> FindOpenings(const WallProfile& profile, const WallFace& face) {
  std::vector<FaceOpening> found;
  const FaceSearch search(profile, face);
  search.AddGaps(found);
  std::vector<FaceOpening> leaves;
  search.AddLeaves(leaves);
  AddNew(std::move(leaves), found);
  AddNew(FindCasings(profile, face), found);
  std::vector<FaceOpening> panes;
  search.AddPanes(panes);
  AddAround(std::move(panes), found);
  JoinSashes(found);
  return found;
}

}  // namespace deepslam::layout
