#include "deepslam/layout/face_rectangles.h"

#include <algorithm>
#include <cstddef>
#include <vector>

#include <gtest/gtest.h>

#include "deepslam/core/random.h"

namespace deepslam::layout {
namespace {

constexpr int kSlots = 9;
constexpr int kRows = 7;

int CellsOf(const CellBox& box) {
  return (box.end_slot - box.first_slot) * (box.end_row - box.first_row);
}

bool AllPass(const CellBox& box, const CellTest& test) {
  for (int slot = box.first_slot; slot < box.end_slot; ++slot) {
    for (int row = box.first_row; row < box.end_row; ++row) {
      if (!test(slot, row)) return false;
    }
  }
  return true;
}

// By looking at every rectangle.
int CellsOfLargest(const CellBox& within, const CellTest& test) {
  int most = 0;
  for (int s0 = within.first_slot; s0 < within.end_slot; ++s0) {
    for (int s1 = s0 + 1; s1 <= within.end_slot; ++s1) {
      for (int r0 = within.first_row; r0 < within.end_row; ++r0) {
        for (int r1 = r0 + 1; r1 <= within.end_row; ++r1) {
          const CellBox box{s0, s1, r0, r1};
          if (AllPass(box, test)) most = std::max(most, CellsOf(box));
        }
      }
    }
  }
  return most;
}

TEST(FullRectangles, AreTheLargestThatNothingInterrupts) {
  Random random(3);
  const CellBox within{2, 2 + kSlots, 5, 5 + kRows};
  for (int n = 0; n < 50; ++n) {
    std::vector<bool> passes(static_cast<std::size_t>(kSlots * kRows));
    for (std::size_t cell = 0; cell < passes.size(); ++cell)
      passes[cell] = random.Uniform(0, 1) < 0.7;
    const CellTest test = [&](int slot, int row) {
      return passes[static_cast<std::size_t>((slot - within.first_slot) * kRows + row -
                                             within.first_row)];
    };
    const std::vector<CellBox> boxes = FullRectanglesOf(within, test, 4);
    ASSERT_FALSE(boxes.empty());
    EXPECT_EQ(CellsOf(boxes[0]), CellsOfLargest(within, test));
    for (std::size_t k = 0; k < boxes.size(); ++k) {
      EXPECT_TRUE(AllPass(boxes[k], test));
      for (std::size_t other = 0; other < k; ++other) {
        EXPECT_GE(CellsOf(boxes[other]), CellsOf(boxes[k]));
        EXPECT_TRUE(boxes[other].end_slot <= boxes[k].first_slot ||
                    boxes[k].end_slot <= boxes[other].first_slot ||
                    boxes[other].end_row <= boxes[k].first_row ||
                    boxes[k].end_row <= boxes[other].first_row);
      }
    }
  }
}

TEST(FullRectangles, OfNothingAreNone) {
  const CellTest none = [](int, int) { return false; };
  const CellTest all = [](int, int) { return true; };
  EXPECT_TRUE(FullRectanglesOf({0, 5, 0, 5}, none, 3).empty());
  EXPECT_TRUE(FullRectanglesOf({}, all, 3).empty());
  EXPECT_TRUE(FullRectanglesOf({4, 2, 0, 5}, all, 3).empty());
  EXPECT_TRUE(FullRectanglesOf({0, 5, 0, 5}, all, 0).empty());
  EXPECT_EQ(FullRectanglesOf({0, 5, 0, 5}, all, 3).size(), 1U);
}

}  // namespace
}  // namespace deepslam::layout
