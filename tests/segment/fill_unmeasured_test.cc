#include "deepslam/segment/fill_unmeasured.h"

#include <gtest/gtest.h>

namespace deepslam::segment {
namespace {

constexpr int kWidth = 40;
constexpr int kHeight = 30;
constexpr double kGap_m = 0.1;

// Focal length 100 px: at 1 m, 10 px are 0.1 m.
PinholeCamera Camera() { return {kWidth, kHeight, 100, 100, 20, 15}; }

Region WholeImage() {
  Region region;
  region.u_max = kWidth - 1;
  region.v_max = kHeight - 1;
  return region;
}

// Two posts of an object at `depth_m` in columns 10-12 and 18-20, a measured wall elsewhere but
// between them.
struct Posts {
  DepthImage depth_m{kWidth, kHeight, 3.0F};
  Mask mask{kWidth, kHeight};
};

Posts MakePosts(float depth_m, int first_of_second = 18) {
  Posts posts;
  for (int v = 5; v < 25; ++v) {
    for (int u = 10; u < first_of_second + 3; ++u) {
      const bool post = u < 13 || u >= first_of_second;
      posts.depth_m(u, v) = post ? depth_m : 0.0F;
      posts.mask(u, v) = post ? 1 : 0;
    }
  }
  return posts;
}

int Count(const Mask& mask) {
  int count = 0;
  for (const auto value : mask) count += value != 0 ? 1 : 0;
  return count;
}

TEST(FillUnmeasured, ClosesAGapBetweenPartsOfTheObject) {
  Posts posts = MakePosts(1.0F);
  Mask taken(kWidth, kHeight);
  FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, posts.mask);
  EXPECT_EQ(Count(posts.mask), 20 * 11);
  EXPECT_EQ(Count(taken), 20 * 5);
}

TEST(FillUnmeasured, LeavesWhatWasMeasuredBehindTheGap) {
  Posts posts = MakePosts(1.0F);
  const int before = Count(posts.mask);
  for (int v = 5; v < 25; ++v) posts.depth_m(15, v) = 3.0F;  // the wall, seen through the gap
  Mask taken(kWidth, kHeight);
  FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, posts.mask);
  EXPECT_EQ(Count(posts.mask), before);
}

TEST(FillUnmeasured, LeavesAShadowBesideTheObject) {
  Posts posts = MakePosts(1.0F);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 21; u < 26; ++u) posts.depth_m(u, v) = 0.0F;
  }
  Mask taken(kWidth, kHeight);
  FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, posts.mask);
  for (int v = 0; v < kHeight; ++v) EXPECT_EQ(posts.mask(21, v), 0) << v;
}

TEST(FillUnmeasured, MeasuresTheGapInMetres) {
  // Eight pixels are 0.08 m at 1 m and 0.16 m at 2 m.
  for (const float depth_m : {1.0F, 2.0F}) {
    Posts posts = MakePosts(depth_m, 21);
    const int before = Count(posts.mask);
    Mask taken(kWidth, kHeight);
    FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, posts.mask);
    EXPECT_EQ(Count(posts.mask) > before, depth_m < 1.5F) << depth_m;
  }
}

TEST(FillUnmeasured, GivesAPixelToOneObjectAlone) {
  // The second object's bars lie above and below the gap of the first one's posts.
  Posts posts = MakePosts(1.0F);
  Mask bars(kWidth, kHeight);
  for (int u = 13; u < 18; ++u) {
    for (const int v : {5, 12}) {
      posts.depth_m(u, v) = 1.0F;
      bars(u, v) = 1;
    }
  }
  Mask taken(kWidth, kHeight);
  FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, posts.mask);
  FillUnmeasured(posts.depth_m, Camera(), WholeImage(), kGap_m, taken, bars);
  for (int v = 0; v < kHeight; ++v) {
    for (int u = 0; u < kWidth; ++u) EXPECT_LE(posts.mask(u, v) + bars(u, v), 1) << u << ' ' << v;
  }
}

TEST(FillUnmeasured, StaysInsideTheBox) {
  Posts posts = MakePosts(1.0F);
  Region region = WholeImage();
  region.v_min = 10;
  region.v_max = 12;
  const int before = Count(posts.mask);
  Mask taken(kWidth, kHeight);
  FillUnmeasured(posts.depth_m, Camera(), region, kGap_m, taken, posts.mask);
  EXPECT_EQ(Count(posts.mask), before + 3 * 5);
}

}  // namespace
}  // namespace deepslam::segment
