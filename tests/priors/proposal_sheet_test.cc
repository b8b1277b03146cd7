#include "deepslam/priors/proposal_sheet.h"

#include <numbers>

#include <gtest/gtest.h>

namespace deepslam::priors {
namespace {

// A post at the front (+x), low, and one at the left (+y), high.
VoxelGrid TwoPosts() {
  VoxelGrid grid;
  for (int x = 56; x < 60; ++x) {
    for (int y = 30; y < 34; ++y) {
      for (int z = 4; z < 20; ++z) grid.occupied[VoxelGrid::Index(x, y, z)] = 1;
    }
  }
  for (int x = 30; x < 34; ++x) {
    for (int y = 56; y < 60; ++y) {
      for (int z = 44; z < 60; ++z) grid.occupied[VoxelGrid::Index(x, y, z)] = 1;
    }
  }
  return grid;
}

// Middle and mean grey of what is drawn in the upper or in the lower half.
struct Blob {
  double u = 0;
  double grey = 0;
  int count = 0;
};

Blob Half(const Image<std::uint8_t>& image, bool upper) {
  Blob blob;
  for (int v = upper ? 0 : image.height() / 2; v < (upper ? image.height() / 2 : image.height());
       ++v) {
    for (int u = 0; u < image.width(); ++u) {
      if (image(u, v) == 255) continue;
      blob.u += u;
      blob.grey += image(u, v);
      ++blob.count;
    }
  }
  if (blob.count > 0) {
    blob.u /= blob.count;
    blob.grey /= blob.count;
  }
  return blob;
}

TEST(DrawShape, ShowsItFromWhereTheCameraStands) {
  const double middle = 0.5 * propose::kCropSide;
  const Image<std::uint8_t> front = DrawShape({TwoPosts(), 0, 0});
  const Blob low = Half(front, false);
  const Blob high = Half(front, true);
  ASSERT_GT(low.count, 50);
  ASSERT_GT(high.count, 50);
  EXPECT_NEAR(low.u, middle, 3) << "what is in front stands in the middle";
  EXPECT_GT(high.u, middle + 30) << "the object's left is on the right";
  EXPECT_GT(low.grey, high.grey + 40) << "nearer is lighter";

  const Image<std::uint8_t> left = DrawShape({TwoPosts(), 0.5 * std::numbers::pi, 0});
  EXPECT_LT(Half(left, false).u, middle - 30) << "seen from its left its front is on the left";
  EXPECT_NEAR(Half(left, true).u, middle, 3);

  const Image<std::uint8_t> above = DrawShape({TwoPosts(), 0, 0.5 * std::numbers::pi});
  EXPECT_GT(Half(above, false).count, 10) << "from above the front is below";
}

TEST(DrawProposalSheet, LeavesAPlaceForWhatIsMissing) {
  ProposalRow row;
  row.shapes = {std::nullopt, SeenShape{TwoPosts(), 0, 0}};
  const ColourImage sheet = DrawProposalSheet(std::vector<ProposalRow>{row});
  EXPECT_EQ(sheet.width(), 4 * propose::kCropSide);
  EXPECT_EQ(sheet.height(), propose::kCropSide);
  int drawn = 0;
  int elsewhere = 0;
  for (int v = 0; v < sheet.height(); ++v) {
    for (int u = 0; u < sheet.width(); ++u) {
      const bool ink = sheet(u, v).r != 255;
      (u >= 3 * propose::kCropSide ? drawn : elsewhere) += ink ? 1 : 0;
    }
  }
  EXPECT_GT(drawn, 100);
  EXPECT_EQ(elsewhere, 0);
  EXPECT_GT(DrawProposalSheet({}).width(), 0);
}

}  // namespace
}  // namespace deepslam::priors
