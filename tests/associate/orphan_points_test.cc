#include "deepslam/associate/orphan_points.h"

#include <algorithm>
#include <vector>

#include <gtest/gtest.h>

namespace deepslam::associate {
namespace {

OrphanPoints::Points Line(int num_points, float y) {
  OrphanPoints::Points points;
  for (int i = 0; i < num_points; ++i) points.emplace_back(static_cast<float>(i), y, 0.0F);
  return points;
}

TEST(OrphanPoints, SetsThatFitComeBackWhole) {
  OrphanPoints kept(300);
  const std::size_t first = kept.Keep(Line(100, 1));
  const std::size_t second = kept.Keep(Line(200, 2));
  EXPECT_EQ(kept.num_points(), 300U);
  EXPECT_EQ(kept.Take(second), Line(200, 2));
  EXPECT_EQ(kept.Take(first), Line(100, 1));
  EXPECT_EQ(kept.num_points(), 0U);
}

TEST(OrphanPoints, HoldsNoMoreThanItsBoundHoweverManyCome) {
  OrphanPoints kept(1000);
  for (int i = 0; i < 400; ++i) {
    kept.Keep(Line(100, static_cast<float>(i)));
    ASSERT_LE(kept.num_points(), 1000U) << "after set " << i;
  }
}

TEST(OrphanPoints, ThinsEarlierAndLaterSetsAlikeAndEvenly) {
  OrphanPoints kept(1000);
  std::vector<std::size_t> keys;
  for (int i = 0; i < 30; ++i) keys.push_back(kept.Keep(Line(101, static_cast<float>(i))));
  const std::size_t size = kept.Take(keys.front()).size();
  EXPECT_LT(size, 101U);
  for (int i = 1; i < 30; ++i) {
    const OrphanPoints::Points set = kept.Take(keys[static_cast<std::size_t>(i)]);
    ASSERT_EQ(set.size(), size);
    EXPECT_EQ(set.front(), Line(1, static_cast<float>(i)).front());
    const float step = set[1].x() - set[0].x();
    for (std::size_t p = 0; p < set.size(); ++p) {
      EXPECT_EQ(set[p].x(), step * static_cast<float>(p));
    }
  }
}

TEST(OrphanPoints, OnePointOfEachStays) {
  OrphanPoints kept(10);
  std::vector<std::size_t> keys;
  for (int i = 0; i < 9; ++i) keys.push_back(kept.Keep(Line(50, static_cast<float>(i))));
  for (const std::size_t key : keys) EXPECT_GE(kept.Take(key).size(), 1U);
}

TEST(OrphanPoints, WhatIsTakenMakesRoom) {
  OrphanPoints kept(100);
  kept.Take(kept.Keep(Line(100, 1)));
  EXPECT_EQ(kept.Take(kept.Keep(Line(100, 2))).size(), 100U);
}

}  // namespace
}  // namespace deepslam::associate
