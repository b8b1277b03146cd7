#include "deepslam/geometry/top_layer.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam {
namespace {

void Add(int count, double low_m, double high_m, std::vector<double>& heights_m) {
  for (int n = 0; n < count; ++n) heights_m.push_back(low_m + (high_m - low_m) * n / count);
}

double MiddleOfTop(std::vector<double> heights_m) {
  std::ranges::sort(heights_m);
  const std::span<const double> top_m = TopLayer(heights_m, 0.05);
  return top_m[top_m.size() / 2];
}

TEST(TopLayer, IsTheFullestOne) {
  std::vector<double> heights_m;
  Add(100, 0.0, 0.7, heights_m);
  Add(200, 0.72, 0.75, heights_m);
  Add(60, 0.80, 1.1, heights_m);  // of what stands on it
  EXPECT_NEAR(MiddleOfTop(heights_m), 0.735, 0.01);
}

TEST(TopLayer, IsAboveTheBoardsUnderIt) {
  std::vector<double> heights_m;
  Add(200, 0.19, 0.21, heights_m);
  Add(120, 0.72, 0.75, heights_m);  // half hidden by what stands on it
  Add(50, 0.84, 0.86, heights_m);
  EXPECT_NEAR(MiddleOfTop(heights_m), 0.735, 0.01);
}

TEST(TopLayer, OfNothingIsEmpty) { EXPECT_TRUE(TopLayer({}, 0.05).empty()); }

}  // namespace
}  // namespace deepslam
